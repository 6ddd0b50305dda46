//! Files that a scan's file refers to: materials, textures, buffers.

use std::fs::{self, File};
use std::io::Read;
use std::path::{Component, Path, PathBuf};

use super::source::Source;
use super::trace;

/// Largest file that is read, in bytes: larger than the textures and buffers of any scan that fits
/// into memory.
const LARGEST: u64 = 4 << 30;

impl Source<'_> {
    /// The bytes of the file that this one calls `reference`, looked for in its own folder.
    ///
    /// Blanks and backslashes are fine, and so is another case of the letters. Absolute paths mostly
    /// come from another computer: what is not there is looked for by its bare name. The error says why
    /// there is nothing.
    pub(super) fn load_reference(&self, reference: &str) -> Result<Vec<u8>, String> {
        let Some(folder) = self.folder else {
            return Err("it is not looked for, since the folder of the scan is unknown".to_owned());
        };
        let Some(path) = find(folder, reference) else {
            trace::has_read(&folder.join(reference), None);
            return Err("there is no such file".to_owned());
        };
        let file = File::open(&path).map_err(|error| error.to_string())?;
        let size = file.metadata().map_err(|error| error.to_string())?.len();
        if size > LARGEST {
            return Err(format!("it is larger than {LARGEST} bytes"));
        }
        let mut bytes = Vec::new();
        let done = file.take(LARGEST).read_to_end(&mut bytes);
        done.map_err(|error| error.to_string())?;
        trace::has_read(&path, Some(&bytes));
        Ok(bytes)
    }
}

/// The regular file (no device and no pipe, which could go on for ever) of that name.
fn find(folder: &Path, reference: &str) -> Option<PathBuf> {
    let slashes = reference.trim().trim_matches('"').replace('\\', "/");
    let bytes = slashes.as_bytes();
    let has_drive = bytes.len() > 1 && bytes[0].is_ascii_alphabetic() && bytes[1] == b':';
    let relative = if slashes.starts_with('/') || has_drive {
        let here = Path::new(&slashes);
        if here.is_absolute() && here.is_file() {
            return Some(here.to_owned());
        }
        slashes.rsplit(['/', ':']).next().unwrap_or_default()
    } else {
        slashes.as_str()
    };
    let folder = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    walk(folder, Path::new(relative)).filter(|path| path.is_file())
}

/// Follows a relative path, and takes a name that differs in case where the exact one is missing.
fn walk(folder: &Path, relative: &Path) -> Option<PathBuf> {
    let exact = folder.join(relative);
    if exact.is_file() {
        return Some(exact);
    }
    let mut path = folder.to_owned();
    for component in relative.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir => path.push(".."),
            Component::Normal(name) => {
                let exact = path.join(name);
                path = if exact.exists() {
                    exact
                } else {
                    in_other_case(&path, name.to_str()?)?
                };
            }
            Component::RootDir | Component::Prefix(_) => return None,
        }
    }
    Some(path)
}

fn in_other_case(folder: &Path, name: &str) -> Option<PathBuf> {
    let wanted = name.to_lowercase();
    let entries = fs::read_dir(folder).ok()?.filter_map(Result::ok);
    // The first by name: folders list their files in no particular order.
    entries
        .map(|entry| entry.file_name())
        .filter(|found| found.to_string_lossy().to_lowercase() == wanted)
        .min()
        .map(|found| folder.join(found))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scan::ReadOptions;

    fn load(folder: Option<&Path>, reference: &str) -> Result<Vec<u8>, String> {
        let source = Source {
            bytes: &[],
            name: "a.obj",
            folder,
            options: &ReadOptions::default(),
        };
        source.load_reference(reference)
    }

    #[test]
    fn files_are_found_by_the_names_that_programs_write() {
        let folder = tempfile::tempdir().unwrap();
        let inner = folder.path().join("Scan");
        fs::create_dir_all(inner.join("My Textures")).unwrap();
        fs::write(inner.join("My Textures").join("Wood oak.PNG"), b"wood").unwrap();
        fs::write(inner.join("bare.png"), b"bare").unwrap();
        fs::write(folder.path().join("above.png"), b"above").unwrap();
        for (reference, bytes) in [
            ("My Textures/Wood oak.PNG", b"wood".as_slice()),
            (" My Textures\\Wood oak.PNG ", b"wood"),
            ("./my textures/wood OAK.png", b"wood"),
            ("\"bare.png\"", b"bare"),
            ("C:\\Users\\someone\\bare.png", b"bare"),
            ("c:bare.png", b"bare"),
            ("/no such folder/Bare.png", b"bare"),
            ("\\\\server\\share\\bare.png", b"bare"),
            ("../above.png", b"above"),
            ("..\\ABOVE.png", b"above"),
        ] {
            assert_eq!(load(Some(&inner), reference).unwrap(), bytes, "{reference}");
        }
        let above = folder.path().join("above.png");
        let absolute = above.to_str().unwrap();
        assert_eq!(load(Some(&inner), absolute).unwrap(), b"above");
    }

    #[test]
    fn folders_devices_and_missing_files_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = Some(folder.path());
        for reference in [
            "",
            ".",
            "..",
            "/",
            "C:",
            "none.png",
            "a/b/c",
            "/dev/zero",
            "\0",
        ] {
            assert!(load(path, reference).is_err(), "{reference:?}");
        }
        assert!(load(None, "a.png").unwrap_err().contains("not looked for"));
    }
}
