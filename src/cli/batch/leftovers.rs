//! Temporary files of processes that were killed.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use crate::scan::Temporary;

/// Removes the temporary files of these outputs whose process, on this machine, `is_gone`. Those of other outputs and of
/// other machines, which may have the folder, too, are left alone.
pub(super) fn remove(files: &[PathBuf], is_gone: impl Fn(u32) -> bool) {
    let mut names: BTreeMap<PathBuf, BTreeSet<&OsStr>> = BTreeMap::new();
    for file in files {
        let name = file.file_name().unwrap_or_default();
        names.entry(folder(file)).or_default().insert(name);
    }
    for (folder, names) in names {
        // A folder that is not there has none.
        let Ok(entries) = std::fs::read_dir(folder) else {
            continue;
        };
        for entry in entries.filter_map(Result::ok) {
            let name = entry.file_name();
            let Some(temporary) = name.to_str().and_then(Temporary::of) else {
                continue;
            };
            if names.contains(OsStr::new(temporary.file))
                && temporary.is_of_this_host
                && is_gone(temporary.process)
                && let Err(error) = std::fs::remove_file(entry.path())
            {
                log::warn!("{}: cannot be removed: {error}", entry.path().display());
            }
        }
    }
}

/// Whether there is no process of this number.
#[cfg(unix)]
pub(super) fn is_gone(id: u32) -> bool {
    use nix::errno::Errno;
    use nix::sys::signal::kill;
    use nix::unistd::Pid;
    let Ok(id) = i32::try_from(id) else {
        return true;
    };
    kill(Pid::from_raw(id), None) == Err(Errno::ESRCH)
}

/// Whether there is no process of this number: not known here.
#[cfg(not(unix))]
pub(super) fn is_gone(_: u32) -> bool {
    false
}

/// The folder that a file is in.
pub(super) fn folder(file: &Path) -> PathBuf {
    match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
        _ => PathBuf::from("."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scan::OutputFile;

    #[test]
    fn only_temporary_files_of_own_outputs_and_of_processes_that_are_gone_here_are_removed() {
        let place = tempfile::tempdir().unwrap();
        let [a, b] = ["a.ply", "b.ply"].map(|name| place.path().join(name));
        let open = |path| OutputFile::create(path, None).unwrap();
        let _outputs = [open(&a), open(&a), open(&b)];
        std::fs::write(place.path().join(".a.ply.elsewhere-7-0.tmp"), "").unwrap();
        std::fs::write(&a, "").unwrap();
        let left = || {
            let mut files: Vec<String> = std::fs::read_dir(place.path())
                .unwrap()
                .map(|entry| entry.unwrap().file_name().into_string().unwrap())
                .map(|name| match Temporary::of(&name) {
                    Some(temporary) => format!("of {}", temporary.file),
                    None => name,
                })
                .collect();
            files.sort();
            files
        };
        let all = ["a.ply", "of a.ply", "of a.ply", "of a.ply", "of b.ply"];
        let files = [a, "none/b.ply".into()];
        remove(&files, |id| id == 7);
        assert_eq!(left(), all);
        remove(&files, |_| true);
        assert_eq!(left(), ["a.ply", "of a.ply", "of b.ply"]);
    }

    #[test]
    #[cfg(unix)]
    fn this_process_is_not_gone() {
        assert!(!is_gone(std::process::id()));
        assert!(is_gone(u32::MAX));
    }
}
