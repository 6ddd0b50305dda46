//! Where results go: never over an input, never two to one place, and into pipes that close early.

mod common;

use std::fs;
use std::process::{Command, Stdio};

use common::place::Place;
use common::synthetic;
use relievo::synth::{Kind, Part};

/// Two scans, and other names of both.
fn place() -> Place {
    let scan = synthetic(Kind::Waves, Part::FULL);
    let place = Place::with("a.ply", &scan);
    place.put("b.ply", &scan);
    #[cfg(unix)]
    for (name, link) in [("a.ply", "a-link"), ("b.ply", "b-link")] {
        fs::hard_link(place.path(name), place.path(link)).expect("links can be made");
        let soft = place.path(&format!("{link}-soft"));
        std::os::unix::fs::symlink(name, soft).expect("links can be made");
    }
    place
}

/// Every name of the two scans.
fn names() -> Vec<&'static str> {
    let mut names = vec!["a.ply", "b.ply", "./b.ply"];
    if cfg!(unix) {
        names.extend(["a-link", "b-link", "a-link-soft", "b-link-soft"]);
    }
    names
}

#[test]
fn no_option_writes_over_either_scan_of_a_comparison() {
    let place = place();
    let before = [place.bytes("a.ply"), place.bytes("b.ply")];
    let mut options = vec!["--json", "--csv"];
    if cfg!(feature = "report") {
        options.push("--report");
    }
    for option in options {
        for name in names() {
            let line = format!("compare a.ply b.ply --pieces 0 {option} {name}");
            if option == "--json" {
                // There is nowhere left for the JSON to tell of it.
                let run = place.run(&line);
                assert_eq!(run.code, 2, "{line}: {}", run.stderr);
                let told = run.stderr.contains(name) && run.stderr.contains("--json");
                assert!(told && run.stdout.is_empty(), "{line}: {}", run.stderr);
            } else {
                place.refused(2, &line, &[name, option, "overwrite"]);
            }
            assert!(place.bytes("a.ply") == before[0], "{line}");
            assert!(place.bytes("b.ply") == before[1], "{line}");
        }
    }
}

#[test]
fn no_two_options_write_to_one_file() {
    let place = place();
    let mut pairs = vec![("new.txt", "./new.txt")];
    #[cfg(unix)]
    {
        place.text("old.txt", "old");
        fs::hard_link(place.path("old.txt"), place.path("older.txt")).expect("links can be made");
        pairs.push(("old.txt", "older.txt"));
    }
    for (first, second) in pairs {
        let compare = "compare a.ply b.ply --pieces 0";
        if cfg!(feature = "report") {
            let line = format!("{compare} --csv {first} --report {second}");
            place.refused(2, &line, &["--csv", "--report", "another name"]);
        }
        let run = place.run(&format!("{compare} --json {first} --csv {second}"));
        assert_eq!(run.code, 2, "{first}: {}", run.stderr);
        assert!(run.stderr.contains("--csv"), "{first}: {}", run.stderr);
        // That the command fails, and why, is what the JSON is for.
        assert_eq!(place.json(first)["status"], "failed");
    }
    #[cfg(unix)]
    assert_eq!(place.bytes("older.txt"), b"old");
}

#[test]
fn a_pipe_that_is_closed_early_is_no_failure() {
    let place = place();
    for line in [
        "compare a.ply b.ply --pieces 0 --csv -",
        "stats a.ply --whole --csv -",
        "compare a.ply b.ply --pieces 0 --json -",
    ] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_relievo"))
            .args(line.split_whitespace())
            .current_dir(place.0.path())
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        // As `head` does that has read enough.
        drop(child.stdout.take());
        let output = child.wait_with_output().expect("the program ends");
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{line}: {stderr}");
        assert!(stderr.is_empty(), "{line}: {stderr}");
    }
}

#[test]
fn a_file_called_like_standard_output_is_a_file() {
    let place = place();
    let run = Command::new(env!("CARGO_BIN_EXE_relievo"))
        .args(["stats", "a.ply", "--whole", "--csv", "standard output"])
        .current_dir(place.0.path())
        .output()
        .expect("the program starts");
    assert!(run.status.success());
    let table = String::from_utf8(run.stdout).expect("tables are UTF-8");
    assert!(table.contains("base area"), "{table}");
    let csv = fs::read_to_string(place.path("standard output")).expect("it is there");
    assert!(csv.starts_with("name,unit,value\n"), "{csv}");
}

#[test]
#[cfg(not(feature = "image"))]
fn pictures_that_this_build_cannot_write_are_refused_before_the_scan_is_read() {
    let place = Place::new();
    let line = "render none.ply -o out.png";
    place.refused(2, line, &["built without pictures", "--features image"]);
}
