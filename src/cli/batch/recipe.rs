//! A pipeline without the names of a scan and of its result, which are filled in for each scan.

use std::path::Path;

use serde_json::{Map, Value, json};

use super::super::arguments::memory;
use super::super::pipeline::{Pipeline, Step};
use super::super::step_options::whole;

/// What tables of `complete` may take unless its option says something else, in bytes.
const TABLES: u64 = 2 << 30;

/// Stand for names in strings: the folder of the result, its name without extension, the scan's name.
const OUT: &str = "{out}";
const STEM: &str = "{stem}";
const NAME: &str = "{name}";

/// What is done to each scan: a pipeline that begins with reading and ends with writing.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Recipe(Pipeline);

/// Options by tag of a step.
pub(super) type Options = Map<String, Value>;

impl Recipe {
    /// Of a pipeline, as `relievo run` takes it; where it reads first or writes last, the paths are left out.
    ///
    /// # Errors
    /// A sentence.
    pub(super) fn of_pipeline(pipeline: &Value) -> Result<Self, String> {
        let mut pipeline = Pipeline::from_value(pipeline)?;
        let steps = &mut pipeline.steps;
        if steps.first().is_none_or(|step| step.kind != "read") {
            steps.insert(0, end("read", steps));
        }
        if steps.last().is_none_or(|step| step.kind != "write") {
            steps.push(end("write", steps));
        }
        let last = steps.len() - 1;
        for at in [0, last] {
            steps[at].options.remove("path");
        }
        Ok(Self(pipeline))
    }

    /// To complete each scan.
    pub(super) fn completing() -> Result<Self, String> {
        Self::of_pipeline(&json!([{ "type": "complete" }]))
    }

    /// Sets options of steps, by their tags.
    ///
    /// # Errors
    /// A sentence, if there is no such step.
    pub(super) fn set(&mut self, options: &Options) -> Result<(), String> {
        for (tag, values) in options {
            let Value::Object(values) = values else {
                return Err(format!(
                    "the options of {tag} are no object, as in {{\"{tag}\": {{\"window\": 4}}}}"
                ));
            };
            let Some(step) = self.0.steps.iter_mut().find(|step| step.tag == *tag) else {
                let tags: Vec<&str> = self.0.steps.iter().map(|step| step.tag.as_str()).collect();
                return Err(format!(
                    "no step has the tag `{tag}`: there are {}",
                    tags.join(", ")
                ));
            };
            let named =
                (values.iter()).map(|(name, value)| (name.replace('-', "_"), value.clone()));
            step.options.extend(named);
        }
        Ok(())
    }

    /// Sets an option, given as `TAG.OPTION=VALUE`.
    ///
    /// # Errors
    /// A sentence.
    pub(super) fn set_text(&mut self, text: &str) -> Result<(), String> {
        self.0.set(text)
    }

    pub(super) fn set_seed(&mut self, seed: u32) {
        self.0.seed = Some(seed);
    }

    pub(super) fn seed(&self) -> u32 {
        self.0.seed.unwrap_or(0)
    }

    /// What is done, without names: what a result depends on beside the content of files and the program. The scan's name
    /// is in it only if it is asked for.
    pub(super) fn parameters(&self, input: &Path, output: &Path) -> Value {
        let format = output.extension().unwrap_or_default().to_string_lossy();
        let mut parameters =
            json!({ "pipeline": self.0.to_value(), "format": format.to_lowercase() });
        if self.options().any(|(_, value)| holds_any(value, &[NAME])) {
            let name = input.file_name().unwrap_or_default();
            parameters["name"] = json!(name.to_string_lossy());
        }
        parameters
    }

    /// Whether what is read beside the scan may depend on names.
    pub(super) fn reads_by_name(&self) -> bool {
        let mut others =
            (self.options()).filter(|(name, _)| !["output", "csv", "report"].contains(name));
        others.any(|(_, value)| holds_any(value, &[OUT, STEM, NAME]))
    }

    fn options(&self) -> impl Iterator<Item = (&str, &Value)> {
        let all = self.0.steps.iter().flat_map(|step| &step.options);
        all.map(|(name, value)| (name.as_str(), value))
    }

    /// The most memory that tables of a step may take, in bytes; 0 if no step makes any.
    pub(super) fn tables(&self) -> u64 {
        let of_step = |step: &Step| match step.kind.as_str() {
            "complete" => Some(match step.options.get("memory") {
                Some(bytes @ Value::Number(_)) => whole(bytes).unwrap_or(TABLES),
                Some(Value::String(size)) => memory(size).map_or(TABLES, |bytes| bytes as u64),
                _ => TABLES,
            }),
            _ => None,
        };
        self.0.steps.iter().filter_map(of_step).max().unwrap_or(0)
    }

    /// The pipeline for a scan: in strings, `{out}` is the folder of the result, `{stem}` its name without the
    /// extension, `{name}` the scan's name.
    pub(super) fn pipeline(&self, input: &str, output: &str) -> Pipeline {
        let path = Path::new(output);
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder.to_string_lossy(),
            _ => ".".into(),
        };
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let name = Path::new(input).file_name().unwrap_or_default();
        let name = name.to_string_lossy();
        let names = [(OUT, &*folder), (STEM, &*stem), (NAME, &*name)];
        let mut pipeline = self.0.clone();
        let last = pipeline.steps.len() - 1;
        for step in &mut pipeline.steps {
            for value in step.options.values_mut() {
                *value = filled(value, &names);
            }
        }
        for (at, path) in [(0, input), (last, output)] {
            let options = &mut pipeline.steps[at].options;
            options.insert("path".into(), path.into());
        }
        pipeline
    }
}

/// A step that reads or writes, with a tag unlike the others.
fn end(kind: &str, steps: &[Step]) -> Step {
    let mut tag = kind.to_owned();
    while steps.iter().any(|step| step.tag == tag) {
        tag.push('_');
    }
    Step {
        kind: kind.to_owned(),
        tag,
        options: Map::new(),
    }
}

/// Whether any of these markers is in a string of the value.
fn holds_any(value: &Value, markers: &[&str]) -> bool {
    match value {
        Value::String(text) => markers.iter().any(|marker| text.contains(marker)),
        Value::Array(values) => values.iter().any(|value| holds_any(value, markers)),
        Value::Object(members) => members.values().any(|value| holds_any(value, markers)),
        _ => false,
    }
}

/// The value with names in its strings, filled in at once: a name may look like a placeholder.
fn filled(value: &Value, names: &[(&str, &str)]) -> Value {
    match value {
        Value::String(text) => Value::String(filled_text(text, names)),
        Value::Array(values) => values.iter().map(|value| filled(value, names)).collect(),
        Value::Object(members) => (members.iter())
            .map(|(key, value)| (key.clone(), filled(value, names)))
            .collect(),
        other => other.clone(),
    }
}

fn filled_text(text: &str, names: &[(&str, &str)]) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(at) = rest.find('{') {
        out.push_str(&rest[..at]);
        rest = &rest[at..];
        match names.iter().find(|(marker, _)| rest.starts_with(marker)) {
            Some((marker, name)) => {
                out.push_str(name);
                rest = &rest[marker.len()..];
            }
            None => {
                out.push('{');
                rest = &rest[1..];
            }
        }
    }
    out + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recipe(pipeline: &Value) -> Recipe {
        Recipe::of_pipeline(pipeline).unwrap()
    }

    #[test]
    fn reader_and_writer_keep_their_options_but_not_their_paths() {
        let given = json!({ "seed": 3, "pipeline": [
            { "type": "read", "path": "a.xyz", "columns": "x,y,z" },
            { "type": "complete" },
            { "type": "render", "output": "{out}/{stem}.png", "channel": "{name} {stem} {other}" },
            "b.ply"
        ]});
        let recipe = recipe(&given);
        let made = recipe.pipeline("in/{stem}.xyz", "out/sub/c.ply");
        let expected = json!({ "seed": 3, "relievo": env!("CARGO_PKG_VERSION"), "pipeline": [
            { "type": "read", "path": "in/{stem}.xyz", "columns": "x,y,z" },
            { "type": "complete" },
            { "type": "render", "output": "out/sub/c.png", "channel": "{stem}.xyz c {other}" },
            { "type": "write", "path": "out/sub/c.ply" }
        ]});
        assert_eq!(made.to_value(), expected);
        let written = ["out/sub/c.png", "out/sub/c.ply"].map(std::path::PathBuf::from);
        assert_eq!(made.outputs(), written);
    }

    #[test]
    fn a_pipeline_without_ends_gets_them() {
        let made = Recipe::completing().unwrap().pipeline("a.ply", "b.ply");
        let kinds: Vec<&str> = made.steps.iter().map(|step| step.kind.as_str()).collect();
        assert_eq!(kinds, ["read", "complete", "write"]);
    }

    #[test]
    fn options_go_to_steps_by_their_tags() {
        let mut made = recipe(&json!([
            { "type": "complete", "tag": "first" },
            { "type": "complete" }
        ]));
        let options = json!({ "first": { "window": 3 }, "complete": { "max-edges": 5 }, "write": { "ascii": true } });
        made.set(options.as_object().unwrap()).unwrap();
        let pipeline = made.pipeline("a.ply", "b.ply");
        assert_eq!(pipeline.steps[1].options["window"], 3);
        assert_eq!(pipeline.steps[2].options["max_edges"], 5);
        assert_eq!(pipeline.steps[3].options["ascii"], true);
        let unknown = json!({ "fill": { "window": 3 } });
        let error = made.set(unknown.as_object().unwrap()).unwrap_err();
        assert!(error.contains("first"), "{error}");
    }

    #[test]
    fn names_do_not_matter_for_the_parameters_but_formats_do() {
        let recipe = recipe(&json!(["x.ply", { "type": "complete" }, "y.ply"]));
        let of = |path: &str| recipe.parameters(Path::new(path), Path::new(path));
        assert_eq!(of("out/a.ply"), of("elsewhere/b.PLY"));
        assert_ne!(of("a.ply"), of("a.obj"));
        let bare = Recipe::completing().unwrap();
        let [a, b] = ["a.ply", "b.ply"].map(Path::new);
        assert_eq!(bare.parameters(a, a), of("b.ply"));
        let pipeline = json!([{ "type": "render", "output": "{out}/{name}.png" }]);
        let by_name = Recipe::of_pipeline(&pipeline).unwrap();
        assert_ne!(by_name.parameters(a, a), by_name.parameters(b, a));
        assert_eq!(by_name.parameters(a, a), by_name.parameters(a, b));
        assert!(!by_name.reads_by_name());
        let pipeline = json!([{ "type": "complete", "color_image": "{stem}.png" }]);
        assert!(Recipe::of_pipeline(&pipeline).unwrap().reads_by_name());
    }
}
