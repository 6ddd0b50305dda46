//! Samples, edges and tiles of which it is known what they are.

use super::*;

fn seen(points: &[[f64; 3]]) -> Vec<Seen> {
    let seen = |&[x, y, depth]: &[f64; 3]| Seen { x, y, depth };
    points.iter().map(seen).collect()
}

/// Red for the first triangle, green for the second, blue for the third.
fn drawn(points: &[[f64; 3]], triangles: &[[u32; 3]]) -> Canvas {
    draw(&seen(points), triangles, [70, 50], false, |hit| {
        let mut light = [0.0; 3];
        light[hit.triangle % 3] = 1.0;
        Shaded {
            light,
            normal: [0.0, 0.0, 1.0],
        }
    })
}

/// Which of the three colours a pixel has.
fn at(canvas: &Canvas, x: usize, y: usize) -> [bool; 3] {
    let light = canvas.pixels[y * canvas.width + x].light;
    light.map(|value| value > 0.5)
}

#[test]
fn the_nearer_of_two_triangles_wins_in_either_order() {
    let points = [
        [5.0, 5.0, 1.0],
        [5.0, 45.0, 1.0],
        [60.0, 25.0, 1.0],
        [10.0, 5.0, 2.0],
        [10.0, 45.0, 2.0],
        [65.0, 25.0, 2.0],
    ];
    let canvas = drawn(&points, &[[0, 1, 2], [3, 4, 5]]);
    assert_eq!(at(&canvas, 20, 25), [false, true, false]);
    assert_eq!(at(&canvas, 7, 25), [true, false, false]);
    let canvas = drawn(&points, &[[3, 4, 5], [0, 1, 2]]);
    assert_eq!(at(&canvas, 20, 25), [true, false, false]);
    assert_eq!(at(&canvas, 7, 25), [false, true, false]);
    assert_eq!(at(&canvas, 69, 1), [false; 3]);
}

#[test]
fn triangles_with_common_edges_leave_no_crack_and_draw_nothing_twice() {
    // A fan around a point, with edges in all directions, of one colour and depth.
    let mut points = vec![[35.3, 25.1, 1.0]];
    for k in 0..37 {
        let angle = f64::from(k) / 37.0 * std::f64::consts::TAU;
        points.push([35.3 + 200.0 * angle.cos(), 25.1 + 200.0 * angle.sin(), 1.0]);
    }
    let triangles: Vec<[u32; 3]> = (0..37).map(|k| [0, 1 + k, 1 + (k + 1) % 37]).collect();
    let scene = Scene::new(&seen(&points), &triangles, 70, 50);
    let mut count = vec![0; 70 * SAMPLES * 50 * SAMPLES];
    for triangle in 0..triangles.len() {
        let triangle = OnGrid::new(scene.corners(triangle)).unwrap();
        let least = triangle.least();
        for row in 0..50 * SAMPLES {
            for column in 0..70 * SAMPLES {
                let edges = triangle.edges(middle(column), middle(row));
                if (0..3).all(|k| edges[k] >= least[k]) {
                    count[row * 70 * SAMPLES + column] += 1;
                }
            }
        }
    }
    assert!(count.iter().all(|n| *n == 1));
    let canvas = drawn(&points, &triangles);
    assert!(canvas.pixels.iter().all(|pixel| pixel.coverage >= 1.0));
}

#[test]
fn coverage_is_the_triangles_area() {
    let points = [[3.7, 4.1, 1.0], [61.2, 9.9, 1.0], [20.3, 47.5, 1.0]];
    let covered: f64 = (drawn(&points, &[[0, 1, 2]]).pixels.iter())
        .map(|pixel| f64::from(pixel.coverage))
        .sum();
    let area = 0.5 * ((61.2 - 3.7) * (47.5 - 4.1) - (9.9 - 4.1) * (20.3 - 3.7));
    assert!((covered / area - 1.0).abs() < 0.003, "{covered} {area}");
}

#[test]
fn weights_give_the_place_and_say_which_side_is_seen() {
    let points = [[5.0, 5.0, 1.0], [5.0, 45.0, 2.0], [65.0, 25.0, 4.0]];
    for (triangle, front) in [([0, 1, 2], true), ([0, 2, 1], false)] {
        let hits = std::sync::Mutex::new(0);
        draw(&seen(&points), &[triangle], [70, 50], true, |hit| {
            assert_eq!(hit.front, front);
            let sum: f64 = hit.weights.iter().sum();
            assert!((sum - 1.0).abs() < 1e-9);
            assert!(hit.weights.iter().all(|weight| *weight >= 0.0));
            assert!((0.0..30.0).contains(&hit.to_edge));
            *hits.lock().unwrap() += 1;
            Shaded {
                light: [0.0; 3],
                normal: [0.0; 3],
            }
        });
        assert!(hits.into_inner().unwrap() > 9 * 1000);
    }
}

#[test]
fn triangles_beyond_the_picture_and_without_area_draw_nothing() {
    let points = [
        [-50.0, -50.0, 1.0],
        [-10.0, -50.0, 1.0],
        [-10.0, -10.0, 1.0],
        [10.0, 10.0, 1.0],
        [30.0, 30.0, 1.0],
        [50.0, 50.0, 1.0],
    ];
    let canvas = drawn(&points, &[[0, 1, 2], [3, 4, 5], [3, 3, 5]]);
    assert!(canvas.pixels.iter().all(|pixel| pixel.coverage <= 0.0));
}
