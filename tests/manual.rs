//! Completions of shells and the manual's pages.

mod common;

use std::process::Command;

use common::place::Place;
use common::say_skipped;

/// Names of all commands, as the help lists them.
fn commands(place: &Place) -> Vec<String> {
    let help = String::from_utf8(place.done("--help").stdout).expect("help is UTF-8");
    let listed = help
        .lines()
        .skip_while(|line| *line != "Commands:")
        .skip(1)
        .take_while(|line| !line.is_empty());
    let names: Vec<String> = listed
        .filter(|line| line.starts_with("  ") && !line.starts_with("   "))
        .filter_map(|line| line.split_whitespace().next())
        .map(str::to_owned)
        .filter(|name| name != "help")
        .collect();
    assert!(names.contains(&"complete".to_owned()), "{help}");
    names
}

/// What a program says of a file, or `None`, said aloud, if the program is not there.
fn said_by(program: &str, arguments: &[&str], place: &Place) -> Option<(bool, String)> {
    let run = Command::new(program)
        .args(arguments)
        .current_dir(place.0.path())
        // Shells complain about locales that are not installed, and read files from home.
        .env("LC_ALL", "C")
        .env("HOME", place.0.path())
        .output();
    let Ok(output) = run else {
        say_skipped(&format!("{program} is not installed"));
        return None;
    };
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    Some((output.status.success(), stderr))
}

#[test]
fn scripts_of_completions_name_every_command_and_can_be_read_by_their_shells() {
    let place = Place::new();
    let commands = commands(&place);
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let run = place.done(&format!("completions {shell}"));
        assert!(run.stderr.is_empty(), "{shell}: {}", run.stderr);
        let script = String::from_utf8(run.stdout).expect("scripts are UTF-8");
        for command in &commands {
            assert!(script.contains(command), "{shell}: no {command}");
        }
        assert!(script.contains("no-repair"), "{shell}: no options");
        place.text(shell, &script);
    }
    for shell in ["bash", "zsh", "fish"] {
        if let Some((success, stderr)) = said_by(shell, &["-n", shell], &place) {
            assert!(success && stderr.is_empty(), "{shell}: {stderr}");
        }
    }
}

#[test]
fn a_shell_that_is_not_known_is_refused() {
    let place = Place::new();
    let run = place.run("completions tcsh");
    assert_eq!(run.code, 2, "{}", run.stderr);
    assert!(run.stderr.contains("bash"), "{}", run.stderr);
}

#[test]
fn every_command_has_a_page_that_renders_without_warnings() {
    let place = Place::new();
    let commands = commands(&place);
    place.done("man --out man/man1 --json pages.json");
    let mut expected: Vec<String> = commands
        .iter()
        .map(|name| format!("relievo-{name}.1"))
        .collect();
    expected.push("relievo.1".to_owned());
    expected.sort();
    let mut written: Vec<String> = std::fs::read_dir(place.path("man/man1"))
        .expect("the folder was made")
        .map(|entry| entry.expect("and can be read").file_name())
        .map(|name| name.into_string().expect("names are UTF-8"))
        .collect();
    written.sort();
    assert_eq!(written, expected);
    let told = place.json("pages.json")["pages"].as_array().map(Vec::len);
    assert_eq!(told, Some(expected.len()));
    for page in &expected {
        let path = format!("man/man1/{page}");
        let command = page.trim_start_matches("relievo-").trim_end_matches(".1");
        let command = command.trim_start_matches("relievo");
        let printed = place.done(&format!("man {command}")).stdout;
        assert!(printed == place.bytes(&path), "{page} printed and written");
        let text = String::from_utf8(printed).expect("pages are UTF-8");
        assert!(text.contains(r"\-\-seed"), "{page} has no common options");
        // As `man` does, with all of groff's warnings.
        let groff = ["-man", "-Tutf8", "-Kutf8", "-ww", "-z", &path];
        if let Some((success, stderr)) = said_by("groff", &groff, &place) {
            assert!(success && stderr.is_empty(), "{page}: {stderr}");
        }
    }
}

#[test]
fn pages_of_what_is_no_command_are_refused_with_those_that_there_are() {
    let place = Place::new();
    place.refused(2, "man fill", &["fill", "complete", "holes"]);
}
