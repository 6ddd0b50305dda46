//! A file that appears whole or not at all.

use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, ErrorKind, Stdout, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::{ScanError, temporary, trace};

/// An output that is checked when it is opened and appears when it is complete.
///
/// [`create`](Self::create) makes a temporary file beside the output, so that a folder that is
/// missing, full or not writable is noticed before any long work; [`commit`](Self::commit) gives it
/// the output's name. Dropped before that, the temporary is removed and whatever had the output's
/// name before is untouched.
///
/// `-` is standard output, which is not held back, nor is a device or a pipe.
///
/// ```
/// use std::io::Write;
/// use relievo::scan::OutputFile;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("report.json");
/// let mut output = OutputFile::create(&path, None)?;
/// writeln!(output, "{{}}")?;
/// assert!(!path.exists());
/// output.commit()?;
/// assert_eq!(std::fs::read_to_string(&path)?, "{}\n");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct OutputFile {
    name: String,
    sink: Sink,
}

#[derive(Debug)]
enum Sink {
    /// Written beside the output and renamed at the end. `None` once it is renamed.
    Held(Option<Held>),
    Device(BufWriter<File>),
    Stdout(BufWriter<Stdout>),
}

#[derive(Debug)]
struct Held {
    file: BufWriter<File>,
    temporary: PathBuf,
    target: PathBuf,
}

/// The temporary files that there are. Whoever makes, renames or removes one does so while this is
/// locked.
static TEMPORARIES: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// What a thread that panicked has left is still right: each change is a single step.
fn temporaries() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    TEMPORARIES.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes the temporary files of all outputs that are not complete: for programs that are about to end
/// because they were interrupted. Outputs cannot be completed any more.
pub fn abandon_outputs() {
    let known = temporaries();
    for temporary in known.iter() {
        let _ = fs::remove_file(temporary);
    }
    // Stays locked: whoever wants to complete or to begin an output waits for the end.
    std::mem::forget(known);
}

impl OutputFile {
    /// Opens an output.
    ///
    /// If it is the same file as `protected` (the input; also by another path or link), this is an
    /// error; pass `None` where the user asked for overwriting.
    ///
    /// # Errors
    /// [`ScanError::WouldOverwrite`], [`ScanError::NoFolder`], [`ScanError::IsFolder`], or
    /// [`ScanError::Write`] with what the system says.
    pub fn create(path: &Path, protected: Option<&Path>) -> Result<Self, ScanError> {
        if path == Path::new("-") {
            return Ok(Self {
                name: "standard output".to_owned(),
                sink: Sink::Stdout(BufWriter::new(io::stdout())),
            });
        }
        let name = path.display().to_string();
        let write_error = |source| ScanError::Write {
            name: name.clone(),
            source,
        };
        if protected.is_some_and(|protected| same_file(path, protected)) {
            return Err(ScanError::WouldOverwrite { name });
        }
        if path.is_dir() {
            return Err(ScanError::IsFolder { name });
        }
        // A link stays a link: what it points to is replaced.
        let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let old = fs::metadata(&target).ok();
        let sink = match &old {
            Some(old) if !old.is_file() => {
                let device = OpenOptions::new().write(true).open(&target);
                Sink::Device(BufWriter::new(device.map_err(write_error)?))
            }
            Some(old) if old.permissions().readonly() => {
                return Err(write_error(ErrorKind::PermissionDenied.into()));
            }
            _ => {
                trace::will_write(&target, &name)?;
                Sink::Held(Some(Held::create(&name, target)?))
            }
        };
        if let (Sink::Held(Some(held)), Some(old)) = (&sink, &old) {
            // A file that is replaced keeps its permissions. Not all file systems have them.
            if let Err(e) = fs::set_permissions(&held.temporary, old.permissions()) {
                log::debug!("{name}: permissions not kept ({e})");
            }
        }
        Ok(Self { name, sink })
    }

    /// Makes the output appear.
    ///
    /// # Errors
    /// [`ScanError::Write`]; the temporary file is removed then.
    pub fn commit(mut self) -> Result<(), ScanError> {
        if let Sink::Held(Some(held)) = &mut self.sink {
            let settled = held.settle();
            settled.map_err(|source| self.error(source))?;
        }
        if let Sink::Held(Some(held)) = &self.sink {
            // Somebody may have put a file there meanwhile.
            trace::will_write(&held.target, &self.name)?;
            trace::note(&held.target, &held.temporary)?;
        }
        let result = match &mut self.sink {
            Sink::Held(held) => held.take().map_or(Ok(()), Held::finish),
            Sink::Device(file) => file.flush(),
            Sink::Stdout(out) => out.flush(),
        };
        result.map_err(|source| self.error(source))
    }

    /// Makes several outputs appear in their order, or none of them: if one cannot, those before it are removed
    /// again. Files that one of those has replaced do not come back.
    ///
    /// # Errors
    /// [`ScanError::Write`]; the temporary files are removed then.
    pub fn commit_all(mut outputs: Vec<Self>) -> Result<(), ScanError> {
        // Most of what can fail does here, where nothing has its name yet.
        for output in &mut outputs {
            let settled = match &mut output.sink {
                Sink::Held(Some(held)) => held.settle(),
                _ => output.flush(),
            };
            settled.map_err(|source| output.error(source))?;
        }
        let mut appeared: Vec<PathBuf> = Vec::new();
        for output in outputs {
            let target = output.target().filter(|target| !target.exists());
            let target = target.map(Path::to_owned);
            if let Err(error) = output.commit() {
                for target in &appeared {
                    let _ = fs::remove_file(target);
                }
                return Err(error);
            }
            appeared.extend(target);
        }
        Ok(())
    }

    /// The file that it becomes, if it is held back.
    fn target(&self) -> Option<&Path> {
        match &self.sink {
            Sink::Held(held) => held.as_ref().map(|held| held.target.as_path()),
            Sink::Device(_) | Sink::Stdout(_) => None,
        }
    }

    /// Wraps an error of writing to this output so that it names the file.
    #[must_use]
    pub fn error(&self, source: io::Error) -> ScanError {
        ScanError::writing(&self.name, source)
    }

    /// The output as users know it.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether it is standard output, where nothing else may be written then.
    #[must_use]
    pub fn is_stdout(&self) -> bool {
        matches!(self.sink, Sink::Stdout(_))
    }
}

impl Held {
    fn create(name: &str, target: PathBuf) -> Result<Self, ScanError> {
        let folder = match target.parent() {
            Some(folder) if folder.as_os_str().is_empty() => Path::new("."),
            Some(folder) => folder,
            None => Path::new("."),
        };
        if !folder.is_dir() {
            return Err(ScanError::NoFolder {
                name: name.to_owned(),
                folder: folder.display().to_string(),
            });
        }
        let mut number = 0u32;
        loop {
            let file = target.file_name().unwrap_or_default();
            let temporary = folder.join(temporary::name(file, number));
            let mut known = temporaries();
            match File::create_new(&temporary) {
                Ok(file) => {
                    known.insert(temporary.clone());
                    return Ok(Self {
                        file: BufWriter::with_capacity(1 << 16, file),
                        temporary,
                        target,
                    });
                }
                Err(e) if e.kind() == ErrorKind::AlreadyExists && number < 1000 => number += 1,
                Err(source) => {
                    return Err(ScanError::Write {
                        name: name.to_owned(),
                        source,
                    });
                }
            }
        }
    }

    fn settle(&mut self) -> io::Result<()> {
        self.file.flush()?;
        // Full disks and quotas may only be noticed here.
        self.file.get_ref().sync_data()
    }

    /// What is settled gets its name.
    fn finish(self) -> io::Result<()> {
        let mut known = temporaries();
        fs::rename(&self.temporary, &self.target)?;
        known.remove(&self.temporary);
        trace::has_written(&self.target);
        Ok(())
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        // After the rename there is nothing of this name any more, or somebody else's.
        let mut known = temporaries();
        if known.remove(&self.temporary) {
            let _ = fs::remove_file(&self.temporary);
        }
    }
}

impl Write for OutputFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.sink {
            Sink::Held(Some(held)) => held.file.write(bytes),
            Sink::Held(None) => Err(ErrorKind::BrokenPipe.into()),
            Sink::Device(file) => file.write(bytes),
            Sink::Stdout(out) => out.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.sink {
            Sink::Held(Some(held)) => held.file.flush(),
            Sink::Held(None) => Ok(()),
            Sink::Device(file) => file.flush(),
            Sink::Stdout(out) => out.flush(),
        }
    }
}

/// Whether two paths lead to the same file, which exists; also through links of either kind.
#[must_use]
pub fn same_file(a: &Path, b: &Path) -> bool {
    let (Ok(real_a), Ok(real_b)) = (fs::canonicalize(a), fs::canonicalize(b)) else {
        return false;
    };
    real_a == real_b || same_inode(&real_a, &real_b)
}

#[cfg(unix)]
fn same_inode(a: &Path, b: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    match (fs::metadata(a), fs::metadata(b)) {
        (Ok(a), Ok(b)) => (a.dev(), a.ino()) == (b.dev(), b.ino()),
        _ => false,
    }
}

#[cfg(not(unix))]
fn same_inode(_: &Path, _: &Path) -> bool {
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(folder)
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn an_abandoned_output_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.ply");
        fs::write(&path, "old").unwrap();
        let mut output = OutputFile::create(&path, None).unwrap();
        output.write_all(b"new").unwrap();
        assert_eq!(names(folder.path()).len(), 2);
        drop(output);
        assert_eq!(names(folder.path()), ["a.ply"]);
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
    }

    #[test]
    fn a_committed_output_replaces_the_old_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.ply");
        fs::write(&path, "old and long").unwrap();
        let mut output = OutputFile::create(&path, None).unwrap();
        output.write_all(b"new").unwrap();
        output.commit().unwrap();
        assert_eq!(names(folder.path()), ["a.ply"]);
        assert_eq!(fs::read_to_string(&path).unwrap(), "new");
    }

    #[test]
    fn a_failing_commit_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.ply");
        let output = OutputFile::create(&path, None).unwrap();
        // A folder takes the name meanwhile: a file cannot be renamed over it.
        fs::create_dir(&path).unwrap();
        assert!(matches!(output.commit(), Err(ScanError::Write { .. })));
        assert_eq!(names(folder.path()), ["a.ply"]);
    }

    #[test]
    fn several_outputs_appear_together_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let open = |name: &str| OutputFile::create(&folder.path().join(name), None).unwrap();
        let outputs = vec![open("a.png"), open("b.mtl"), open("c.obj")];
        // A folder takes the last one's name meanwhile.
        fs::create_dir(folder.path().join("c.obj")).unwrap();
        assert!(OutputFile::commit_all(outputs).is_err());
        assert_eq!(names(folder.path()), ["c.obj"]);
        let mut outputs = vec![open("a.png"), open("b.mtl")];
        outputs[0].write_all(b"pixels").unwrap();
        OutputFile::commit_all(outputs).unwrap();
        assert_eq!(names(folder.path()), ["a.png", "b.mtl", "c.obj"]);
        assert_eq!(fs::read(folder.path().join("a.png")).unwrap(), b"pixels");
    }

    #[test]
    fn the_input_is_protected_under_every_name() {
        let folder = tempfile::tempdir().unwrap();
        let input = folder.path().join("a.ply");
        fs::write(&input, "scan").unwrap();
        let mut paths = vec![input.clone(), folder.path().join("./a.ply")];
        #[cfg(unix)]
        {
            paths.push(folder.path().join("link.ply"));
            std::os::unix::fs::symlink(&input, &paths[2]).unwrap();
            paths.push(folder.path().join("hard.ply"));
            fs::hard_link(&input, &paths[3]).unwrap();
        }
        for path in paths {
            let error = OutputFile::create(&path, Some(&input)).unwrap_err();
            assert!(matches!(error, ScanError::WouldOverwrite { .. }), "{error}");
            drop(OutputFile::create(&path, None).unwrap());
        }
        assert_eq!(fs::read_to_string(&input).unwrap(), "scan");
    }

    #[test]
    #[cfg(unix)]
    fn a_link_stays_a_link() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("target.ply");
        let link = folder.path().join("link.ply");
        fs::write(&target, "old").unwrap();
        std::os::unix::fs::symlink(&target, &link).unwrap();
        let mut output = OutputFile::create(&link, None).unwrap();
        output.write_all(b"new").unwrap();
        output.commit().unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read_to_string(&target).unwrap(), "new");
    }

    #[test]
    #[cfg(unix)]
    fn a_device_is_written_to_and_not_replaced() {
        let mut output = OutputFile::create(Path::new("/dev/null"), None).unwrap();
        output.write_all(b"gone").unwrap();
        output.commit().unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }

    #[test]
    fn unusable_paths_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let error = OutputFile::create(&folder.path().join("no/a.ply"), None).unwrap_err();
        assert!(matches!(error, ScanError::NoFolder { .. }), "{error}");
        let error = OutputFile::create(folder.path(), None).unwrap_err();
        assert!(matches!(error, ScanError::IsFolder { .. }), "{error}");
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        let error = OutputFile::create(&file.join("a.ply"), None).unwrap_err();
        assert!(matches!(error, ScanError::NoFolder { .. }), "{error}");
        let mut permissions = fs::metadata(&file).unwrap().permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&file, permissions).unwrap();
        let error = OutputFile::create(&file, None).unwrap_err();
        assert!(matches!(error, ScanError::Write { .. }), "{error}");
        assert_eq!(names(folder.path()), ["file"]);
    }

    #[test]
    #[cfg(unix)]
    fn a_read_only_folder_is_noticed_at_once() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o555)).unwrap();
        if File::create_new(folder.path().join("probe")).is_ok() {
            println!("skipped: this user may write to read-only folders");
            return;
        }
        let error = OutputFile::create(&folder.path().join("a.ply"), None).unwrap_err();
        assert!(matches!(error, ScanError::Write { .. }), "{error}");
    }
}
