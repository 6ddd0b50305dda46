//! The report of a transfer.

use nalgebra::Point3;
use serde_json::Value;

use crate::common::place::Place;
use crate::common::samples::{sphere, torus};
use crate::common::{say_skipped, to_scan};
use crate::{assert_stands_alone, browser, html, markup};

const TRANSFER: &str =
    "transfer --source source.ply --target target.ply -o out.ply --report report.html";

fn reported(options: &str) -> Place {
    let mut source = to_scan(&torus());
    let hue = |p: &Point3<f64>| [0.5 + 0.1 * p.x, 0.5 + 0.1 * p.y, 0.5 + 0.3 * p.z];
    let colors: Vec<[f64; 3]> = torus().positions.iter().map(hue).collect();
    source.vertices.set_colors(&colors);
    let place = Place::with("source.ply", &source);
    place.put("target.ply", &to_scan(&sphere()));
    place.done(&format!("{TRANSFER} {options}"));
    place
}

#[test]
fn the_page_says_how_the_colors_came_there() {
    let place = reported("--seed 3 --up z --source-up none --scale 0.5 --audit 9 --json told.json");
    let page = markup(&html(&place));
    let json: Value = place.json("told.json");
    let rows = place.scan("out.ply").vertices.rows;
    for words in [
        "<title>target.ply, with what was on source.ply",
        "The colours of source.ply are on target.ply, at",
        &format!("at {rows} vertices"),
        "target.ply, what came out",
        "source.ply, the source",
        "Histogram of red (correlation",
        "Histogram of blue (correlation",
        "Levels, the finest first",
        "9 matches cost",
        "<th scope=\"row\">up</th><td>0, 0, 1.000</td>",
        "<th scope=\"row\">source-up</th><td>none</td>",
        "<th scope=\"row\">scale</th><td>0.5000</td>",
        "<th scope=\"row\">shape</th><td>heat-kernel</td>",
        "<th scope=\"row\">displace</th><td>no</td>",
        "<th scope=\"row\">seed</th><td>3</td>",
        "Written by relievo",
    ] {
        assert!(page.contains(words), "{words}");
    }
    for level in json["levels"].as_array().expect("there are levels") {
        for count in ["vertices", "source_vertices"] {
            let cell = format!("<td class=\"number\">{}</td>", level[count]);
            assert!(page.contains(&cell), "{cell}");
        }
    }
    assert_stands_alone(&page, &place);
    assert_eq!(page.matches("<figure class=\"view\"").count(), 2);
}

#[test]
fn the_same_transfer_gives_the_same_page_with_any_number_of_threads() {
    let place = reported("--channel both --displace 0.5 --threads 2");
    let first = html(&place);
    let page = markup(&first);
    for words in [
        "The colours and relief of source.ply are on target.ply",
        "moved along their normals by 0.5000 of it",
    ] {
        assert!(page.contains(words), "{words}");
    }
    place.done(&format!(
        "{TRANSFER} --channel both --displace 0.5 --threads 1"
    ));
    assert!(first == html(&place));
}

#[test]
fn a_page_goes_where_nothing_else_is() {
    let place = reported("");
    let line = "transfer --source source.ply --target target.ply -o out.ply --report";
    place.refused(2, &format!("{line} source.ply"), &["source.ply"]);
    place.refused(2, &format!("{line} target.ply"), &["target.ply"]);
    place.refused(2, &format!("{line} ./out.ply"), &["-o", "another name"]);
    place.refused(1, &format!("{line} no/report.html"), &["no", "folder"]);
}

#[test]
fn readers_see_what_came_out_and_where_it_is_from() {
    let Some(browser) = browser::find() else {
        say_skipped("no Chromium on this machine; install Debian's package chromium");
        return;
    };
    let place = reported("--channel both --form-wavelength 2");
    let result = browser::probed(&browser, &place.path("report.html"), 1280);
    assert_eq!(result["failed"], Value::Null, "{}", result["failed"]);
    assert_eq!(result["wrong"], Value::Array(Vec::new()));
    let steps = result["steps"].as_array().expect("the probe lists them");
    let buttons: Vec<&str> = steps.iter().filter_map(|s| s["button"].as_str()).collect();
    let channels = ["shape", "color", "height", "source", "cost", "rotation"];
    assert!(buttons.starts_with(&channels), "{buttons:?}");
    for step in steps.iter().take(channels.len()) {
        assert_eq!(step["pressed"], "true", "{step}");
    }
}
