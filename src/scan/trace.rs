//! What a process reads and writes, for whoever must know exactly: the hashes are of the very bytes that were used.
//!
//! Nothing is kept until [`begin`] is called; a process has one trace.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{File, OpenOptions};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::{ScanError, same_file};

/// Which files may be written, and where they are noted before they appear.
#[derive(Debug, Default)]
pub struct Rules {
    /// The files that may be replaced if they exist; `None` if any may but those that were read.
    pub replaceable: Option<BTreeSet<PathBuf>>,
    /// Where each output is noted just before it appears.
    pub notes: Option<Notes>,
}

/// A file with a line of JSON for each output: what is there with the noted hash was written by this work, also if that
/// was killed right after; whatever else has the output's name is somebody else's.
#[derive(Debug, Clone, Default)]
pub struct Notes {
    /// The file.
    pub file: PathBuf,
    /// Outputs below this folder are noted as seen from it, so that both can be moved together; others by their absolute
    /// paths.
    pub root: PathBuf,
}

#[derive(Debug, Serialize, Deserialize)]
struct Note {
    path: PathBuf,
    sha256: String,
}

impl Notes {
    /// The outputs that are there as they were noted.
    #[must_use]
    pub fn written(&self) -> BTreeSet<PathBuf> {
        // The last line may have been cut off, before its file appeared.
        let text = std::fs::read_to_string(&self.file).unwrap_or_default();
        (text.lines())
            .filter_map(|line| serde_json::from_str::<Note>(line).ok())
            .map(|note| (self.root.join(note.path), note.sha256))
            .filter(|(path, hash)| sha256_of_file(path).is_ok_and(|found| found == *hash))
            .map(|(path, _)| path)
            .collect()
    }

    fn add(&self, path: &Path, sha256: String) -> io::Result<()> {
        let absolute = std::path::absolute(path)?;
        let below = |root: io::Result<PathBuf>| {
            let rest = absolute.strip_prefix(root.ok()?).ok()?;
            Some(rest.to_owned())
        };
        let seen = below(std::path::absolute(&self.root))
            .or_else(|| below(std::fs::canonicalize(&self.root)));
        let path = seen.unwrap_or(absolute);
        let mut line = serde_json::to_string(&Note { path, sha256 })?;
        line.push('\n');
        let mut file = OpenOptions::new()
            .append(true)
            .create(true)
            .open(&self.file)?;
        file.write_all(line.as_bytes())
    }
}

/// What was read and written.
#[derive(Debug, Default)]
pub struct Trace {
    /// By path: the SHA-256 of the bytes, as hexadecimal digits; `None` if there was no such file.
    pub read: BTreeMap<PathBuf, Option<String>>,
    /// Files that were read twice and had changed in between.
    pub changed: BTreeSet<PathBuf>,
    /// Files that appeared.
    pub written: BTreeSet<PathBuf>,
}

#[derive(Debug)]
struct Kept {
    rules: Rules,
    trace: Trace,
}

static KEPT: Mutex<Option<Kept>> = Mutex::new(None);

/// What a thread that panicked has left is still right: each change is a single step.
fn kept() -> MutexGuard<'static, Option<Kept>> {
    KEPT.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Begins the trace of this process, or begins it anew.
pub fn begin(rules: Rules) {
    *kept() = Some(Kept {
        rules,
        trace: Trace::default(),
    });
}

/// Ends the trace; empty if none was begun.
#[must_use]
pub fn end() -> Trace {
    kept().take().map(|kept| kept.trace).unwrap_or_default()
}

/// The SHA-256 (FIPS 180-4) of bytes, as hexadecimal digits.
#[must_use]
pub fn sha256(bytes: &[u8]) -> String {
    digits(Sha256::new_with_prefix(bytes))
}

/// The SHA-256 of a file's bytes, as hexadecimal digits.
///
/// # Errors
/// What the system says.
pub fn sha256_of_file(path: &Path) -> io::Result<String> {
    let mut file = File::open(path)?;
    let mut hash = Sha256::new();
    let mut buffer = vec![0; 1 << 16];
    loop {
        match file.read(&mut buffer) {
            Ok(0) => return Ok(digits(hash)),
            Ok(count) => hash.update(&buffer[..count]),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
}

fn digits(hash: Sha256) -> String {
    let bytes = hash.finalize();
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// A file was read, or, without bytes, looked for in vain.
pub(crate) fn has_read(path: &Path, bytes: Option<&[u8]>) {
    if let Some(kept) = kept().as_mut() {
        let hash = bytes.map(sha256);
        let before = kept.trace.read.insert(path.to_owned(), hash.clone());
        if before.is_some_and(|before| before != hash) {
            kept.trace.changed.insert(path.to_owned());
        }
    }
}

/// A file is to be written, or about to appear; an error if it may not be.
pub(super) fn will_write(path: &Path, name: &str) -> Result<(), ScanError> {
    let kept = kept();
    let Some(Kept { rules, trace }) = kept.as_ref() else {
        return Ok(());
    };
    let name = || name.to_owned();
    if path.exists() {
        if trace.read.keys().any(|read| same_file(read, path)) {
            return Err(ScanError::WouldReplaceInput { name: name() });
        }
        if (rules.replaceable.as_ref()).is_some_and(|those| !those.contains(path)) {
            return Err(ScanError::WouldReplace { name: name() });
        }
    }
    Ok(())
}

/// Notes a file whose bytes, all of them, are in another one as yet.
pub(super) fn note(path: &Path, bytes: &Path) -> Result<(), ScanError> {
    let notes = (kept().as_ref()).and_then(|kept| kept.rules.notes.clone());
    let Some(notes) = notes else {
        return Ok(());
    };
    let noted = sha256_of_file(bytes).and_then(|hash| notes.add(path, hash));
    noted.map_err(|source| ScanError::writing(&notes.file.display().to_string(), source))
}

/// A file has appeared.
pub(super) fn has_written(path: &Path) {
    if let Some(kept) = kept().as_mut() {
        kept.trace.written.insert(path.to_owned());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_are_those_of_the_standard() {
        let abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(sha256(b"abc"), abc);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("abc");
        std::fs::write(&path, "abc").unwrap();
        assert_eq!(sha256_of_file(&path).unwrap(), abc);
        let many = vec![b'a'; 1_000_000];
        std::fs::write(&path, &many).unwrap();
        let million = "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0";
        assert_eq!(sha256_of_file(&path).unwrap(), million);
        assert_eq!(sha256(&many), million);
    }

    #[test]
    fn what_is_noted_is_told_by_its_content_and_can_be_moved() {
        let folder = tempfile::tempdir().unwrap();
        let here = folder.path().join("here");
        std::fs::create_dir_all(here.join("out")).unwrap();
        let outside = folder.path().join("outside.ply");
        let notes = |root: &str| {
            let root = folder.path().join(root);
            let file = root.join("notes");
            Notes { file, root }
        };
        for path in [&here.join("out/a.ply"), &here.join("b.ply"), &outside] {
            std::fs::write(path, "result").unwrap();
            notes("here").add(path, sha256(b"result")).unwrap();
        }
        std::fs::write(here.join("b.ply"), "somebody else's").unwrap();
        let found = notes("here").written();
        assert_eq!(found, [here.join("out/a.ply"), outside.clone()].into());
        let there = folder.path().join("there");
        std::fs::rename(&here, &there).unwrap();
        let mut text = std::fs::read_to_string(there.join("notes")).unwrap();
        text.push_str("{\"path\": \"out/a.p");
        std::fs::write(there.join("notes"), text).unwrap();
        let found = notes("there").written();
        assert_eq!(found, [there.join("out/a.ply"), outside].into());
    }
}
