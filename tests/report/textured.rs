//! The report of a textured mesh.

use serde_json::Value;

use crate::common::place::Place;
use crate::common::samples::{checks, image, put_image, square, torus, waves};
use crate::common::{say_skipped, synthetic, to_scan};
use crate::{assert_stands_alone, browser, html, markup};
use relievo::scan::Image;
use relievo::synth::{Kind, Part};

const TEXTURE: &str =
    "texture mesh.ply -e sample.png --vertices 600 -o out.ply --report report.html";

fn reported(sample: &Image, options: &str) -> Place {
    let place = Place::with("mesh.ply", &to_scan(&torus()));
    put_image(&place, "sample.png", sample);
    place.done(&format!("{TEXTURE} {options}"));
    place
}

#[test]
fn the_page_says_how_the_texture_came_about() {
    let place = reported(&waves(), "--seed 3 --levels 5 --symmetry 2 --displace 0.1");
    let page = markup(&html(&place));
    for words in [
        "<title>mesh.ply, textured",
        "The colours and relief of sample.png are all over mesh.ply, on 600 vertices",
        "mesh.ply, as it was",
        "Histogram of red (correlation",
        "Histogram of blue (correlation",
        "Levels, the finest first",
        "7 by 7",
        "<th scope=\"row\">vertices</th><td class=\"number\">600</td><td>given</td>",
        "<th scope=\"row\">levels</th><td class=\"number\">2</td><td>5 are given, and no more fit",
        "<th scope=\"row\">orientation</th><td>relax</td>",
        "<th scope=\"row\">symmetry</th><td>2</td>",
        "<th scope=\"row\">method</th><td>coherent</td>",
        "<th scope=\"row\">displace</th><td>0.1000</td>",
        "<th scope=\"row\">seed</th><td>3</td>",
        "moved along their normals by 0.1000",
        "Written by relievo",
    ] {
        assert!(page.contains(words), "{words}");
    }
    assert_stands_alone(&page, &place);
    assert_eq!(page.matches("<figure class=\"view\"").count(), 2);
}

#[test]
fn the_figures_of_the_page_are_those_of_the_json() {
    let place = reported(&checks(), "--orientation x --json told.json");
    let page = markup(&html(&place));
    let json: Value = place.json("told.json");
    for level in json["levels"].as_array().expect("there are levels") {
        for count in ["vertices", "sites"] {
            let cell = format!("<td class=\"number\">{}</td>", level[count]);
            assert!(page.contains(&cell), "{cell}");
        }
        let share = level["coherent_edges"].as_f64().expect("a share");
        let cell = format!("<td class=\"number\">{:.2}</td>", 100.0 * share);
        assert!(page.contains(&cell), "{cell}");
    }
    let found = json["orientation"]["singularities"]
        .as_array()
        .expect("a list");
    match found.len() {
        0 => assert!(page.contains("They turn around no point.")),
        points => assert!(page.contains(&format!("They turn around {points} point"))),
    }
    let rounds = format!("relaxed in {} round", json["orientation"]["rounds"]);
    assert!(page.contains(&rounds), "{rounds}");
}

#[test]
fn the_same_texture_gives_the_same_page_with_any_number_of_threads() {
    let place = reported(&waves(), "--threads 2");
    let first = html(&place);
    place.done(&format!("{TEXTURE} --threads 1"));
    assert!(first == html(&place));
}

#[test]
fn pages_of_relief_and_grey_and_the_papers_method_say_so() {
    let place = Place::with("mesh.ply", &to_scan(&square()));
    place.put("sample.ply", &synthetic(Kind::Waves, Part::default()));
    let texture = "texture mesh.ply --vertices 600 -o out.ply --report report.html";
    place.done(&format!("{texture} -e sample.ply --orientation random"));
    let page = markup(&html(&place));
    assert!(page.contains("The relief of sample.ply is all over mesh.ply"));
    assert!(page.contains("points anywhere, at each vertex anew"));
    assert!(!page.contains("Histogram of"), "there are no colors");

    let grey = image(24, 24, |x, y| [((x * 5 + y * 3) % 24) as f32 / 24.0; 3]);
    put_image(&place, "grey.png", &grey);
    place.done(&format!("{texture} -e grey.png --method wei-levoy"));
    let page = markup(&html(&place));
    assert_eq!(
        page.matches("Histogram of").count(),
        2,
        "a caption and its label"
    );
    for words in [
        "Histogram of grey",
        "as in the paper",
        "<th scope=\"row\">search</th><td>tree</td>",
        "<th scope=\"row\">displace</th><td>no</td>",
    ] {
        assert!(page.contains(words), "{words}");
    }
}

#[test]
fn a_page_goes_where_nothing_else_is() {
    let place = Place::with("mesh.ply", &to_scan(&square()));
    put_image(&place, "sample.png", &checks());
    let line = "texture mesh.ply -e sample.png --vertices 600 -o out.ply --report";
    place.refused(1, &format!("{line} no/report.html"), &["no", "folder"]);
    place.refused(2, &format!("{line} mesh.ply"), &["mesh.ply"]);
    place.refused(2, &format!("{line} sample.png"), &["sample.png"]);
    place.refused(2, &format!("{line} ./out.ply"), &["-o", "another name"]);
    place.refused(2, &format!("{line} -"), &["report.html"]);
}

#[test]
fn readers_see_the_texture_and_where_it_is_from() {
    let Some(browser) = browser::find() else {
        say_skipped("no Chromium on this machine; install Debian's package chromium");
        return;
    };
    let place = reported(&waves(), "--displace 0.1");
    let result = browser::probed(&browser, &place.path("report.html"), 1280);
    assert_eq!(result["failed"], Value::Null, "{}", result["failed"]);
    assert_eq!(result["wrong"], Value::Array(Vec::new()));
    let start = &result["at_start"];
    assert!(start["colors"].as_u64() > Some(100), "{start}");
    let steps = result["steps"].as_array().expect("the probe lists them");
    let buttons: Vec<&str> = steps.iter().filter_map(|s| s["button"].as_str()).collect();
    let channels = ["shape", "color", "height", "cost", "source", "direction"];
    assert!(buttons.starts_with(&channels), "{buttons:?}");
    for (index, step) in steps.iter().take(channels.len()).enumerate() {
        assert_eq!(step["pressed"], "true", "{step}");
        for other in &steps[..index] {
            assert_ne!(step["seen"]["hash"], other["seen"]["hash"], "{step}");
        }
    }
    let plots = result["plots"].as_array().expect("the probe lists them");
    assert_eq!(plots.len(), 3);
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
