//! The folder of results: one batch at a time.

use std::fs::{File, OpenOptions, TryLockError};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::Context;

use super::super::outcome::Failure;
use super::record::FOLDER;

/// Processes of a batch that was killed notice it at once, unless the machine has no time for them.
const ORPHANS_END: Duration = Duration::from_secs(30);

/// The folder of results, locked as long as this is held, or its process lives.
#[derive(Debug)]
pub(super) struct Locked {
    _lock: Option<File>,
    /// What processes of scans lock together.
    pub(super) working: PathBuf,
}

/// Makes the folder, and locks it.
pub(super) fn locked(folder: &Path) -> Result<Locked, Failure> {
    let records = folder.join(FOLDER);
    let shown = folder.display();
    std::fs::create_dir_all(&records)
        .with_context(|| format!("{shown}: the folder of results cannot be made"))?;
    let own = opened(&records.join("lock"))?;
    let lock = match own.try_lock() {
        Ok(()) => Some(own),
        Err(TryLockError::WouldBlock) => {
            return Err(Failure::usage(format!(
                "{shown}: another batch is at work in this folder: wait for its end, or give another folder"
            )));
        }
        Err(TryLockError::Error(error)) => {
            log::warn!(
                "{shown}: files cannot be locked here ({error}): start no other batch in this folder"
            );
            None
        }
    };
    let working = records.join("working");
    if lock.is_some() {
        await_orphans(&working, folder)?;
    }
    Ok(Locked {
        _lock: lock,
        working,
    })
}

/// Waits until no process of an earlier batch is at work.
fn await_orphans(working: &Path, folder: &Path) -> Result<(), Failure> {
    let file = opened(working)?;
    let since = Instant::now();
    while let Err(TryLockError::WouldBlock) = file.try_lock() {
        if since.elapsed() > ORPHANS_END {
            return Err(anyhow::anyhow!(
                "{}: processes of an earlier batch are still at work in this folder: wait for their end",
                folder.display()
            )
            .into());
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    Ok(())
}

fn opened(path: &Path) -> anyhow::Result<File> {
    let file = OpenOptions::new()
        .create(true)
        .truncate(false)
        .write(true)
        .read(true)
        .open(path);
    file.with_context(|| format!("{}: cannot be opened", path.display()))
}
