//! What a batch says to the process of one scan, a line of JSON, and what that answers, another one.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// What is to be done.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Order {
    /// What is done to the scan; nothing if only its pictures are wanted.
    pub(super) pipeline: Option<Value>,
    pub(super) threads: usize,
    /// Files that may be replaced; any if `None`.
    pub(super) replaceable: Option<BTreeSet<PathBuf>>,
    /// Where outputs are noted just before they appear.
    pub(super) notes: PathBuf,
    /// The folder of results.
    pub(super) folder: PathBuf,
    /// A file that is locked by all processes that may write into the folder of results.
    pub(super) lock: PathBuf,
    pub(super) pictures: Option<Pictures>,
    /// Whether the report is to be answered, too.
    #[serde(default)]
    pub(super) report: bool,
}

/// Small pictures of a scan before and after.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Pictures {
    /// The result.
    pub(super) output: PathBuf,
    /// Where they go; there is none before if nothing was completed.
    pub(super) before: PathBuf,
    pub(super) after: PathBuf,
}

/// How it went.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Answer {
    pub(super) status: Status,
    pub(super) error: Option<String>,
    pub(super) warnings: Vec<String>,
    pub(super) counts: Map<String, Value>,
    /// Most memory that the process had, in bytes, where the system tells.
    pub(super) peak_memory: Option<u64>,
    /// By path: the SHA-256 of what was read, `None` for what was looked for in vain.
    pub(super) read: BTreeMap<PathBuf, Option<String>>,
    /// What had changed between two times that it was read.
    pub(super) changed: BTreeSet<PathBuf>,
    pub(super) written: BTreeSet<PathBuf>,
    /// What `relievo run --json` tells, if that was asked for.
    #[serde(default)]
    pub(super) report: Map<String, Value>,
    /// Whether what went wrong may go well another time.
    #[serde(default)]
    pub(super) may_pass: bool,
}

/// How a scan ended.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Status {
    #[default]
    Failed,
    /// Some of what was asked for could not be done.
    Partly,
    Done,
    /// Its results were there already.
    Skipped,
}
