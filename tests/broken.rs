//! Broken files, and exactly what is said of each: `scripts/make_broken.py` makes them.
//!
//! `REGENERATE=1 cargo test --test broken` notes what is said now.

mod common;

use std::fmt::Write;
use std::fs;
use std::path::Path;

use common::place::Place;

/// One line a file: name, exit code of `relievo info`, and what it writes to standard error.
const EXPECTED: &str = "expected.tsv";

#[test]
fn every_broken_file_gets_its_message() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/broken");
    let mut names: Vec<String> = fs::read_dir(&folder)
        .expect("the corpus is there")
        .map(|entry| entry.expect("it can be listed").file_name())
        .map(|name| name.into_string().expect("names are UTF-8"))
        .filter(|name| name != EXPECTED)
        .collect();
    names.sort();
    assert!(names.len() >= 60, "only {} files", names.len());
    let place = Place::new();
    let mut found = String::new();
    for name in &names {
        fs::copy(folder.join(name), place.path(name)).expect("there is room");
        let run = place.run(&format!("info {name} --intrinsics 500,500,2,2"));
        let said = run
            .stderr
            .trim_end()
            .replace("relievo: ", "")
            .replace('\n', " / ");
        let _ = writeln!(found, "{name}\t{}\t{said}", run.code);
        if run.code != 0 {
            assert!(run.stdout.is_empty(), "{name}");
            assert!(said.contains(name.as_str()), "{name} is not named: {said}");
        }
    }
    let path = folder.join(EXPECTED);
    if std::env::var_os("REGENERATE").is_some() {
        fs::write(&path, &found).expect("the table can be written");
    }
    let expected = fs::read_to_string(&path).expect("the table can be read");
    for (expected, found) in expected.lines().zip(found.lines()) {
        assert_eq!(expected, found);
    }
    assert_eq!(expected.lines().count(), found.lines().count());
}
