//! Pictures as the command line makes them.
#![cfg(feature = "image")]

mod common;

use common::place::Place;
use common::{holed, real};
use relievo::synth::Kind;

/// The picture's pixels, and its size.
fn decoded(bytes: &[u8]) -> image::RgbaImage {
    image::load_from_memory(bytes)
        .expect("it is a PNG")
        .to_rgba8()
}

/// How many pixels are not white.
fn inked(picture: &image::RgbaImage) -> usize {
    picture.pixels().filter(|p| p.0 != [255; 4]).count()
}

#[test]
fn a_scan_becomes_a_picture_and_the_json_says_what_it_shows() {
    let place = Place::with("in.ply", &holed(Kind::GolfBall));
    let run = place.done("render in.ply -o out.png --size 160x120 --json report.json");
    assert!(
        run.stdout.is_empty() && run.stderr.is_empty(),
        "{}",
        run.stderr
    );
    assert_eq!(place.files(), ["in.ply", "out.png", "report.json"]);
    let picture = decoded(&place.bytes("out.png"));
    assert_eq!(picture.dimensions(), (160, 120));
    let share = inked(&picture) as f64 / (160.0 * 120.0);
    // A disc that touches the upper and lower margin.
    assert!((0.45..0.6).contains(&share), "{share}");
    let report = place.json("report.json");
    assert_eq!(report["status"], "done");
    assert_eq!(report["command"], "render");
    assert_eq!(report["parameters"]["width"], 160);
    assert!(
        report["triangles"]
            .as_u64()
            .is_some_and(|count| count > 1000)
    );
}

#[test]
fn pictures_do_not_depend_on_threads_and_go_to_standard_output() {
    let place = Place::with("in.ply", &holed(Kind::Bark));
    let line = "render in.ply -o - --size 200x150 --channel height";
    let one = place.done(&format!("{line} --threads 1")).stdout;
    let two = place.done(&format!("{line} --threads 2")).stdout;
    assert_eq!(one, two);
    assert_eq!(decoded(&one).dimensions(), (200, 150));
    assert_eq!(place.files(), ["in.ply"]);
    let scan = place.bytes("in.ply");
    let from_stdin = place.run_with("render - -o - --size 200x150 --channel height", &scan);
    assert_eq!(from_stdin.stdout, one);
}

#[test]
fn before_and_after_come_from_one_file_with_one_camera() {
    let place = Place::with("in.ply", &holed(Kind::Bricks));
    place.done("complete in.ply -o out.ply --window 2 --rotations 1 -q");
    let picture = |options: &str| {
        place.done(&format!(
            "render out.ply -o out.png --size 240x180 {options}"
        ));
        decoded(&place.bytes("out.png"))
    };
    let after = picture("");
    let before = picture("--before");
    assert!(inked(&before) < inked(&after));
    let same = before.pixels().zip(after.pixels()).filter(|(a, b)| a == b);
    assert!(same.count() > 240 * 180 * 8 / 10);
    let marked = picture("--channel completed --no-legend");
    let orange = marked
        .pixels()
        .filter(|p| p.0[0] > p.0[2].saturating_add(90));
    assert!(orange.count() > 200);
    let close = picture("--channel completed --no-legend --look-at completed");
    let orange = close
        .pixels()
        .filter(|p| p.0[0] > p.0[2].saturating_add(90));
    assert!(orange.count() > 240 * 180 / 10);
    for channel in ["height", "source", "x", "shape", "color"] {
        assert!(inked(&picture(&format!("--channel {channel}"))) > 10_000);
    }
}

#[test]
fn points_are_joined_and_backgrounds_are_as_asked() {
    let place = Place::new();
    let mut points = String::new();
    for i in 0..30 {
        for j in 0..30 {
            let height = 0.2 * (f64::from(i) * 0.8).sin() * (f64::from(j) * 0.7).cos();
            points += &format!("{i} {j} {height}\n");
        }
    }
    place.text("in.xyz", &points);
    let run = place.done("render in.xyz -o out.png --size 100x100 --background transparent");
    assert!(run.stderr.contains("900 points"), "{}", run.stderr);
    let picture = decoded(&place.bytes("out.png"));
    assert_eq!(picture.get_pixel(0, 0).0[3], 0);
    assert_eq!(picture.get_pixel(50, 50).0[3], 255);
    place.done("render in.xyz -o out.png --size 100x100 --background #102030 -q");
    let picture = decoded(&place.bytes("out.png"));
    assert_eq!(picture.get_pixel(0, 0).0, [16, 32, 48, 255]);
}

#[test]
fn mistakes_are_told_in_a_sentence_and_leave_nothing_behind() {
    let place = Place::with("in.ply", &holed(Kind::Waves));
    place.text("point.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 3\n");
    place.refused(2, "render in.ply -o out.jpg", &["out.jpg", ".png"]);
    place.refused(2, "render in.ply -o out", &["out", ".png"]);
    place.refused(2, "render in.ply -o out.png --size 0x0", &["0 by 0"]);
    let huge = "render in.ply -o out.png --size 100000x100000";
    place.refused(2, huge, &["100000 by 100000", "16384"]);
    place.refused(2, "render in.ply -o out.png --zoom 0", &["zoom of 0"]);
    let heat = "render in.ply -o out.png --channel heat";
    place.refused(2, heat, &["in.ply", "\"heat\"", "\"x\"", "\"z\""]);
    let nothing = "render in.ply -o out.png --before";
    place.refused(2, nothing, &["in.ply", "\"completed\""]);
    place.refused(1, "render none.ply -o out.png", &["none.ply"]);
    place.refused(1, "render in.ply -o nowhere/out.png", &["nowhere"]);
    place.refused(1, "render point.ply -o out.png", &["point.ply"]);
    for wrong in [
        "--size 5",
        "--view up",
        "--range 2,1",
        "--background red",
        "--up w",
    ] {
        let run = place.run(&format!("render in.ply -o out.png {wrong}"));
        assert_eq!(run.code, 2, "{wrong}");
        assert!(run.stderr.contains("expected"), "{}", run.stderr);
    }
}

#[test]
fn a_depth_image_is_not_overwritten_by_its_picture() {
    let place = Place::new();
    let depth = image::ImageBuffer::from_fn(20, 20, |x, y| {
        image::Luma([u16::try_from(1000 + x + y).expect("it is small")])
    });
    depth.save(place.path("in.png")).expect("it can be written");
    let line = "render in.png -o in.png --intrinsics 20,20,10,10 --size 64x64";
    place.refused(1, line, &["in.png", "--overwrite"]);
    place.done(&format!("{line} --overwrite -q"));
    assert_eq!(decoded(&place.bytes("in.png")).dimensions(), (64, 64));
}

#[test]
fn small_pictures_go_without_color_bar_and_say_so() {
    let place = Place::with("in.ply", &holed(Kind::GolfBall));
    let run = place.done("render in.ply -o out.png --size 64x48 --channel height");
    assert!(
        run.stderr.contains("no room for a color bar"),
        "{}",
        run.stderr
    );
}

#[test]
fn real_scans_are_seen_from_where_they_were_scanned() {
    for (file, size) in [
        ("scans/limestone_V21_grid.ply", 0.5),
        ("transfer/zebra_rgb.ply", 0.1),
    ] {
        let Some(scan) = real(file) else {
            continue;
        };
        let place = Place::with("in.ply", &scan);
        place.done("render in.ply -o out.png --size 320x240 -q");
        let share = inked(&decoded(&place.bytes("out.png"))) as f64 / (320.0 * 240.0);
        assert!(share > size, "{file} {share}");
    }
}
