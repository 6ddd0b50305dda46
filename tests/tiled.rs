//! Scans completed in tiles, as they would be on several machines, on small scans with known truth.

mod common;

use std::collections::BTreeSet;

use common::{assert_only_appended, cut, loops, to_scan, torus};
use nalgebra::Point3;
use relievo::base::{BaseChoice, FitParams};
use relievo::completion::{
    CompleteParams, CompletionError, CompletionReport, GrownTile, Method, TileError, TileParams,
    TilePlan, TileTask, TiledCompletion, complete, complete_tiled,
};
use relievo::mesh::{LoopKind, check};
use relievo::scan::{Format, Scan, WriteOptions, write_to};
use relievo::stats;
use relievo::synth::{Kind, Part, SynthParams, scan as synthesize};

fn synthetic(kind: Kind, vertices: usize, hole: f64) -> Scan {
    let params = SynthParams {
        kind,
        vertices,
        part: Part::hole(hole),
        ..SynthParams::default()
    };
    synthesize(&params)
        .expect("the parameters are in range")
        .scan
}

/// A torus with bumps and two holes: no kind of base fits it.
fn holed_torus() -> Scan {
    let holes = [
        (Point3::new(42.0, 0.0, 0.0), 9.0),
        (Point3::new(-30.0, 0.0, 12.0), 6.0),
    ];
    cut(&to_scan(&torus()), |p| {
        (holes.iter()).all(|(middle, radius)| (p - middle).norm() > *radius)
    })
}

/// Narrow windows and overlaps, so that small scans have several tiles.
fn narrow() -> CompleteParams {
    CompleteParams {
        window: Some(3),
        sites: 1000,
        ..CompleteParams::default()
    }
}

/// Tiles with an overlap of some median edges of the scan.
fn tiles(scan: &Scan, tile: usize, edges: f64) -> TileParams {
    let edge = relievo::mesh::median_edge(&scan.mesh()).expect("it has faces");
    TileParams {
        tile,
        overlap: Some(edges * edge),
    }
}

fn as_ply(scan: &Scan) -> Vec<u8> {
    let mut bytes = Vec::new();
    let options = WriteOptions::default();
    write_to(scan, &mut bytes, Format::Ply, &options, "test").expect("memory takes it");
    bytes
}

/// Completes in tiles, and checks what holds for every completion and for every task.
#[track_caller]
fn in_tiles(scan: &Scan, params: &CompleteParams, tiles: &TileParams) -> TiledCompletion {
    let mut plan = TilePlan::new(scan, params, tiles, &mut |_| {}).expect("it can be tiled");
    let mut most = 0;
    for tile in plan.rounds().into_iter().flatten() {
        let task = plan.task(tile).expect("earlier rounds are back");
        assert!(
            task.vertices() <= tiles.tile && task.targets() <= task.vertices(),
            "tile {tile} has {} vertices",
            task.vertices()
        );
        most = most.max(task.vertices());
        plan.put(tile, task.grow(&mut |_| {}))
            .expect("it is its own");
    }
    let done = plan.finish(&mut |_| {}).expect("all are back");
    assert_eq!(done.tiling.most_vertices, most);
    assert_only_appended(scan, &done.scan);
    assert_eq!(check(&done.scan.mesh()), Ok(()));
    done
}

/// The loops that were filled, with the numbers of their new vertices.
fn filled(report: &CompletionReport) -> Vec<(Vec<usize>, usize, usize)> {
    let holes = report.filled.iter();
    holes
        .map(|hole| (hole.loops.clone(), hole.vertices, hole.faces))
        .collect()
}

#[test]
fn one_tile_that_holds_everything_gives_what_is_given_untiled() {
    for scan in [
        synthetic(Kind::GolfBall, 2000, 0.05),
        synthetic(Kind::Bricks, 2000, 0.05),
        holed_torus(),
    ] {
        let params = CompleteParams {
            sites: 1000,
            ..CompleteParams::default()
        };
        let untiled = complete(&scan, &params, &mut |_| {}).expect("it can be completed");
        let tiled = in_tiles(&scan, &params, &TileParams::default());
        assert_eq!((tiled.tiling.tiles, tiled.tiling.rounds), (1, 1));
        assert!(as_ply(&untiled.scan) == as_ply(&tiled.scan), "bytes differ");
        let [a, b] = [untiled.report, tiled.report].map(|mut report| {
            report.seconds.clear();
            format!("{report:?}")
        });
        assert_eq!(a, b);
        assert_eq!(tiled.seams.edges, 0);
        assert_eq!((tiled.seams.heights, tiled.seams.colors), (None, None));
    }
}

#[test]
fn a_hole_much_larger_than_a_tile_is_filled_without_visible_borders() {
    let scan = synthetic(Kind::Waves, 12_000, 0.35);
    let params = narrow();
    let untiled = complete(&scan, &params, &mut |_| {}).expect("it can be completed");
    let done = in_tiles(&scan, &params, &tiles(&scan, 3000, 5.0));
    assert_eq!(filled(&done.report), filled(&untiled.report));
    assert!(done.report.skipped.is_empty());
    let targets = done.report.counts.completed_vertices;
    assert!(
        targets > 3500 && done.tiling.tiles >= 5,
        "{:?}",
        done.tiling
    );
    assert!(done.seams.edges > 200, "{:?}", done.seams);
    // 1 where borders do not show; the mean over hundreds of edges is within a tenth or so by chance.
    let ratio = done.seams.heights.expect("there are borders");
    assert!((0.8..=1.2).contains(&ratio), "{ratio}");
    assert_like_untiled(&done.scan, &untiled.scan);
}

/// The completed part is as rough against the original as it is when completed in one piece.
#[track_caller]
fn assert_like_untiled(tiled: &Scan, untiled: &Scan) {
    let [tiled, untiled] = [tiled, untiled].map(|scan| {
        let comparison = stats::compare(scan).expect("it was completed");
        comparison.roughness_ratio.expect("there is relief")
    });
    for ratio in [tiled, untiled] {
        assert!((0.8..1.25).contains(&ratio), "{tiled}, untiled {untiled}");
    }
    assert!((tiled - untiled).abs() < 0.15, "{tiled}, untiled {untiled}");
}

#[test]
fn colors_have_no_borders_either() {
    let scan = synthetic(Kind::Bricks, 10_000, 0.15);
    let params = narrow();
    let untiled = complete(&scan, &params, &mut |_| {}).expect("it can be completed");
    let done = in_tiles(&scan, &params, &tiles(&scan, 3000, 6.0));
    assert_eq!(filled(&done.report), filled(&untiled.report));
    assert!(done.tiling.tiles >= 2, "{:?}", done.tiling);
    let [heights, colors] =
        [done.seams.heights, done.seams.colors].map(|ratio| ratio.expect("there are borders"));
    assert!(heights <= 1.2 && colors <= 1.2, "{:?}", done.seams);
    assert_like_untiled(&done.scan, &untiled.scan);
    let (before, after) = (scan.colors().unwrap(), done.scan.colors().unwrap());
    for color in &after[before.len()..] {
        assert!(before.contains(color), "{color:?} was not copied");
    }
}

#[test]
fn holes_on_free_form_are_completed_in_tiles() {
    let scan = holed_torus();
    let params = narrow();
    let untiled = complete(&scan, &params, &mut |_| {}).expect("it can be completed");
    let done = in_tiles(&scan, &params, &tiles(&scan, 1200, 5.0));
    assert!(!done.report.base_fits && done.report.free_form.is_some());
    assert!(done.tiling.tiles >= 2, "{:?}", done.tiling);
    assert_eq!(filled(&done.report), filled(&untiled.report));
    assert_eq!(loops(&done.scan.mesh()), []);
    let ratio = done.seams.heights.expect("there are borders");
    assert!(ratio <= 1.2, "{:?}", done.seams);
    assert_like_untiled(&done.scan, &untiled.scan);
}

/// A wall with two holes of some 290 vertices, far from each other.
fn two_holes() -> Scan {
    let params = SynthParams {
        kind: Kind::Bricks,
        vertices: 4000,
        ..SynthParams::default()
    };
    let full = synthesize(&params)
        .expect("the parameters are in range")
        .scan;
    let mesh = full.mesh();
    let edge = relievo::mesh::median_edge(&mesh).expect("it has faces");
    let first = mesh.positions[0];
    let [low, high] = mesh
        .positions
        .iter()
        .fold([first; 2], |[low, high], p| [low.inf(p), high.sup(p)]);
    let middles = [0.25, 0.75].map(|share| low + (high - low) * share);
    cut(&full, |p| {
        (middles.iter()).all(|middle| (p - middle).xy().norm() > 9.0 * edge)
    })
}

#[test]
fn bytes_order_and_threads_change_nothing() {
    let scan = two_holes();
    let (params, tiles) = (narrow(), tiles(&scan, 1350, 5.0));
    let straight = in_tiles(&scan, &params, &tiles);
    // Each hole in two halves, which wait for each other.
    assert_eq!((straight.tiling.tiles, straight.tiling.rounds), (4, 2));
    let on_threads = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.expect("there are threads");
        pool.install(|| in_tiles_far_away(&scan, &params, &tiles))
    };
    let expected = as_ply(&straight.scan);
    for threads in [1, 2] {
        let done = on_threads(threads);
        assert!(
            as_ply(&done.scan) == expected,
            "bytes differ on {threads} threads"
        );
        assert_eq!(done.seams, straight.seams);
        assert_eq!(done.report.searched, straight.report.searched);
    }
    let at_once = complete_tiled(&scan, &params, &tiles, &mut |_| {}).expect("it can be tiled");
    assert!(
        as_ply(&at_once.scan) == expected,
        "bytes differ when all is done here"
    );
}

/// Tasks and results go through bytes, the last tile of a round first, one of them twice, and a task that was given
/// out before is asked for again after its round began to come back.
fn in_tiles_far_away(scan: &Scan, params: &CompleteParams, tiles: &TileParams) -> TiledCompletion {
    let mut plan = TilePlan::new(scan, params, tiles, &mut |_| {}).expect("it can be tiled");
    for round in plan.rounds() {
        let sent: Vec<Vec<u8>> = (round.iter())
            .map(|tile| plan.task(*tile).expect("it is time").to_bytes())
            .collect();
        for (tile, sent) in round.iter().zip(&sent).rev() {
            assert!(plan.task(*tile).expect("it is time").to_bytes() == *sent);
            let grow = || {
                let task = TileTask::from_bytes(sent).expect("it is whole");
                task.grow(&mut |_| {}).to_bytes()
            };
            let grown = grow();
            if *tile == round[0] {
                assert!(grow() == grown, "grown twice, tile {tile} differs");
            }
            for _ in 0..2 {
                let grown = GrownTile::from_bytes(&grown).expect("it is whole");
                plan.put(*tile, grown).expect("it is its own");
            }
            assert!(plan.task(*tile).expect("it is time").to_bytes() == *sent);
        }
    }
    plan.finish(&mut |_| {}).expect("all are back")
}

#[test]
fn small_holes_near_each_other_share_a_tile() {
    let full = SynthParams {
        kind: Kind::Noise,
        vertices: 8000,
        ..SynthParams::default()
    };
    let full = synthesize(&full).expect("the parameters are in range").scan;
    let mesh = full.mesh();
    let edge = relievo::mesh::median_edge(&mesh).expect("it has faces");
    let [low, high] = mesh
        .positions
        .iter()
        .fold([mesh.positions[0]; 2], |[low, high], p| {
            [low.inf(p), high.sup(p)]
        });
    let at = |x: f64, y: f64| low + (high - low).component_mul(&nalgebra::Vector3::new(x, y, 0.5));
    let middles = [at(0.2, 0.2), at(0.3, 0.2), at(0.2, 0.3), at(0.8, 0.8)];
    let scan = cut(&full, |p| {
        (middles.iter()).all(|middle| (p - middle).xy().norm() > 3.0 * edge)
    });
    let plan = |tile| {
        let tiles = tiles(&scan, tile, 6.0);
        TilePlan::new(&scan, &narrow(), &tiles, &mut |_| {}).expect("it can be tiled")
    };
    let plan = plan(2500);
    // A hole and its overlap take some 300 vertices; three of them half a tile at most.
    assert!((1..=2).contains(&plan.tiles()), "{}", plan.tiles());
    let done = in_tiles(&scan, &narrow(), &tiles(&scan, 1500, 6.0));
    assert_eq!(done.report.filled.len(), 4);
    let mesh = done.scan.mesh();
    assert!(loops(&mesh).iter().all(|l| l.kind == LoopKind::Rim));
}

#[test]
fn exhaustive_search_and_audits_can_be_tiled() {
    let scan = synthetic(Kind::GolfBall, 3000, 0.06);
    let tiles = tiles(&scan, 700, 4.0);
    let exhaustive = CompleteParams {
        method: Method::Exhaustive,
        window: Some(2),
        rotations: Some(1),
        ..CompleteParams::default()
    };
    let done = in_tiles(&scan, &exhaustive, &tiles);
    assert!(done.tiling.tiles >= 2 && done.report.skipped.is_empty());
    assert_eq!(
        done.report.searched.global,
        done.report.counts.completed_vertices
    );
    let audited = CompleteParams {
        audit: 0.2,
        ..narrow()
    };
    let done = in_tiles(&scan, &audited, &tiles);
    let recall = done.report.searched.recall.expect("it was asked for");
    let share = recall.audited as f64 / done.report.counts.completed_vertices as f64;
    // Five standard errors of about 180 draws.
    assert!(
        (0.05..0.35).contains(&share) && recall.all > 0.5,
        "{recall:?}"
    );
}

#[test]
fn tiles_among_others_whose_sources_are_scattered_have_something_to_copy_from() {
    let scan = synthetic(Kind::Noise, 12_000, 0.2);
    let exhaustive = CompleteParams {
        method: Method::Exhaustive,
        window: Some(2),
        rotations: Some(1),
        ..CompleteParams::default()
    };
    let done = in_tiles(&scan, &exhaustive, &tiles(&scan, 400, 5.0));
    assert!(done.tiling.rounds > 5, "{:?}", done.tiling);
    assert!(done.report.skipped.is_empty(), "{:?}", done.report.skipped);
}

#[test]
fn tiles_without_room_for_the_scan_say_so() {
    let scan = synthetic(Kind::Bricks, 3000, 0.2);
    let few = tiles(&scan, 100, 0.0);
    let mut plan = TilePlan::new(&scan, &narrow(), &few, &mut |_| {}).expect("it can be tiled");
    for tile in plan.rounds().into_iter().flatten() {
        let grown = plan.task(tile).expect("it is time").grow(&mut |_| {});
        plan.put(tile, grown).expect("it is its own");
    }
    let done = plan.finish(&mut |_| {}).expect("all are back");
    let reason = &done.report.skipped[0].reason;
    assert!(reason.contains("larger --tile"), "{reason}");
}

#[test]
fn what_cannot_be_tiled_is_refused() {
    let scan = synthetic(Kind::GolfBall, 3000, 0.05);
    let refused = |params: &CompleteParams, tiles: &TileParams| {
        TilePlan::new(&scan, params, tiles, &mut |_| {}).expect_err("it cannot be tiled")
    };
    let paper = CompleteParams {
        method: Method::Paper,
        ..CompleteParams::default()
    };
    let tiles = TileParams::default();
    let error = refused(&paper, &tiles);
    assert_eq!(error, CompletionError::Tile(TileError::ByPaper));
    assert!(error.to_string().contains("--method coherent"), "{error}");
    let bootstrap = CompleteParams {
        bootstrap: true,
        ..CompleteParams::default()
    };
    let error = refused(&bootstrap, &tiles);
    assert_eq!(error, CompletionError::Tile(TileError::Bootstrap));
    for tiles in [
        TileParams {
            tile: 99,
            overlap: None,
        },
        TileParams {
            overlap: Some(-1.0),
            ..tiles
        },
        TileParams {
            overlap: Some(f64::NAN),
            ..tiles
        },
        TileParams {
            overlap: Some(f64::INFINITY),
            ..tiles
        },
    ] {
        let error = refused(&CompleteParams::default(), &tiles);
        assert!(
            matches!(error, CompletionError::Parameter { .. }),
            "{error}"
        );
    }
    let small = TileParams {
        tile: 150,
        overlap: None,
    };
    let error = refused(&CompleteParams::default(), &small);
    let CompletionError::Tile(TileError::TooSmall { least, .. }) = error else {
        panic!("{error}");
    };
    assert!(least > 150, "{least}");
    let free_form = CompleteParams {
        fit: FitParams {
            base: BaseChoice::FreeForm,
            ..FitParams::default()
        },
        extend: true,
        ..CompleteParams::default()
    };
    assert_eq!(
        refused(&free_form, &tiles),
        CompletionError::FreeFormHasNoEnd
    );
}

#[test]
fn tiles_out_of_turn_or_of_other_plans_are_refused() {
    let scan = synthetic(Kind::Waves, 6000, 0.2);
    let tiles = tiles(&scan, 2000, 5.0);
    let plan = |seed| {
        let params = CompleteParams { seed, ..narrow() };
        TilePlan::new(&scan, &params, &tiles, &mut |_| {}).expect("it can be tiled")
    };
    let mut one = plan(1);
    let rounds = one.rounds();
    let numbers: BTreeSet<usize> = rounds.iter().flatten().copied().collect();
    assert_eq!(numbers, (0..one.tiles()).collect());
    let (first, late) = (rounds[0][0], rounds[1][0]);
    let too_early = one.task(late).expect_err("it waits");
    assert!(matches!(too_early, TileError::TooEarly { tile, .. } if tile == late));
    let no_such = one.task(one.tiles()).expect_err("there is none");
    assert!(matches!(no_such, TileError::NoSuchTile { .. }));
    let grown = one.task(first).expect("it is time").grow(&mut |_| {});
    let wrong = one.put(late, grown.clone()).expect_err("it is another");
    assert!(matches!(wrong, TileError::Foreign { .. }));
    let foreign = plan(2).put(first, grown.clone()).expect_err("another plan");
    assert!(matches!(foreign, TileError::Foreign { .. }));
    assert_eq!(one.put(first, grown), Ok(()));
    let missing = one.finish(&mut |_| {}).expect_err("it is not done");
    assert!(matches!(
        missing,
        CompletionError::Tile(TileError::Missing { .. })
    ));
}

#[test]
fn damaged_bytes_are_an_error() {
    let scan = synthetic(Kind::Bricks, 2000, 0.05);
    let tiles = tiles(&scan, 1000, 4.0);
    let plan = TilePlan::new(&scan, &narrow(), &tiles, &mut |_| {}).expect("it can be tiled");
    let task = plan.task(plan.rounds()[0][0]).expect("it is time");
    let sent = task.to_bytes();
    assert_eq!(TileTask::from_bytes(&sent).as_ref(), Ok(&task));
    let grown = task.grow(&mut |_| {}).to_bytes();
    for step in 0..400 {
        let place = |bytes: &[u8]| step * bytes.len() / 400;
        for bytes in [&sent, &grown] {
            let mut flipped = bytes.clone();
            flipped[place(bytes)] ^= 1 << (step % 8);
            for damaged in [&flipped[..], &bytes[..place(bytes)]] {
                assert!(TileTask::from_bytes(damaged).is_err(), "{}", place(bytes));
                assert!(GrownTile::from_bytes(damaged).is_err(), "{}", place(bytes));
            }
        }
    }
    assert!(TileTask::from_bytes(&grown).is_err() && GrownTile::from_bytes(&sent).is_err());
}
