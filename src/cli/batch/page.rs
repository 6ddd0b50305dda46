//! The page of a batch.

use std::path::{Component, Path, PathBuf};

use crate::report::{BatchPage, BatchScan, Picture};
use crate::scan::OutputFile;

use super::super::outcome::Failure;
use super::line::{Counts, Line};
use super::plan::Job;
use super::protocol::Status;

/// As many scans have pictures on the page, which would be too large for a browser otherwise.
const MOST_PICTURES: usize = 500;

/// Writes it to `path`, which is open already.
pub(super) fn write(
    mut output: OutputFile,
    path: &Path,
    folder: &Path,
    jobs: &[Job],
    lines: &[Line],
) -> Result<(), Failure> {
    let from = leading(path);
    let mut scans: Vec<BatchScan> = lines.iter().map(|line| scan(line, &from)).collect();
    let good = (scans.iter_mut().zip(jobs)).filter(|(scan, _)| scan.error.is_none());
    for (scan, job) in good.take(MOST_PICTURES) {
        let pictures = job.names(folder).pictures();
        for (what, path) in ["before", "after"].iter().zip(pictures) {
            // Where there is none, there was nothing to draw.
            if let Ok(png) = std::fs::read(path) {
                scan.pictures.push(Picture {
                    text: format!("{}, {what}", scan.name),
                    png,
                });
            }
        }
    }
    let page = BatchPage {
        title: format!("{} scans", lines.len()),
        lead: lead(lines),
        scans,
    };
    match page.write(&mut output) {
        Ok(()) => Ok(output.commit()?),
        Err(error) => Err(output.error(error).into()),
    }
}

fn lead(lines: &[Line]) -> String {
    let counts = Counts::of(lines);
    let good = counts.all - counts.failed;
    let mut text = if counts.failed == 0 {
        format!("All {good} scans have a result")
    } else {
        format!(
            "{good} of {} scans have a result; {} failed",
            counts.all, counts.failed
        )
    };
    if counts.partly > 0 {
        text.push_str(&format!("; in {} some gaps stayed open", counts.partly));
    }
    if counts.skipped > 0 {
        text.push_str(&format!("; {} were there already", counts.skipped));
    }
    text + "."
}

fn scan(line: &Line, from: &Path) -> BatchScan {
    let status = match (line.status, line.was) {
        (Status::Failed, _) => "failed",
        (Status::Partly, _) => "done in part",
        (Status::Done, _) => "done",
        (Status::Skipped, Some(Status::Partly)) => "there already, in part",
        (Status::Skipped, _) => "there already",
    };
    let is_failed = line.status == Status::Failed;
    let link = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        [name.into_owned(), address(path, from)]
    };
    BatchScan {
        name: line.input.clone(),
        status: status.to_owned(),
        error: is_failed.then(|| line.error.clone().unwrap_or_default()),
        gaps: ["filled", "left_open"].map(|name| line.counts[name].as_u64()),
        seconds: line.seconds,
        peak_memory: line.peak_memory,
        warnings: line.warnings.clone(),
        files: if is_failed {
            Vec::new()
        } else {
            line.written.iter().map(link).collect()
        },
        pictures: Vec::new(),
    }
}

/// The folder of a file, without links.
fn leading(path: &Path) -> PathBuf {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    std::fs::canonicalize(folder).unwrap_or_else(|_| folder.to_owned())
}

/// The address of a file for a page in a folder: relative, so that both can be moved together.
fn address(path: &Path, from: &Path) -> String {
    let path = leading(path).join(path.file_name().unwrap_or_default());
    let mut rest = path.components().peekable();
    let mut folders = from.components().peekable();
    while let (Some(a), Some(b)) = (rest.peek(), folders.peek())
        && a == b
    {
        rest.next();
        folders.next();
    }
    let up = folders.map(|_| "..".to_owned());
    let down = rest.filter_map(|part| match part {
        Component::Normal(name) => Some(encoded(&name.to_string_lossy())),
        _ => None,
    });
    up.chain(down).collect::<Vec<_>>().join("/")
}

/// A name in an address (RFC 3986, 2.1): what is not unreserved is told by its bytes.
fn encoded(name: &str) -> String {
    let byte = |byte: u8| match byte {
        b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' => {
            char::from(byte).to_string()
        }
        _ => format!("%{byte:02X}"),
    };
    name.bytes().map(byte).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_lead_from_the_page_to_the_file() {
        let place = tempfile::tempdir().unwrap();
        let root = std::fs::canonicalize(place.path()).unwrap();
        for folder in ["out/sub", "pages"] {
            std::fs::create_dir_all(root.join(folder)).unwrap();
        }
        let file = root.join("out/sub/a b#1%.ply");
        assert_eq!(
            address(&file, &leading(&root.join("out/x.html"))),
            "sub/a%20b%231%25.ply"
        );
        assert_eq!(
            address(&file, &root.join("pages")),
            "../out/sub/a%20b%231%25.ply"
        );
    }
}
