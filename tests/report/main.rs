//! Reports as their readers see them: in a browser, without a network.
#![cfg(feature = "report")]

#[path = "../common/mod.rs"]
mod common;

mod browser;
#[cfg(feature = "image")]
mod textured;
#[cfg(feature = "image")]
mod transferred;

use common::place::Place;
use common::{holed, say_skipped};
use relievo::scan::{Column, Scan};
use relievo::synth::Kind;
use serde_json::Value;

const QUICK: &str = "--window 2 --rotations 1";

/// A wall with a hole; red rises from left to right.
fn colored() -> Scan {
    let mut scan = holed(Kind::Bricks);
    let rows = scan.vertices.rows;
    let ramp: Vec<u8> = (0..=255u8).cycle().take(rows).collect();
    for (name, values) in [
        ("red", ramp),
        ("green", vec![90; rows]),
        ("blue", vec![40; rows]),
    ] {
        scan.vertices.set_channel(name, Column::U8(values));
    }
    scan
}

/// The report of a small completed scan.
fn reported(scan: &Scan, name: &str) -> Place {
    let place = Place::with(name, scan);
    place.done(&format!(
        "complete {name} -o out.ply {QUICK} --report report.html"
    ));
    place
}

fn html(place: &Place) -> String {
    String::from_utf8(place.bytes("report.html")).expect("pages are UTF-8")
}

/// The page without what its script elements hold.
fn markup(html: &str) -> String {
    let mut out = String::new();
    let mut rest = html;
    while let Some((before, behind)) = rest.split_once("<script") {
        out.push_str(before);
        rest = behind.split_once("</script>").expect("it ends").1;
    }
    out + rest
}

/// Neither addresses nor the folder of the files are named.
fn assert_stands_alone(page: &str, place: &Place) {
    for address in ["http://", "https://", " src=", " href=", "url(", "@import"] {
        assert!(!page.contains(address), "{address}");
    }
    assert!(!page.contains(&place.0.path().display().to_string()));
}

#[test]
fn the_page_says_what_was_done_and_names_no_address() {
    let place = reported(&colored(), "in.ply");
    let page = markup(&html(&place));
    for words in [
        "<html lang=\"en\">",
        "name=\"viewport\"",
        "<noscript>",
        "The gap is filled",
        "Written by relievo",
        "<th scope=\"row\">seed</th><td>0</td>",
        "<th scope=\"row\">window</th><td class=\"number\">2</td><td>given</td>",
        "are shown.",
    ] {
        assert!(page.contains(words), "{words}");
    }
    assert_stands_alone(&page, &place);
}

#[test]
fn the_same_scan_gives_the_same_page_with_any_number_of_threads() {
    let place = reported(&colored(), "in.ply");
    let first = html(&place);
    place.done(&format!(
        "complete in.ply -o out.ply {QUICK} --report report.html --threads 1"
    ));
    assert!(first == html(&place));
}

#[test]
fn markup_in_names_stays_text() {
    let mut scan = colored();
    scan.comments = vec!["</script><script>bad()</script>".to_owned()];
    let name = "<script>bad()<img-onerror='x'>.ply";
    let page = html(&reported(&scan, name));
    assert!(!page.contains("<script>bad()"));
    assert!(!page.contains("<img"));
    assert!(page.contains("&lt;script&gt;bad()&lt;img-onerror=&#39;x&#39;&gt;.ply"));
}

#[test]
fn a_page_that_cannot_be_written_is_noticed_before_the_work() {
    let place = Place::with("in.ply", &colored());
    let complete = "complete in.ply -o out.ply --report";
    place.refused(1, &format!("{complete} no/report.html"), &["no", "folder"]);
    place.refused(2, &format!("{complete} in.ply"), &["in.ply"]);
    place.refused(2, &format!("{complete} ./out.ply"), &["-o", "another name"]);
    place.refused(2, &format!("{complete} -"), &["report.html"]);
    let both = format!("{complete} a.html --json a.html");
    let run = place.run(&both);
    assert_eq!(run.code, 2, "{}", run.stderr);
    assert!(run.stderr.contains("--json a.html"), "{}", run.stderr);
}

#[test]
fn readers_see_before_and_after_and_every_channel() {
    let Some(browser) = browser::find() else {
        say_skipped("no Chromium on this machine; install Debian's package chromium");
        return;
    };
    let place = reported(&colored(), "in.ply");
    for width in [1280, 500] {
        let result = browser::probed(&browser, &place.path("report.html"), width);
        check(&result, width);
    }
}

fn check(result: &Value, width: u32) {
    assert_eq!(result["failed"], Value::Null, "{}", result["failed"]);
    assert_eq!(result["wrong"], Value::Array(Vec::new()), "at {width}");
    let start = &result["at_start"];
    assert!(start["colors"].as_u64() > Some(100), "{start}");
    assert!(start["covered"].as_f64() > Some(0.1), "{start}");
    let steps = result["steps"].as_array().expect("the probe lists them");
    let buttons: Vec<&str> = steps.iter().filter_map(|s| s["button"].as_str()).collect();
    let channels = ["shape", "color", "height", "source", "completed"];
    for channel in channels {
        assert!(buttons.contains(&channel), "{buttons:?}");
    }
    assert!(buttons.ends_with(&["before", "after"]), "{buttons:?}");
    for (index, step) in steps.iter().enumerate() {
        assert_eq!(step["pressed"], "true", "{step}");
        assert!(
            step["hash"]
                .as_str()
                .expect("it has an address")
                .contains(step["button"].as_str().expect("it is text"))
        );
        assert!(step["seen"]["colors"].as_u64() > Some(20), "{step}");
        // All channels look different, and so do before and after.
        for other in &steps[..index] {
            let same_by_right = step["button"] == "after" && other["button"] == "completed";
            let same = step["seen"]["hash"] == other["seen"]["hash"];
            assert_eq!(
                same, same_by_right,
                "{} {}",
                step["button"], other["button"]
            );
        }
        if width < 640 {
            assert!(step["height"].as_f64() >= Some(44.0), "{step}");
            assert!(step["width"].as_f64() >= Some(44.0), "{step}");
        }
    }
    assert_ne!(result["by_address"]["hash"], steps[0]["seen"]["hash"]);
    assert_ne!(result["by_address"]["hash"], result["turned"]["hash"]);
    assert!(result["still_covered"].as_f64() > Some(0.1));
    let plots = result["plots"].as_array().expect("the probe lists them");
    assert!(
        plots.iter().all(|paths| paths.as_u64() > Some(5)),
        "{plots:?}"
    );
    assert!(
        result["overflow"].as_f64() <= Some(0.0),
        "{}",
        result["overflow"]
    );
}
