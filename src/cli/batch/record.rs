//! What is known of a result that is there: what it was made of, and what it is.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use crate::scan::trace::{Notes, sha256, sha256_of_file};
use crate::scan::{OutputFile, ScanError};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::super::outcome::written;
use super::protocol::{Answer, Status};

/// The folder of records in that of the results.
pub(super) const FOLDER: &str = ".relievo";

/// A result, as it is kept beside the results.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Record {
    /// What was done, without the names of the scan and of its result; for people to read.
    parameters: Value,
    /// The hash of that and of the program's version: another version may give other results.
    recipe: String,
    pub(super) key: String,
    /// By place: the SHA-256 of what was read, `None` for what was looked for in vain.
    read: BTreeMap<String, Option<String>>,
    /// By place: the SHA-256 of what was written.
    outputs: BTreeMap<String, String>,
    /// Done, or partly.
    pub(super) status: Status,
    pub(super) counts: Value,
    pub(super) warnings: Vec<String>,
    pub(super) peak_memory: Option<u64>,
}

/// Whose record it is: the names that are left out of it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Names<'a> {
    pub(super) input: &'a Path,
    pub(super) output: &'a Path,
    /// The folder of results.
    pub(super) folder: &'a Path,
}

/// Stands for the scan itself.
const SCAN: &str = "{scan}";
/// Begins what is below the scan's folder.
const BESIDE: &str = "{beside}/";
/// Begins what is below the folder of results.
const OUT: &str = "{out}/";

impl Names<'_> {
    fn beside(&self) -> PathBuf {
        let parent = self.input.parent();
        let named = parent.filter(|folder| !folder.as_os_str().is_empty());
        named.unwrap_or_else(|| Path::new(".")).to_owned()
    }

    /// A file without what the names of scan and folders have to do with it.
    fn place(&self, path: &Path) -> String {
        let path = &std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        let below = |folder: &Path| {
            let folder = std::path::absolute(folder).ok()?;
            let resolved = fs::canonicalize(&folder).ok();
            let rest = path.strip_prefix(&folder).ok();
            let rest = rest.or_else(|| path.strip_prefix(resolved?).ok());
            rest.map(|rest| rest.to_string_lossy().into_owned())
        };
        if std::path::absolute(self.input).is_ok_and(|input| input == *path) {
            return SCAN.to_owned();
        }
        if let Some(rest) = below(self.folder) {
            return format!("{OUT}{rest}");
        }
        match below(&self.beside()) {
            Some(rest) => format!("{BESIDE}{rest}"),
            None => path.to_string_lossy().into_owned(),
        }
    }

    fn path(&self, place: &str) -> PathBuf {
        if place == SCAN {
            self.input.to_owned()
        } else if let Some(rest) = place.strip_prefix(OUT) {
            self.folder.join(rest)
        } else if let Some(rest) = place.strip_prefix(BESIDE) {
            self.beside().join(rest)
        } else {
            PathBuf::from(place)
        }
    }

    /// A file about this result, in the folder of records.
    pub(super) fn file(&self, ending: &str) -> PathBuf {
        let rest = self.output.strip_prefix(self.folder).unwrap_or(self.output);
        let mut path = self.folder.join(FOLDER).join(rest).into_os_string();
        path.push(ending);
        path.into()
    }

    fn record(&self) -> PathBuf {
        self.file(".json")
    }

    /// Where outputs are noted just before they appear.
    pub(super) fn notes(&self) -> Notes {
        Notes {
            file: self.file(".begun"),
            root: self.folder.to_owned(),
        }
    }

    /// The pictures of the scan before and after.
    pub(super) fn pictures(&self) -> [PathBuf; 2] {
        [".before.png", ".after.png"].map(|ending| self.file(ending))
    }

    /// All files about this result.
    pub(super) fn files(&self) -> Vec<PathBuf> {
        let mut files = self.pictures().to_vec();
        files.extend([self.record(), self.notes().file]);
        files
    }

    /// What is recorded, if it can be read.
    pub(super) fn recorded(&self) -> Option<Record> {
        let bytes = fs::read(self.record()).ok()?;
        serde_json::from_slice(&bytes).ok()
    }

    /// The files that an earlier run for this result has written.
    pub(super) fn own_files(&self) -> BTreeSet<PathBuf> {
        let recorded = self.recorded();
        let recorded = recorded.iter().flat_map(|record| record.outputs(self));
        recorded.map(real).chain(self.noted()).collect()
    }

    /// Those of a run that came to no record: they are there as it has written them.
    pub(super) fn noted(&self) -> BTreeSet<PathBuf> {
        self.notes().written().into_iter().map(real).collect()
    }

    /// Forgets notes of files that never came, or are somebody else's now.
    pub(super) fn forget(&self) {
        if self.noted().is_empty() {
            let _ = fs::remove_file(self.notes().file);
        }
    }
}

fn real(path: PathBuf) -> PathBuf {
    fs::canonicalize(&path).unwrap_or(path)
}

fn recipe(parameters: &Value) -> String {
    let text = json!([env!("CARGO_PKG_VERSION"), parameters]).to_string();
    sha256(text.as_bytes())
}

/// What a result is made of, in 64 hexadecimal digits: the same for the same content and parameters.
pub(super) fn key(parameters: &Value, answer: &Answer, names: &Names) -> String {
    let read: BTreeMap<String, &Option<String>> = (answer.read.iter())
        .map(|(path, hash)| (names.place(path), hash))
        .collect();
    let all = json!([env!("CARGO_PKG_VERSION"), parameters, read]);
    sha256(all.to_string().as_bytes())
}

impl Record {
    /// Of a result that is there.
    pub(super) fn new(
        parameters: &Value,
        key: String,
        answer: &Answer,
        names: &Names,
    ) -> std::io::Result<Self> {
        let mut outputs = BTreeMap::new();
        for path in &answer.written {
            outputs.insert(names.place(path), sha256_of_file(path)?);
        }
        let read = answer.read.iter();
        Ok(Self {
            recipe: recipe(parameters),
            parameters: parameters.clone(),
            key,
            read: read
                .map(|(path, hash)| (names.place(path), hash.clone()))
                .collect(),
            outputs,
            status: answer.status,
            counts: answer.counts.clone().into(),
            warnings: answer.warnings.clone(),
            peak_memory: answer.peak_memory,
        })
    }

    /// Writes it; what was noted before is in it now.
    pub(super) fn keep(&self, names: &Names) -> Result<(), ScanError> {
        let output = OutputFile::create(&names.record(), None)?;
        let text = json!(self).to_string();
        written(output, text.as_bytes())?;
        let _ = fs::remove_file(names.notes().file);
        Ok(())
    }

    /// Whether it was made of the same content in the same way, and is still there as it was made.
    pub(super) fn holds(&self, parameters: &Value, names: &Names) -> bool {
        let same = |place: &String, hash: Option<&String>| {
            let path = names.path(place);
            match hash {
                Some(hash) => sha256_of_file(&path).is_ok_and(|found| found == *hash),
                None => !path.exists(),
            }
        };
        self.recipe == recipe(parameters)
            && !self.outputs.is_empty()
            && (self.outputs.iter()).all(|(place, hash)| same(place, Some(hash)))
            && (self.read.iter()).all(|(place, hash)| same(place, hash.as_ref()))
    }

    /// The files that were written and are there, but not as they were, nor as a later run has noted.
    pub(super) fn changed(&self, names: &Names) -> Vec<PathBuf> {
        let noted = names.noted();
        let files = self
            .outputs
            .iter()
            .map(|(place, hash)| (names.path(place), hash));
        let is_changed =
            |path: &PathBuf, hash: &String| sha256_of_file(path).is_ok_and(|found| found != *hash);
        (files
            .filter(|(path, hash)| is_changed(path, hash) && !noted.contains(&real(path.clone()))))
        .map(|(path, _)| path)
        .collect()
    }

    /// The files that were written.
    pub(super) fn outputs(&self, names: &Names) -> Vec<PathBuf> {
        self.outputs.keys().map(|place| names.path(place)).collect()
    }
}
