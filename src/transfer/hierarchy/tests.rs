use super::super::shape::test_shapes::{grid, icosphere};
use super::*;
use crate::mesh::check;
use crate::rng::Stage;

fn levels(mesh: &TriMesh) -> Hierarchy {
    let (hierarchy, standing) = Hierarchy::new(mesh, &counts(mesh.positions.len(), 128));
    // The finest level is the mesh as it is.
    assert_eq!(&hierarchy.levels[0], mesh);
    assert!((0u32..).zip(&standing).all(|(v, own)| v == *own));
    hierarchy
}

fn length(mesh: &TriMesh) -> u32 {
    u32::try_from(mesh.positions.len()).unwrap()
}

/// The ancestor of a vertex so many levels above.
fn above(hierarchy: &Hierarchy, level: usize, v: u32, up: usize) -> u32 {
    (hierarchy.parents[level..level + up].iter()).fold(v, |v, parents| parents[v as usize])
}

#[test]
fn each_level_has_half_the_vertices_down_to_about_128() {
    for mesh in [icosphere(3), grid(40, 30, |x, y| [x, y, 0.1 * x.sin()])] {
        let hierarchy = levels(&mesh);
        for pair in hierarchy.levels.windows(2) {
            assert_eq!(pair[1].positions.len(), pair[0].positions.len() / 2);
            assert_eq!(check(&pair[1]), Ok(()));
        }
        let coarsest = hierarchy.levels.last().unwrap().positions.len();
        assert!((128..256).contains(&coarsest), "{coarsest}");
    }
}

#[test]
fn counts_are_halved_while_enough_are_left() {
    assert_eq!(counts(1024, 128), [1024, 512, 256, 128]);
    assert_eq!(counts(1000, 128), [1000, 500, 250]);
    assert_eq!(counts(3, 128), [3]);
}

#[test]
fn parents_and_children_agree() {
    let hierarchy = levels(&icosphere(3));
    assert_eq!(hierarchy.parents.len(), hierarchy.levels.len() - 1);
    assert_eq!(hierarchy.children.len(), hierarchy.levels.len() - 1);
    for (level, (parents, children)) in
        (hierarchy.parents.iter().zip(&hierarchy.children)).enumerate()
    {
        assert_eq!(parents.len(), hierarchy.levels[level].positions.len());
        assert_eq!(children.len(), hierarchy.levels[level + 1].positions.len());
        let mut seen = vec![0; parents.len()];
        for (parent, row) in (0u32..).zip(children.rows()) {
            assert!(!row.is_empty(), "{parent} stands for none");
            for child in row {
                assert_eq!(parents[*child as usize], parent);
                seen[*child as usize] += 1;
            }
        }
        assert!(seen.iter().all(|times| *times == 1));
    }
}

#[test]
fn a_parent_is_near_its_children() {
    let hierarchy = levels(&icosphere(3));
    let [fine, coarse] = [0, 1].map(|k| &hierarchy.levels[k].positions);
    let spacing = crate::mesh::median_edge(&hierarchy.levels[0]).unwrap();
    for (p, parent) in fine.iter().zip(&hierarchy.parents[0]) {
        let distance = (p - coarse[*parent as usize]).norm();
        assert!(distance < 1.5 * spacing, "{distance} of {spacing}");
    }
}

#[test]
fn a_relative_is_below_the_same_ancestor_and_every_one_is_found() {
    let hierarchy = levels(&icosphere(3));
    let mut rng = Rng::new(1, Stage::Transfer, 0);
    for level in 0..hierarchy.levels.len() {
        for up in 0..hierarchy.levels.len() - level {
            for v in 0..length(&hierarchy.levels[level]) {
                let relative = hierarchy.relative(level, v, up, &mut rng);
                let ancestors = [v, relative].map(|v| above(&hierarchy, level, v, up));
                assert_eq!(ancestors[0], ancestors[1]);
                assert!(up > 0 || relative == v);
            }
        }
    }
    // All that the grandparent of vertex 100 stands for.
    let own = above(&hierarchy, 0, 100, 2);
    let mut family: Vec<u32> = (0..length(&hierarchy.levels[0]))
        .filter(|v| above(&hierarchy, 0, *v, 2) == own)
        .collect();
    let mut found: Vec<u32> = (0..400)
        .map(|_| hierarchy.relative(0, 100, 2, &mut rng))
        .collect();
    family.sort_unstable();
    found.sort_unstable();
    found.dedup();
    assert_eq!(found, family);
}

#[test]
fn filtered_values_are_means_of_all_that_a_vertex_stands_for() {
    let hierarchy = levels(&icosphere(3));
    let mut rng = Rng::new(2, Stage::Transfer, 0);
    let vertices = hierarchy.levels[0].positions.len();
    #[expect(clippy::cast_possible_truncation, reason = "values are single")]
    let values: Vec<f32> = (0..2 * vertices).map(|_| rng.uniform() as f32).collect();
    let all = hierarchy.filtered(0, values.clone(), 2);
    assert_eq!(all.len(), hierarchy.levels.len());
    assert_eq!(all[0], values);
    for (level, filtered) in all.iter().enumerate() {
        let mut sums = vec![[0.0f64; 3]; hierarchy.levels[level].positions.len()];
        for (v, row) in (0u32..).zip(values.as_chunks::<2>().0) {
            let sum = &mut sums[above(&hierarchy, 0, v, level) as usize];
            *sum = [
                sum[0] + f64::from(row[0]),
                sum[1] + f64::from(row[1]),
                sum[2] + 1.0,
            ];
        }
        for (sum, row) in sums.iter().zip(filtered.as_chunks::<2>().0) {
            for k in 0..2 {
                assert!((sum[k] / sum[2] - f64::from(row[k])).abs() < 1e-5);
            }
        }
    }
}

#[test]
fn the_least_meshes_have_one_level() {
    let mut mesh = icosphere(0);
    mesh.triangles.truncate(1);
    mesh.positions = mesh.corners(0).to_vec();
    mesh.triangles[0] = [0, 1, 2];
    for counts in [&[3][..], &[3, 1], &[3, 2, 1]] {
        let (hierarchy, _) = Hierarchy::new(&mesh, counts);
        assert_eq!(hierarchy.levels, std::slice::from_ref(&mesh));
        assert!(hierarchy.parents.is_empty() && hierarchy.children.is_empty());
    }
}
