//! Which scans: files, patterns, and files of jobs.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use anyhow::Context;
use serde::Deserialize;
use serde_json::Value;

use super::super::outcome::Failure;
use super::pattern::{is_pattern, matching};
use super::recipe::{Options, Recipe};

/// A scan, and what is asked for it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Given {
    pub(super) input: PathBuf,
    /// Its result's path below the folder of results, as far as it is known: with the scan's extension unless it is
    /// `named`.
    pub(super) below: PathBuf,
    /// Whether the result was given this name.
    pub(super) named: bool,
    /// What is done to it, if not what is done to all.
    pub(super) recipe: Option<Recipe>,
    /// Options for it alone.
    pub(super) options: Options,
}

/// A file of jobs.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct JobsFile {
    pipeline: Option<Value>,
    jobs: Vec<Value>,
}

/// One of its jobs; a path alone is a job's input.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Job {
    input: PathBuf,
    output: Option<PathBuf>,
    #[serde(default)]
    options: Options,
    pipeline: Option<Value>,
}

/// The scans of all arguments, in order, the same job once; none that lies in `results`.
pub(super) fn scans(arguments: &[PathBuf], results: &Path) -> Result<Vec<Given>, Failure> {
    let mut scans = Vec::new();
    let mut files: Vec<&Path> = Vec::new();
    for argument in arguments {
        let is_jobs = argument
            .extension()
            .is_some_and(|extension| extension == "json");
        if argument.is_dir() {
            return Err(Failure::usage(format!(
                "{0} is a folder: give a pattern for the scans in it, as in '{0}/*.ply'",
                argument.display()
            )));
        } else if is_jobs {
            scans.extend(of_jobs(argument)?);
        } else if argument.exists() || !is_pattern(argument) {
            files.push(argument);
        } else {
            scans.extend(matching(argument, results)?);
        }
    }
    // Some may be given from the root, and others from here.
    let absolute = |file: &&Path| std::path::absolute(file).unwrap_or_else(|_| (*file).to_owned());
    let places: Vec<PathBuf> = files.iter().map(absolute).collect();
    let folder = common_folder(&places);
    scans.extend(
        (files.iter().zip(&places))
            .map(|(file, place)| Given::new(file, place.strip_prefix(&folder).unwrap_or(place))),
    );
    let scans = each_once(scans);
    if scans.is_empty() {
        return Err(Failure::usage(
            "there are no scans: the files of jobs have none",
        ));
    }
    Ok(scans)
}

/// What is the same in all is there once. The same scan with other options is another job, whose result has to have
/// another name.
fn each_once(scans: Vec<Given>) -> Vec<Given> {
    let mut places: BTreeMap<(PathBuf, PathBuf), Vec<usize>> = BTreeMap::new();
    let mut kept: Vec<Given> = Vec::new();
    for given in scans {
        let place = (given.input.clone(), given.below.clone());
        let same = places.entry(place).or_default();
        if !same.iter().any(|&at| kept[at] == given) {
            same.push(kept.len());
            kept.push(given);
        }
    }
    kept
}

impl Given {
    pub(super) fn new(input: &Path, below: &Path) -> Self {
        Self {
            input: input.to_owned(),
            below: below.to_owned(),
            named: false,
            recipe: None,
            options: Options::new(),
        }
    }
}

/// The folder that all files are in, at whatever depth; empty if they have none in common.
fn common_folder(files: &[PathBuf]) -> PathBuf {
    let parent = |file: &PathBuf| file.parent().unwrap_or(Path::new("")).to_owned();
    let mut folders = files.iter().map(parent);
    let mut common = folders.next().unwrap_or_default();
    for folder in folders {
        while !folder.starts_with(&common) {
            // Of two drives there is nothing above.
            if !common.pop() {
                return PathBuf::new();
            }
        }
    }
    common
}

fn of_jobs(path: &Path) -> Result<Vec<Given>, Failure> {
    let shown = path.display();
    let wrong = |what: String| Failure::usage(format!("{shown}: {what}"));
    let text = std::fs::read_to_string(path).with_context(|| shown.to_string())?;
    let file: JobsFile = serde_json::from_str(&text).map_err(|error| {
        wrong(format!(
            "this is no list of jobs, as in {{\"jobs\": [\"a.ply\", \"b.ply\"]}}: {error}"
        ))
    })?;
    let for_all = (file.pipeline.as_ref().map(Recipe::of_pipeline).transpose()).map_err(wrong)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let of_job = |job: &Value| -> Result<Given, String> {
        let job = match job {
            Value::String(input) => Job {
                input: input.into(),
                ..Job::default()
            },
            job => Job::deserialize(job).map_err(|error| error.to_string())?,
        };
        let own = job.pipeline.as_ref().map(Recipe::of_pipeline).transpose()?;
        let below = match &job.output {
            Some(output) if is_plain(output) => output.clone(),
            Some(output) => {
                return Err(format!(
                    "its output {} is not in the folder of results: give a path below it",
                    output.display()
                ));
            }
            None if is_plain(&job.input) => job.input.clone(),
            None => job.input.file_name().unwrap_or_default().into(),
        };
        Ok(Given {
            named: job.output.is_some(),
            recipe: own.or_else(|| for_all.clone()),
            options: job.options,
            ..Given::new(&folder.join(&job.input), &below)
        })
    };
    (file.jobs.iter().enumerate())
        .map(|(index, job)| of_job(job).map_err(|what| wrong(format!("job {}: {what}", index + 1))))
        .collect()
}

/// Whether a path stays below the folder that it is relative to.
fn is_plain(path: &Path) -> bool {
    let mut parts = path.components().peekable();
    parts.peek().is_some()
        && parts.all(|part| matches!(part, Component::Normal(_) | Component::CurDir))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn below(scans: &[Given]) -> Vec<String> {
        let names = scans.iter().map(|given| given.below.display().to_string());
        names.collect()
    }

    #[test]
    fn files_give_paths_below_the_folder_they_have_in_common() {
        let list = |names: &[&str]| -> Vec<String> {
            let names: Vec<PathBuf> = names.iter().map(PathBuf::from).collect();
            below(&scans(&names, Path::new("out")).unwrap())
        };
        assert_eq!(list(&["s/a/1.ply", "s/b/1.ply"]), ["a/1.ply", "b/1.ply"]);
        assert_eq!(
            list(&["s/a/1.ply", "s/a/2.ply", "s/a/1.ply"]),
            ["1.ply", "2.ply"]
        );
        assert_eq!(list(&["1.ply"]), ["1.ply"]);
        assert_eq!(list(&["/x/1.ply", "/y/1.ply"]), ["x/1.ply", "y/1.ply"]);
        let here = std::env::current_dir().unwrap();
        let mixed = list(&[here.join("s/1.ply").to_str().unwrap(), "t/2.ply"]);
        assert_eq!(mixed, ["s/1.ply", "t/2.ply"]);
        // The folder of all folders is the only one that these have in common.
        let apart = list(&["/none/1.ply", "2.ply"]);
        assert_eq!(apart[0], "none/1.ply");
        let place = here.join("2.ply");
        assert_eq!(Path::new("/").join(&apart[1]), place);
    }

    #[test]
    fn jobs_have_paths_beside_their_file_and_what_is_wrong_with_them_is_named() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("jobs.json");
        let of = |text: &str| {
            std::fs::write(&path, text).unwrap();
            scans(std::slice::from_ref(&path), Path::new("out"))
        };
        let found = of(
            r#"{"jobs": ["s/a.ply", {"input": "../b.xyz"}, {"input": "c.ply", "output": "d/e.obj",
            "options": {"complete": {"window": 4}}}]}"#,
        )
        .unwrap();
        assert_eq!(below(&found), ["s/a.ply", "b.xyz", "d/e.obj"]);
        assert_eq!(found[1].input, place.path().join("../b.xyz"));
        assert!(found[2].named && !found[0].named);
        assert_eq!(found[2].options["complete"]["window"], 4);
        let twice = r#"{"jobs": ["a.ply", {"input": "a.ply"}, {"input": "a.ply", "options": {"complete": {"window": 4}}}]}"#;
        assert_eq!(below(&of(twice).unwrap()), ["a.ply", "a.ply"]);
        for (text, word) in [
            ("{", "no list of jobs"),
            (r#"{"jobs": []}"#, "no scans"),
            (r#"{"jobs": [3]}"#, "job 1"),
            (
                r#"{"jobs": ["a.ply", {"input": "b.ply", "outputs": "c"}]}"#,
                "job 2",
            ),
            (
                r#"{"jobs": [{"input": "b.ply", "output": "../c.ply"}]}"#,
                "below",
            ),
            (r#"{"jobs": [{"input": "b.ply", "pipeline": 3}]}"#, "job 1"),
        ] {
            let error = of(text).unwrap_err();
            assert!(error.usage, "{text}");
            assert!(
                error.error.to_string().contains(word),
                "{text}: {:?}",
                error.error
            );
        }
    }
}
