//! Patterns for names of scans.

use std::path::{Component, Path, PathBuf};

use anyhow::Context;
use glob::{Pattern, glob};

use super::super::outcome::Failure;
use super::given::Given;

pub(super) fn is_pattern(path: &Path) -> bool {
    path.to_string_lossy().contains(['*', '?', '['])
}

/// What of a pattern is no pattern.
fn fixed_folder(pattern: &Path) -> PathBuf {
    let fixed = (pattern.components())
        .take_while(|part| !is_pattern(Path::new(part.as_os_str())))
        // The paths that are found are without it.
        .filter(|part| *part != Component::CurDir);
    fixed.collect()
}

/// The scans that a pattern finds, in order; none that lies in `results`.
pub(super) fn matching(pattern: &Path, results: &Path) -> Result<Vec<Given>, Failure> {
    let shown = pattern.display();
    let text = pattern
        .to_str()
        .ok_or_else(|| Failure::usage(format!("{shown}: a pattern must be valid Unicode")))?;
    let wrong = |error| Failure::usage(format!("{shown}: this pattern cannot be: {error}"));
    let found = glob(text).map_err(wrong)?;
    let folder = fixed_folder(pattern);
    let asked_for = hidden_patterns(pattern).map_err(wrong)?;
    let results = std::fs::canonicalize(results).ok();
    let mut scans = Vec::new();
    for path in found {
        let path = path.with_context(|| shown.to_string())?;
        let below = path.strip_prefix(&folder).unwrap_or(&path);
        if is_hidden(below, &asked_for) {
            continue;
        }
        let real = std::fs::canonicalize(&path).ok();
        let is_result =
            matches!((&real, &results), (Some(real), Some(results)) if real.starts_with(results));
        if path.is_file() && !is_result {
            scans.push(Given::new(&path, below));
        }
    }
    if scans.is_empty() {
        return Err(Failure::usage(format!(
            "{shown}: no file matches this pattern (those in the folder of results do not count)"
        )));
    }
    Ok(scans)
}

/// The parts of a pattern that ask for hidden names.
fn hidden_patterns(pattern: &Path) -> Result<Vec<Pattern>, glob::PatternError> {
    let parts = pattern.components().filter_map(|part| match part {
        Component::Normal(name) => name.to_str(),
        _ => None,
    });
    let hidden = parts.filter(|part| part.starts_with('.'));
    hidden.map(Pattern::new).collect()
}

/// Whether a hidden name is in a path that no part of the pattern asks for. The patterns' own option for that panics at
/// names that are no Unicode.
fn is_hidden(path: &Path, asked_for: &[Pattern]) -> bool {
    path.components().any(|part| match part {
        Component::Normal(name) => {
            let name = name.to_string_lossy();
            name.starts_with('.') && !asked_for.iter().any(|pattern| pattern.matches(&name))
        }
        _ => false,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place() -> tempfile::TempDir {
        let place = tempfile::tempdir().unwrap();
        for name in [
            "s/a/1.ply",
            "s/a/2.ply",
            "s/b/1.ply",
            "s/b/.hidden.ply",
            "s/.folder/1.ply",
            "s/out/1.ply",
        ] {
            let path = place.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, "").unwrap();
        }
        place
    }

    fn found(root: &Path, pattern: &str) -> Vec<String> {
        let scans = matching(&root.join(pattern), &root.join("s/out")).unwrap();
        let names = scans.iter().map(|given| given.below.display().to_string());
        names.collect()
    }

    #[test]
    fn patterns_give_paths_below_what_is_fixed_in_them() {
        let place = place();
        let root = place.path();
        assert_eq!(found(root, "s/**/*.ply"), ["a/1.ply", "a/2.ply", "b/1.ply"]);
        assert_eq!(found(root, "s/a/?.ply"), ["1.ply", "2.ply"]);
        for nothing in ["s/*.obj", "s/out/*.ply", "s/[.ply"] {
            let wrong = matching(&root.join(nothing), &root.join("s/out"));
            assert!(wrong.unwrap_err().usage, "{nothing}");
        }
        assert_eq!(fixed_folder(Path::new("./s/a/*.ply")), Path::new("s/a"));
    }

    #[test]
    fn hidden_names_are_found_where_the_pattern_asks_for_them() {
        let place = place();
        let root = place.path();
        assert_eq!(found(root, "s/b/.*.ply"), [".hidden.ply"]);
        assert_eq!(found(root, "s/**/.h*.ply"), ["b/.hidden.ply"]);
        assert_eq!(found(root, "s/.folder/*.ply"), ["1.ply"]);
        assert_eq!(found(root, "s/.f*/*.ply"), [".folder/1.ply"]);
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn names_that_are_no_unicode_are_passed_over() {
        use std::os::unix::ffi::OsStrExt;
        let place = place();
        let root = place.path();
        // As Latin-1 has it.
        let name = std::ffi::OsStr::from_bytes(b"caf\xe9.ply");
        std::fs::write(root.join("s/a").join(name), "").unwrap();
        std::fs::create_dir(root.join("s").join(std::ffi::OsStr::from_bytes(b"\xe9"))).unwrap();
        assert_eq!(found(root, "s/a/*.ply"), ["1.ply", "2.ply"]);
        assert_eq!(found(root, "s/**/*.ply"), ["a/1.ply", "a/2.ply", "b/1.ply"]);
    }
}
