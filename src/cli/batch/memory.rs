//! Memory: how much a scan may take, and how much there is.

use std::path::Path;

/// What the program takes by itself, in bytes.
const PROGRAM: u64 = 64 << 20;
/// Bytes of memory for each byte of a file. Measured on scans of 5 000 to 400 000 vertices, as PLY of 50 bytes a vertex:
/// 1 to 2.4 KB a vertex beside the tables, most of it on free form.
const PER_BYTE: u64 = 40;
/// The same for files that are packed: LAZ has some 10 bytes a point.
const PER_PACKED_BYTE: u64 = 200;
/// Tables of the coherent method with 8192 sites rarely take more, in bytes (measured: 10 to 170 MB).
const USUAL_TABLES: u64 = 256 << 20;

/// What a scan is taken to need, in bytes, before it is read. What it really takes is watched.
pub(super) fn estimate(input: &Path, tables: u64) -> u64 {
    // A file that is not there needs nothing.
    let size = std::fs::metadata(input).map_or(0, |file| file.len());
    let extension = input.extension().unwrap_or_default().to_ascii_lowercase();
    let packed = ["laz", "e57", "png", "tif", "tiff"]
        .iter()
        .any(|known| extension == *known);
    let factor = if packed { PER_PACKED_BYTE } else { PER_BYTE };
    PROGRAM
        .saturating_add(size.saturating_mul(factor))
        .saturating_add(tables.min(USUAL_TABLES))
}

/// Nine tenths of the memory that is free now, in bytes, where the system tells.
pub(super) fn available() -> Option<u64> {
    let free = field("/proc/meminfo", "MemAvailable")?;
    // A container may have less than the machine.
    let limit = std::fs::read_to_string("/sys/fs/cgroup/memory.max");
    let limit = limit.ok().and_then(|text| text.trim().parse().ok());
    Some(free.min(limit.unwrap_or(u64::MAX)) / 10 * 9)
}

/// What Linux tells of a process (its number, or `self`), in bytes: `VmRSS` is what it has now, `VmHWM` the most it had.
pub(super) fn of_process(id: &str, name: &str) -> Option<u64> {
    field(&format!("/proc/{id}/status"), name)
}

fn field(path: &str, name: &str) -> Option<u64> {
    let text = std::fs::read_to_string(path).ok()?;
    let is_named = |line: &&str| {
        line.strip_prefix(name)
            .is_some_and(|rest| rest.starts_with(':'))
    };
    let (_, value) = text.lines().find(is_named)?.split_once(':')?;
    let kibibytes: u64 = value.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes << 10)
}

/// A number of bytes for people.
pub(super) fn in_words(bytes: u64) -> String {
    format!("{:.0} MiB", bytes as f64 / 1_048_576.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn estimates_grow_with_files_and_with_tables_up_to_what_they_usually_take() {
        let place = tempfile::tempdir().unwrap();
        let [ply, laz] = ["a.ply", "a.LAZ"].map(|name| place.path().join(name));
        for path in [&ply, &laz] {
            std::fs::write(path, vec![0; 1000]).unwrap();
        }
        assert_eq!(estimate(&ply, 0), PROGRAM + 40_000);
        assert_eq!(estimate(&laz, 5), PROGRAM + 200_005);
        assert_eq!(estimate(&ply, u64::MAX), PROGRAM + 40_000 + USUAL_TABLES);
        assert_eq!(estimate(Path::new("none.ply"), 0), PROGRAM);
    }

    #[test]
    fn memory_is_told_in_words() {
        assert_eq!(in_words(3 << 29), "1536 MiB");
    }

    #[test]
    fn memory_of_processes_is_told_on_linux() {
        for name in ["VmRSS", "VmHWM"] {
            let own = of_process("self", name);
            assert_eq!(own.is_some(), cfg!(target_os = "linux"), "{name}");
            assert!(own.is_none_or(|bytes| bytes > 1 << 20), "{name}");
        }
        assert_eq!(of_process("0", "VmRSS"), None);
    }
}
