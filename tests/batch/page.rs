//! The page of a batch.

use super::{QUICK, mixed};
use crate::common::place::Place;

fn html(place: &Place, name: &str) -> String {
    String::from_utf8(place.bytes(name)).expect("pages are UTF-8")
}

#[test]
fn the_page_has_failures_first_then_all_scans_with_pictures_also_when_resumed() {
    let place = mixed();
    let line = format!("batch scans/**/* --out out {QUICK} --report out/index.html");
    let run = place.run(&line);
    assert_eq!(run.code, 1, "{}", run.stderr);
    let first = html(&place, "out/index.html");
    let at = |text: &str| first.find(text).unwrap_or_else(|| panic!("no {text:?}"));
    assert!(at("What failed") < at("All scans") && at("All scans") < at("Pictures"));
    assert!(at("scans/broken.ply") < at("All scans"));
    assert!(
        first.contains("href=\"deep/wall.obj\""),
        "links lead from the page"
    );
    // Before and after; OBJ does not tell what was completed.
    assert_eq!(first.matches("data:image/png;base64,").count(), 5);
    assert!(!first.contains("<script"));
    for address in ["http:", "https:", "src=\"/"] {
        assert!(!first.contains(address), "{address}");
    }
    let root = place.0.path().display().to_string();
    assert!(
        !first.contains(&root),
        "the page has no names of folders beyond the given ones"
    );
    // Elsewhere, from results that are there already.
    std::fs::create_dir(place.path("pages")).expect("folders can be made");
    let resumed = format!("batch scans/**/* --out out {QUICK} --resume --report pages/index.html");
    assert_eq!(place.run(&resumed).code, 1);
    let second = html(&place, "pages/index.html");
    assert!(second.contains("href=\"../out/deep/wall.obj\""));
    assert_eq!(second.matches("data:image/png;base64,").count(), 5);
    assert!(second.contains("there already"));
}

#[test]
fn pictures_are_made_for_a_page_that_is_asked_for_later() {
    let place = super::good(1);
    place.done(&format!("batch scans/*.ply --out out {QUICK}"));
    assert!(!place.path("out/.relievo/0.ply.after.png").exists());
    place.done(&format!(
        "batch scans/*.ply --out out {QUICK} --resume --report index.html"
    ));
    assert_eq!(
        html(&place, "index.html")
            .matches("data:image/png;base64,")
            .count(),
        2
    );
}
