use nalgebra::Point3;

use super::*;

mod awkward;
mod relief;
mod same;
mod spread;

/// Colors as a function of the place, from 0 to 1, with waves of about this many radians a unit.
fn painted(mesh: &TriMesh, waves: f64) -> Vec<[f64; 3]> {
    let wave = |x: f64| 0.5 + 0.5 * x.sin();
    let color = |p: &Point3<f64>| {
        [
            wave(waves * p.x + 0.7),
            wave(waves * (0.8 * p.y + 0.5 * p.z)),
            wave(waves * (p.z - 0.3 * p.x) + 2.0),
        ]
    };
    mesh.positions.iter().map(color).collect()
}

fn colored<'a>(mesh: &'a TriMesh, colors: &'a [[f64; 3]]) -> Source<'a> {
    Source {
        mesh,
        colors: Some(colors),
        heights: None,
    }
}

fn run(source: &Source, target: &TriMesh, params: &TransferParams) -> Transferred {
    transfer(source, target, None, params, &mut |_| {}).unwrap()
}

/// Mean difference of colors, in 255ths.
fn mean_difference(found: &[[f64; 3]], truth: &[[f64; 3]]) -> f64 {
    assert_eq!(found.len(), truth.len());
    let all = found.iter().flatten().zip(truth.iter().flatten());
    255.0 * all.map(|(a, b)| (a - b).abs()).sum::<f64>() / (3 * truth.len()) as f64
}

/// What every result must be like.
fn assert_whole(done: &Transferred, source: &TriMesh, target: &TriMesh) {
    let count = done.finer.mesh.positions.len();
    assert_eq!(done.finer.originals(), target.positions.len());
    assert_eq!(
        done.finer.mesh.positions[..done.finer.originals()],
        target.positions[..]
    );
    assert_eq!(done.sources.len(), count);
    assert_eq!(done.rotations.len(), count);
    assert_eq!(done.costs.len(), count);
    assert!(
        done.sources
            .iter()
            .all(|s| (*s as usize) < source.positions.len())
    );
    assert!(done.costs.iter().all(|c| c.is_finite() && *c >= 0.0));
    assert!(
        done.rotations
            .iter()
            .all(|r| r.abs() <= std::f32::consts::PI + 1e-6)
    );
    if let Some(colors) = &done.colors {
        assert_eq!(colors.len(), count);
        assert!(
            colors
                .iter()
                .flatten()
                .all(|x| (-1e-6..=1.0 + 1e-6).contains(x))
        );
    }
    if let Some(heights) = &done.heights {
        assert_eq!(heights.len(), count);
        assert!(heights.iter().all(|h| h.is_finite()));
    }
}
