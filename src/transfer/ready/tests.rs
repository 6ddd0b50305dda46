use super::super::shape::test_shapes::{grid, icosphere};
use super::*;

fn inside_out(mesh: &TriMesh) -> TriMesh {
    let mut mesh = mesh.clone();
    for triangle in &mut mesh.triangles {
        triangle.swap(1, 2);
    }
    mesh
}

/// A sphere with vertices that no face uses before, between and after its own.
fn with_loose_vertices() -> TriMesh {
    let mut mesh = icosphere(2);
    let used = |v: u32| if v < 100 { v + 1 } else { v + 2 };
    mesh.positions.insert(100, Point3::new(0.0, 3.0, 0.0));
    mesh.positions.insert(0, Point3::new(5.0, 0.0, 0.0));
    mesh.positions.push(Point3::new(0.0, 0.0, 7.0));
    for triangle in &mut mesh.triangles {
        *triangle = triangle.map(used);
    }
    mesh
}

#[test]
fn a_closed_mesh_that_is_inside_out_is_turned() {
    let mesh = icosphere(2);
    let [right, turned] = [mesh.clone(), inside_out(&mesh)].map(|m| Ready::new(&m, 162).surface);
    assert_eq!(right, turned);
    assert_eq!(right.triangles, mesh.triangles);
}

#[test]
fn an_open_mesh_stays_as_it_is() {
    let mesh = inside_out(&grid(5, 5, |x, y| [x, y, 0.0]));
    assert_eq!(Ready::new(&mesh, 25).surface.triangles, mesh.triangles);
}

#[test]
fn vertices_without_faces_are_no_part_of_the_surface() {
    let mesh = with_loose_vertices();
    assert_eq!(checked(&mesh, true), Ok(162));
    let ready = Ready::new(&mesh, 162);
    assert_eq!(ready.surface.positions.len(), 162);
    assert_eq!(ready.surface.triangles, icosphere(2).triangles);
    assert!(
        ready.surface.centroid().coords.norm() < 1e-9,
        "around the origin"
    );
    assert_eq!(ready.fine.mesh, mesh);
    for (own, v) in ready.vertices.iter().enumerate() {
        assert_eq!(ready.nearest()[*v as usize] as usize, own);
        assert_eq!(ready.given_vertex(u32::try_from(own).unwrap()), *v);
    }
    // Those without faces go with the vertex next to them.
    let nearest = ready.nearest();
    for loose in [0usize, 101, 164] {
        let p = mesh.positions[loose];
        let next = mesh.positions[ready.vertices[nearest[loose] as usize] as usize];
        let least = (ready.vertices.iter())
            .map(|v| (mesh.positions[*v as usize] - p).norm())
            .fold(f64::INFINITY, f64::min);
        assert!((next - p).norm() <= least);
    }
    let rows: Vec<[f64; 1]> = (0u8..165).map(|v| [f64::from(v)]).collect();
    for (row, v) in ready.on_surface(&rows).iter().zip(&ready.vertices) {
        assert!((row[0] - f64::from(*v)).abs() < 1e-12);
    }
}

#[test]
fn vertices_that_are_missing_are_put_on_edges() {
    let mesh = with_loose_vertices();
    let ready = Ready::new(&mesh, 500);
    assert_eq!(ready.surface.positions.len(), 500);
    assert_eq!(ready.fine.mesh.positions[..165], mesh.positions[..]);
    assert!((surface_area(&ready.surface) - surface_area(&mesh)).abs() < 1e-9);
    for v in 0..500 {
        let given = ready.given_vertex(v);
        assert!(given < 165);
        let own = ready.fine.mesh.positions[ready.vertices[v as usize] as usize];
        // No longer than an edge of the sphere.
        assert!((own - mesh.positions[given as usize]).norm() < 0.35);
    }
    let rows: Vec<[f64; 3]> = mesh.positions.iter().map(|p| [p.x, p.y, p.z]).collect();
    for (row, v) in ready.on_surface(&rows).iter().zip(&ready.vertices) {
        let p = ready.fine.mesh.positions[*v as usize];
        assert!((p - Point3::from(*row)).norm() < 1e-12);
    }
}

#[test]
fn meshes_that_are_no_surface_are_told_so() {
    let mut mesh = icosphere(0);
    assert_eq!(checked(&mesh, false), Ok(12));
    mesh.positions
        .iter_mut()
        .for_each(|p| *p = Point3::origin());
    assert_eq!(
        checked(&mesh, true),
        Err(TransferError::NoArea { of_source: true })
    );
    mesh.triangles.clear();
    assert_eq!(
        checked(&mesh, false),
        Err(TransferError::NoFaces { of_source: false })
    );
}
