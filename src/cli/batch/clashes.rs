//! Files that jobs would take from each other, or from whoever has them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::scan::same_file;

use super::super::outcome::{Failure, place};
use super::Arguments;
use super::plan::Job;
use super::record::FOLDER;

/// Who reads a file.
struct Reader<'a> {
    path: &'a Path,
    /// What it is for this batch.
    what: &'static str,
    /// The only job that reads it, if there is but one and the file is not its scan: its steps are checked by themselves.
    only: Option<usize>,
}

/// No file is written by two jobs, or read by one and written by another; nothing is written over silently.
pub(super) fn check(jobs: &[Job], arguments: &Arguments) -> Result<(), Failure> {
    let readers = readers(jobs, arguments);
    let tells_case = tells_case(&arguments.out);
    let mut written: BTreeMap<PathBuf, (PathBuf, &Path)> = BTreeMap::new();
    for (index, job) in jobs.iter().enumerate() {
        for path in job.outputs() {
            let place = place(&path);
            if let Some(reader) = readers.get(&place)
                && reader.only != Some(index)
            {
                return Err(over(&path, reader.path, reader.what));
            }
            if same_file(&path, &job.input) {
                return Err(over(&path, &job.input, "a scan of"));
            }
            let key = if tells_case {
                place
            } else {
                in_lower_case(&place)
            };
            if let Some((other, input)) = written.get(&key) {
                return Err(twice(&path, &job.input, other, input));
            }
            written.insert(key, (path, &job.input));
        }
        if !arguments.overwrite && job.output.exists() {
            check_own(job, &arguments.out)?;
        }
    }
    Ok(())
}

/// All files that are read, by their places.
fn readers<'a>(jobs: &'a [Job], arguments: &'a Arguments) -> BTreeMap<PathBuf, Reader<'a>> {
    let mut readers: BTreeMap<PathBuf, Reader> = BTreeMap::new();
    let all = |path, what| Reader {
        path,
        what,
        only: None,
    };
    for path in arguments.files().filter(|path| path.exists()) {
        readers.insert(place(path), all(path, "a file that tells what to do in"));
    }
    for (index, job) in jobs.iter().enumerate() {
        for path in &job.reads {
            let reader = Reader {
                only: Some(index),
                ..all(path, "read by a step of")
            };
            (readers.entry(place(path)))
                .and_modify(|reader| {
                    reader.only = reader.only.filter(|only| *only == index);
                })
                .or_insert(reader);
        }
    }
    for job in jobs {
        readers.insert(place(&job.input), all(&job.input, "a scan of"));
    }
    readers
}

pub(super) fn over(path: &Path, input: &Path, what: &str) -> Failure {
    Failure::usage(format!(
        "{} would be written over {}, which is {what} this batch: give another folder (--out), or another name",
        path.display(),
        input.display()
    ))
}

fn twice(path: &Path, input: &Path, other: &Path, other_input: &Path) -> Failure {
    let shown = path.display();
    let differ_by_case = path != other && in_lower_case(path) == in_lower_case(other);
    let but = if differ_by_case {
        format!(" (as {}, which is the same file here)", other.display())
    } else {
        String::new()
    };
    Failure::usage(format!(
        "{shown} would be written for both {}{but} and {}: in a file of jobs each can have an output of its own, and names in pipelines may hold {{stem}}",
        other_input.display(),
        input.display()
    ))
}

/// What is there and was not written by a batch is not written over.
fn check_own(job: &Job, folder: &Path) -> Result<(), Failure> {
    let own = job.names(folder).own_files();
    let real = std::fs::canonicalize(&job.output);
    if real.is_ok_and(|real| own.contains(&real)) {
        return Ok(());
    }
    Err(Failure::usage(format!(
        "{} exists and was not written by a batch (there is no record of it in {}): give another folder, or --overwrite",
        job.output.display(),
        folder.join(FOLDER).display()
    )))
}

fn in_lower_case(path: &Path) -> PathBuf {
    path.to_string_lossy().to_lowercase().into()
}

/// Whether names that differ by case only are different files in a folder, which need not exist. It is asked for the
/// next folder above it that does, by its name in the other case.
fn tells_case(folder: &Path) -> bool {
    let usual = !cfg!(any(windows, target_os = "macos"));
    let Ok(folder) = std::path::absolute(folder) else {
        return usual;
    };
    let other_case = |folder: &Path| {
        let name = folder.file_name()?.to_str()?;
        let swapped: String = (name.chars())
            .map(|letter| {
                if letter.is_ascii_lowercase() {
                    letter.to_ascii_uppercase()
                } else {
                    letter.to_ascii_lowercase()
                }
            })
            .collect();
        (swapped != name).then(|| folder.with_file_name(swapped))
    };
    let mut there = folder.ancestors().filter(|folder| folder.exists());
    there
        .find_map(|folder| Some(!same_file(folder, &other_case(folder)?)))
        .unwrap_or(usual)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whether_case_is_told_is_asked_of_the_next_folder_that_is_there() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("Abc");
        std::fs::create_dir(&folder).unwrap();
        let told = !place.path().join("aBC").exists();
        assert_eq!(tells_case(&folder), told);
        assert_eq!(tells_case(&folder.join("not/there")), told);
    }

    #[test]
    #[cfg(unix)]
    fn folders_that_are_there_in_either_case_do_not_tell_it() {
        let place = tempfile::tempdir().unwrap();
        std::fs::create_dir(place.path().join("Abc")).unwrap();
        std::os::unix::fs::symlink("Abc", place.path().join("aBC")).unwrap();
        assert!(!tells_case(&place.path().join("Abc/out")));
        let [one, other] = ["out/A.ply", "out/a.ply"].map(Path::new);
        let said = twice(other, Path::new("a.ply"), one, Path::new("A.ply"));
        let said = said.error.to_string();
        assert!(
            said.contains("out/A.ply, which is the same file here"),
            "{said}"
        );
    }
}
