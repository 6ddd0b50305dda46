//! The files that the steps of a pipeline read and write.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::scan::TexturedOutput;

use super::held::{Held, is_kept};
use super::outcome::same_place;
use super::pipeline::{Action, CURRENT, Pipeline, Step, StepLine};

impl Pipeline {
    /// What one step writes no other may read, unless it says so, or write.
    pub(super) fn check_files(&self, actions: &[StepLine]) -> Result<(), String> {
        let reads: Vec<PathBuf> = (actions.iter())
            .flat_map(|line| line.action.reads())
            .collect();
        let mut written: Vec<PathBuf> = Vec::new();
        for (index, (step, line)) in self.steps.iter().zip(actions).enumerate() {
            let called = step.called(index);
            for (path, overwrite) in step.writes(&line.action) {
                let shown = path.display();
                if !overwrite && reads.iter().any(|read| same_place(read, &path)) {
                    return Err(format!(
                        "{called}: {shown} is what a step reads: give the output another name{}",
                        if line.action.output().is_some_and(|output| output == path) {
                            ", or \"overwrite\": true"
                        } else {
                            ""
                        }
                    ));
                }
                if written.iter().any(|other| same_place(other, &path)) {
                    return Err(format!(
                        "{called}: {shown} is written by another step: give the output another name"
                    ));
                }
                written.push(path);
            }
        }
        Ok(())
    }

    /// All paths that its steps write, as their options say.
    pub(super) fn outputs(&self) -> Vec<PathBuf> {
        self.steps.iter().flat_map(Step::outputs).collect()
    }
}

impl Action {
    /// All paths that it reads, standard input among them.
    pub(super) fn inputs(&self) -> Vec<PathBuf> {
        let files: Vec<&Path> = match self {
            Self::Read(input) => input.files().collect(),
            Self::Write(_) => Vec::new(),
            Self::Command(command) => command.files().inputs,
        };
        (files.into_iter())
            .filter(|path| *path != Path::new(CURRENT))
            .map(Path::to_owned)
            .collect()
    }

    /// The files that it reads.
    pub(super) fn reads(&self) -> Vec<PathBuf> {
        let mut files = self.inputs();
        files.retain(|path| path != Path::new("-"));
        files
    }

    /// Gives it something in memory that its options name by `path`.
    pub(super) fn hold(&mut self, path: &str, held: &Held) {
        match self {
            Self::Read(input) => input.reading.shelf.put(path, held.clone()),
            Self::Write(_) => {}
            Self::Command(command) => command.hold(path, held.clone()),
        }
    }

    /// Where it writes its scan or picture to.
    fn output(&self) -> Option<&Path> {
        match self {
            Self::Read(_) => None,
            Self::Write(a) => Some(a.path.as_path()),
            Self::Command(command) => command.files().output,
        }
        .filter(|path| !is_kept(path))
    }

    /// Whether its output may be a file that is read.
    fn may_overwrite(&self) -> bool {
        match self {
            Self::Read(_) => false,
            Self::Write(a) => a.writing.overwrite,
            Self::Command(command) => command.may_overwrite(),
        }
    }
}

impl Step {
    /// All paths that it writes, standard output among them, and whether they may be files that are read.
    pub(super) fn writes(&self, action: &Action) -> Vec<(PathBuf, bool)> {
        let is_main = |path: &PathBuf| action.output() == Some(path.as_path());
        (self.outputs().into_iter())
            .map(|path| {
                let overwrite = is_main(&path) && action.may_overwrite();
                (path, overwrite)
            })
            .collect()
    }

    /// The same, as its options say, which need not be right.
    pub(super) fn outputs(&self) -> Vec<PathBuf> {
        let names: &[&str] = match self.kind.as_str() {
            "read" => &[],
            "write" => &["path"],
            _ => &["output", "csv", "report"],
        };
        let path = |name: &&str| self.options.get(*name)?.as_str().map(PathBuf::from);
        let mut paths: Vec<PathBuf> = names.iter().filter_map(path).collect();
        if self.may_have_image()
            && let Some(mesh) = path(&"output")
        {
            paths.extend(TexturedOutput::beside(&mesh));
        }
        paths
    }

    /// Whether there is a texture image beside its output if the mesh has texture coordinates.
    fn may_have_image(&self) -> bool {
        let option = |name: &str| self.options.get(name);
        match self.kind.as_str() {
            "texture" => option("keep_mesh").is_some_and(|value| match value {
                Value::Bool(given) => *given,
                value => value == "true",
            }),
            "transfer" => option("channel").is_none_or(|value| value != "height"),
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn images_and_materials_beside_textured_meshes_are_outputs_too() {
        let outputs = |step: Value| -> Vec<String> {
            let pipeline = Pipeline::from_value(&json!(["a.ply", step])).unwrap();
            let paths = pipeline.outputs();
            paths
                .iter()
                .map(|path| path.display().to_string())
                .collect()
        };
        let texture = |keep: Value| json!({ "type": "texture", "exemplar": "e.png", "output": "x.obj", "keep_mesh": keep });
        assert_eq!(outputs(texture(json!(true))), ["x.obj", "x.mtl", "x.png"]);
        assert_eq!(outputs(texture(json!("true"))), ["x.obj", "x.mtl", "x.png"]);
        assert_eq!(outputs(texture(json!(false))), ["x.obj"]);
        let transfer = |channel: &str, output: &str| json!({ "type": "transfer", "source": "s.ply", "channel": channel, "output": output });
        assert_eq!(
            outputs(transfer("color", "d/x.ply")),
            ["d/x.ply", "d/x.png"]
        );
        assert_eq!(outputs(transfer("both", "x.glb")), ["x.glb"]);
        assert_eq!(outputs(transfer("height", "x.obj")), ["x.obj"]);
        let render = json!({ "type": "render", "output": "x.png" });
        assert_eq!(outputs(render), ["x.png"]);
    }
}
