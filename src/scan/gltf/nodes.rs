//! The nodes of a glTF scene: where each mesh is.

use nalgebra::{Matrix4, Quaternion, Translation3, UnitQuaternion, Vector3};

use super::json::{Document, Node};

/// The extension that shows the mesh of a node many times.
const INSTANCING: &str = "EXT_mesh_gpu_instancing";

/// A mesh in the scene.
#[derive(Debug)]
pub(super) struct Placed {
    pub(super) mesh: usize,
    /// From its coordinates to those of the scene.
    pub(super) transform: Matrix4<f64>,
}

/// The meshes of the default scene, parents before their children.
///
/// Nodes make trees: one that is reached twice, as in a circle, is refused (*glTF 2.0*, section
/// 3.5.2).
pub(super) fn meshes(document: &Document) -> Result<Vec<Placed>, String> {
    if document.nodes.is_empty() {
        let alone = |mesh| Placed {
            mesh,
            transform: Matrix4::identity(),
        };
        return Ok((0..document.meshes.len()).map(alone).collect());
    }
    let mut placed = Vec::new();
    let mut seen = vec![false; document.nodes.len()];
    let mut open: Vec<(usize, Matrix4<f64>)> = roots(document)?
        .into_iter()
        .rev()
        .map(|root| (root, Matrix4::identity()))
        .collect();
    while let Some((number, parent)) = open.pop() {
        let node = document.nodes.get(number);
        let node = node.ok_or_else(|| format!("there is no node {number}"))?;
        if std::mem::replace(&mut seen[number], true) {
            return Err(format!("node {number} is in its scene more than once"));
        }
        if node.mesh.is_some() && node.extensions.contains_key(INSTANCING) {
            return Err(format!(
                "node {number} repeats its mesh ({INSTANCING}), which relievo does not read; export each copy as a node of its own"
            ));
        }
        let transform = parent * local(node);
        placed.extend(node.mesh.map(|mesh| Placed { mesh, transform }));
        open.extend(node.children.iter().rev().map(|child| (*child, transform)));
    }
    Ok(placed)
}

fn roots(document: &Document) -> Result<Vec<usize>, String> {
    let number = document.scene.unwrap_or(0);
    if let Some(scene) = document.scenes.get(number) {
        return Ok(scene.nodes.clone());
    }
    if document.scene.is_some() {
        return Err(format!("there is no scene {number}"));
    }
    let mut is_child = vec![false; document.nodes.len()];
    for child in document.nodes.iter().flat_map(|node| &node.children) {
        if let Some(is_child) = is_child.get_mut(*child) {
            *is_child = true;
        }
    }
    Ok((0..is_child.len()).filter(|n| !is_child[*n]).collect())
}

fn local(node: &Node) -> Matrix4<f64> {
    if let Some(matrix) = &node.matrix {
        return Matrix4::from_column_slice(matrix);
    }
    let mut matrix = Matrix4::identity();
    if let Some(scale) = node.scale {
        matrix.append_nonuniform_scaling_mut(&scale.into());
    }
    // Only where it is there: a product with a rotation by nothing could still round.
    // Zeros are no rotation at all, but some programs write them for none.
    let rotation = node.rotation.filter(|q| q.iter().any(|v| *v != 0.0));
    if let Some([x, y, z, w]) = rotation {
        let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        matrix = rotation.to_homogeneous() * matrix;
    }
    let [x, y, z] = node.translation.unwrap_or_default();
    Translation3::from(Vector3::new(x, y, z)).to_homogeneous() * matrix
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    fn placed(json: &str) -> Result<Vec<Placed>, String> {
        meshes(&serde_json::from_str(json).unwrap())
    }

    #[test]
    fn transforms_follow_the_tree() {
        let placed = placed(
            r#"{"scene": 0, "scenes": [{"nodes": [0]}], "meshes": [{}, {}], "nodes": [
            {"translation": [1, 2, 3], "children": [2, 1]}, {"mesh": 1},
            {"mesh": 0, "rotation": [0, 0, 0.7071067811865476, 0.7071067811865476], "scale": [2, 2, 2]}]}"#,
        )
        .unwrap();
        let at = |k: usize| {
            placed[k]
                .transform
                .transform_point(&Point3::new(1.0, 0.0, 0.0))
        };
        assert_eq!((placed[0].mesh, placed[1].mesh), (0, 1));
        assert!((at(0) - Point3::new(1.0, 4.0, 3.0)).norm() < 1e-12);
        assert_eq!(at(1), Point3::new(2.0, 2.0, 3.0));
    }

    #[test]
    fn circles_and_missing_nodes_are_refused() {
        for (nodes, reason) in [
            (
                r#"[{"children": [1]}, {"children": [0]}]"#,
                "more than once",
            ),
            (r#"[{"children": [7]}]"#, "no node 7"),
            (r#"[{"children": [1, 1]}, {}]"#, "more than once"),
        ] {
            let json = format!(r#"{{"scenes": [{{"nodes": [0]}}], "nodes": {nodes}}}"#);
            assert!(placed(&json).unwrap_err().contains(reason), "{nodes}");
        }
    }
}
