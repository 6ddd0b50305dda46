//! Batches that are killed, ended, or meet each other.
#![cfg(target_os = "linux")]

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;

use super::{QUICK, assert_clean, counted, good, lines, results};
use crate::common::place::Place;
use crate::common::{say_skipped, synthetic};
use relievo::synth::{Kind, Part, SynthParams, scan};

/// A batch that nobody waits for; it is killed with the test that has begun it.
struct Begun(Option<Child>);

impl Begun {
    fn id(&self) -> i32 {
        let child = self.0.as_ref().expect("it is waited for once");
        i32::try_from(child.id()).expect("numbers of processes are small")
    }

    /// Whether it has ended.
    fn has_ended(&mut self) -> bool {
        let child = self.0.as_mut().expect("it is waited for once");
        child.try_wait().expect("it can be asked").is_some()
    }

    fn killed(self) {
        drop(self);
    }

    fn ended(mut self) -> Output {
        let child = self.0.take().expect("it is waited for once");
        child.wait_with_output().expect("it ends")
    }
}

impl Drop for Begun {
    fn drop(&mut self) {
        if let Some(mut child) = self.0.take() {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

fn begun(place: &Place, line: &str) -> Begun {
    let child = Command::new(env!("CARGO_BIN_EXE_relievo"))
        .args(line.split_whitespace())
        .current_dir(place.0.path())
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn();
    Begun(Some(child.expect("the program starts")))
}

/// Numbers of the processes of scans that are at work in a folder.
fn at_work(place: &Place) -> Vec<i32> {
    let root = fs::canonicalize(place.0.path()).expect("the folder is there");
    let is_ours = |process: &Path| {
        let command = fs::read(process.join("cmdline")).unwrap_or_default();
        let folder = fs::read_link(process.join("cwd")).ok();
        command.ends_with(b"batch-job\0") && folder.is_some_and(|folder| folder == root)
    };
    let processes = fs::read_dir("/proc")
        .expect("this is Linux")
        .filter_map(Result::ok);
    processes
        .filter(|process| is_ours(&process.path()))
        .filter_map(|process| process.file_name().to_str()?.parse().ok())
        .collect()
}

/// Waits until it holds, however slow the machine is.
#[track_caller]
fn wait_until(what: &str, holds: impl Fn() -> bool) {
    let since = Instant::now();
    while !holds() {
        assert!(
            since.elapsed() < Duration::from_secs(300),
            "not yet: {what}"
        );
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Whether an output is open in `out`.
fn has_temporary(place: &Place) -> bool {
    let files = fs::read_dir(place.path("out")).into_iter().flatten();
    (files.filter_map(Result::ok)).any(|file| file.file_name().to_string_lossy().ends_with(".tmp"))
}

fn send(signal: Signal, process: i32) {
    // It may have ended meanwhile.
    let _ = kill(Pid::from_raw(process), signal);
}

/// Whether this process, and so what it starts, ignores the signal.
fn is_ignored(signal: Signal) -> bool {
    let status = fs::read_to_string("/proc/self/status").expect("this is Linux");
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = u64::from_str_radix(mask.expect("it is told").trim(), 16);
    mask.expect("it is hexadecimal") >> (signal as u32 - 1) & 1 == 1
}

/// A scan that takes minutes by the paper's method.
fn slow(place: &Place, name: &str) {
    large(place, name, 0.1);
}

/// A scan with a hole of this share of its surface.
fn large(place: &Place, name: &str, hole: f64) {
    let params = SynthParams {
        kind: Kind::Bricks,
        vertices: 20_000,
        part: Part::hole(hole),
        ..SynthParams::default()
    };
    place.put(
        name,
        &scan(&params).expect("the parameters are in range").scan,
    );
}

const SLOW: &str = "--step.complete.method=paper";

#[test]
fn a_batch_that_is_killed_at_any_moment_goes_on_to_the_same_results() {
    let place = good(6);
    place.done(&format!("batch scans/*.ply --out whole {QUICK}"));
    let expected = results(&place, "whole");
    let line = format!("batch scans/*.ply --out out {QUICK} --resume --jobs 2");
    let mut ends = 0;
    // Any moment is right, on fast machines and on slow ones: nothing is waited for.
    for moment in [0, 30, 60, 90, 130, 180, 250, 350, 500] {
        let mut child = begun(&place, &line);
        std::thread::sleep(Duration::from_millis(moment));
        ends += u32::from(child.has_ended());
        child.killed();
        // Nothing that is there is half a result.
        if place.path("out").exists() {
            for (name, bytes) in results(&place, "out") {
                let is_whole = expected.get(&name).is_some_and(|whole| *whole == bytes);
                assert!(
                    is_whole || name.ends_with(".tmp"),
                    "{name} after {moment} ms"
                );
            }
        }
    }
    println!("{ends} of 9 had ended before they were killed");
    let run = place.done(&line);
    assert!(results(&place, "out") == expected);
    assert_clean(&place, "out");
    assert_eq!(lines(&run).len(), 6);
    wait_until("no process is left", || at_work(&place).is_empty());
    assert_eq!(counted(&place.done(&line))["skipped"], 6);
}

#[test]
fn processes_of_scans_end_with_their_batch_and_take_their_files_with_them() {
    let place = Place::new();
    slow(&place, "a.ply");
    slow(&place, "b.ply");
    let child = begun(
        &place,
        // Room for both, however little is free.
        &format!("batch a.ply b.ply --out out --jobs 2 --memory 4GiB {SLOW}"),
    );
    let has_begun = || fs::read_dir(place.path("out")).is_ok_and(|files| files.count() >= 3);
    wait_until("both scans are worked on", has_begun);
    child.killed();
    wait_until("no process is left", || at_work(&place).is_empty());
    assert!(results(&place, "out").is_empty());
    assert_clean(&place, "out");
}

#[test]
fn an_interrupt_ends_all_and_leaves_nothing_half_written() {
    for signal in [Signal::SIGINT, Signal::SIGTERM] {
        if is_ignored(signal) {
            // As of what a script starts in the background; programs that it starts leave it so.
            say_skipped(&format!("{signal} is ignored here"));
            continue;
        }
        let place = good(1);
        slow(&place, "slow.ply");
        let jobs = r#"{"jobs": ["scans/0.ply", {"input": "slow.ply", "options": {"complete": {"method": "paper", "window": 5, "rotations": 36}}}]}"#;
        place.text("jobs.json", jobs);
        let line = format!("batch jobs.json --out out --jobs 2 --memory 4GiB {QUICK}");
        let child = begun(&place, &line);
        wait_until("the quick one is done", || {
            place.path("out/.relievo/scans/0.ply.json").exists()
        });
        wait_until("the slow one has begun", || !at_work(&place).is_empty());
        send(signal, child.id());
        let output = child.ended();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(130), "{stderr}");
        assert!(
            stderr.contains("--resume") && !stderr.contains("failed"),
            "{stderr}"
        );
        assert!(at_work(&place).is_empty(), "a process is left");
        let names: Vec<String> = results(&place, "out").into_keys().collect();
        assert_eq!(names, ["scans/0.ply"]);
        assert_clean(&place, "out");
        let told = String::from_utf8_lossy(&output.stdout);
        assert!(!told.contains("slow.ply"), "{told}");
    }
}

#[test]
fn a_process_that_is_killed_is_one_failure() {
    let place = good(2);
    slow(&place, "slow.ply");
    let jobs = r#"{"jobs": [{"input": "slow.ply", "options": {"complete": {"method": "paper", "window": 5, "rotations": 36}}}, "scans/0.ply", "scans/1.ply"]}"#;
    place.text("jobs.json", jobs);
    let child = begun(
        &place,
        &format!("batch jobs.json --out out --jobs 1 {QUICK}"),
    );
    wait_until("the slow one writes", || has_temporary(&place));
    for process in at_work(&place) {
        send(Signal::SIGKILL, process);
    }
    let output = child.ended();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(
        stderr.contains("slow.ply: its process ended by SIGKILL"),
        "{stderr}"
    );
    let names: Vec<String> = results(&place, "out").into_keys().collect();
    assert_eq!(names, ["scans/0.ply", "scans/1.ply"]);
    assert_clean(&place, "out");
}

#[test]
fn two_batches_are_never_at_work_in_one_folder() {
    let place = good(1);
    slow(&place, "slow.ply");
    let child = begun(&place, &format!("batch slow.ply --out out {SLOW}"));
    wait_until("the first has begun", || !at_work(&place).is_empty());
    let run = place.run(&format!("batch scans/*.ply --out out {QUICK}"));
    assert_eq!(run.code, 2, "{}", run.stderr);
    assert!(run.stderr.contains("another batch"), "{}", run.stderr);
    assert!(
        results(&place, "out")
            .keys()
            .all(|name| name.ends_with(".tmp"))
    );
    child.killed();
    // It waits for what the first has left.
    place.done(&format!("batch scans/*.ply --out out {QUICK}"));
    assert!(at_work(&place).is_empty(), "a process is left");
    assert_clean(&place, "out");
}

#[test]
fn a_scan_that_changes_while_it_is_worked_on_is_done_again() {
    let place = Place::new();
    large(&place, "a.ply", 0.01);
    let child = begun(
        &place,
        &format!("batch a.ply --out out --timeout 300 {QUICK}"),
    );
    // Its output is opened just before it is read. It may have ended already: that is right, too.
    wait_until("it is read", || {
        has_temporary(&place) || place.path("out/.relievo/a.ply.json").exists()
    });
    place.put("a.ply", &synthetic(Kind::Bricks, Part::hole(0.03)));
    let output = child.ended();
    // Whichever content it has read, the record does not lie.
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(matches!(output.status.code(), Some(0 | 1)), "{stderr}");
    place.done(&format!("batch a.ply --out out {QUICK} --resume"));
    place.done(&format!("batch a.ply --out whole {QUICK}"));
    assert!(results(&place, "out") == results(&place, "whole"));
}
