use nalgebra::Rotation3;

use super::super::test_stacks::blob;
use super::*;

#[test]
fn the_order_by_heat_does_not_depend_on_place_and_size() {
    let mesh = blob(2);
    let turn = Rotation3::new(Vector3::new(0.4, 0.8, -0.1));
    let mut moved = mesh.clone();
    for p in &mut moved.positions {
        *p = turn * *p * 3.0 + Vector3::new(10.0, -4.0, 2.0);
    }
    let [own, theirs] = by_heat([&mesh, &moved], 0);
    assert_eq!(own.count, 8);
    assert_eq!(own.values.len(), 8 * 162);
    for (a, b) in own.values.iter().zip(&theirs.values) {
        assert!((a - b).abs() < 1e-3, "{a}, {b}");
    }
}

#[test]
fn ranks_are_shares_of_the_area_in_the_order_of_the_values() {
    let mesh = blob(2);
    let areas = vertex_areas(&mesh);
    #[expect(clippy::cast_possible_truncation, reason = "features are single")]
    let heights: Vec<f32> = mesh.positions.iter().map(|p| p.y as f32).collect();
    let features = Features {
        count: 1,
        values: heights.clone(),
    };
    let ranks = ranked(&features, &mesh).values;
    for v in 0..162 {
        let below: f64 = (0..162)
            .filter(|w| heights[*w] < heights[v])
            .map(|w| areas[w])
            .sum();
        let level: f64 = (0..162)
            .filter(|w| heights[*w].to_bits() == heights[v].to_bits())
            .map(|w| areas[w])
            .sum();
        let total: f64 = areas.iter().sum();
        let rank = f64::from(ranks[v]) * total;
        assert!((below - 1e-6..=below + level + 1e-6).contains(&rank));
    }
}

#[test]
fn heat_on_a_sphere_says_nothing() {
    let [sphere, other] = [test_shapes::icosphere(3), blob(2)];
    assert_eq!(
        by_heat([&sphere, &other], 0),
        [Features::default(), Features::default()]
    );
}

#[test]
fn what_looks_up_is_the_same_in_a_copy_that_was_turned_about_that_axis() {
    let mesh = blob(2);
    let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), 1.1);
    let mut turned = mesh.clone();
    turned.positions.iter_mut().for_each(|p| *p = turn * *p);
    let [own, theirs] = [&mesh, &turned].map(|m| upward(m, Some(Vector3::y() * 7.0)));
    assert_eq!(own.count, 1);
    for (a, b) in own.values.iter().zip(&theirs.values) {
        assert!((a - b).abs() < 1e-5);
    }
    assert!(own.values.iter().any(|x| *x > 0.9) && own.values.iter().any(|x| *x < -0.9));
    assert_eq!(upward(&mesh, None), Features::default());
    assert_eq!(upward(&mesh, Some(Vector3::zeros())), Features::default());
}
