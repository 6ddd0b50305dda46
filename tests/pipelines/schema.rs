//! What the schema tells, and that it tells the truth.

use serde_json::{Value, json};

use super::{pipeline, place};
use crate::common::place::Place;

#[test]
fn the_schema_tells_every_option_with_its_type_and_default() {
    let run = Place::new().done("schema");
    let schema: Value = serde_json::from_slice(&run.stdout).unwrap();
    let kinds: Vec<&String> = schema["$defs"].as_object().unwrap().keys().collect();
    assert_eq!(
        kinds,
        [
            "compare", "complete", "fit", "holes", "info", "read", "render", "stats", "texture",
            "transfer", "write"
        ]
    );
    let complete = &schema["$defs"]["complete"];
    assert_eq!(complete["required"], json!(["type"]));
    assert_eq!(complete["properties"]["sites"]["default"], 8192);
    // Like all that may be left out, it may be null.
    let type_of = |name: &str| complete["properties"][name]["type"].clone();
    assert_eq!(type_of("sites"), json!(["integer", "null"]));
    assert_eq!(
        complete["properties"]["method"]["enum"],
        json!(["coherent", "exhaustive", "paper", null])
    );
    assert_eq!(complete["properties"]["memory"]["default"], "2GiB");
    assert_eq!(type_of("blend"), json!(["boolean", "null"]));
    assert_eq!(
        schema["$defs"]["render"]["required"],
        json!(["type", "output"])
    );
    assert_eq!(
        schema["$defs"]["texture"]["required"],
        json!(["type", "exemplar"])
    );
    assert_eq!(schema["$defs"]["transfer"]["required"], json!(["type"]));
    assert_eq!(schema["$defs"]["read"]["required"], json!(["type", "path"]));
    let exemplar = &schema["$defs"]["texture"]["properties"]["exemplar"];
    assert_eq!(exemplar["type"], "string", "it must be given");
    for (kind, step) in schema["$defs"].as_object().unwrap() {
        for (name, option) in step["properties"].as_object().unwrap() {
            let told = option["description"]
                .as_str()
                .is_some_and(|text| text.len() > 5);
            assert!(told || name == "type", "{kind}.{name} has no description");
            for foreign in ["json", "quiet", "scan", "step", "help"] {
                assert_ne!(name, foreign, "{kind}");
            }
        }
    }
}

#[test]
fn what_the_schema_allows_is_accepted() {
    let place = place();
    let said = |value: Value| {
        let step =
            json!({ "type": "complete", "window": value, "rotations": null, "method": null });
        let text = json!({ "seed": 5.0, "pipeline": ["in.ply", step, "out.ply"] }).to_string();
        place.text("p.json", &text);
        place.done("run p.json");
        place.bytes("out.ply")
    };
    // JSON does not tell a whole number from the same with a point.
    assert!(said(json!(2.0)) == said(json!(2)));
    let text = json!({ "seed": null, "pipeline": ["in.ply", { "type": "fit" }] }).to_string();
    place.text("p.json", &text);
    place.done("run p.json --validate");
    for wrong in [json!(2.5), json!(-2.0), json!(1e300)] {
        let steps = json!(["in.ply", { "type": "complete", "window": wrong }]);
        place.text("p.json", &pipeline(&steps));
        place.refused(2, "run p.json", &["`window`", "cannot be"]);
    }
}

#[test]
fn numbers_are_read_as_they_were_written() {
    let place = place();
    // The nearest neighbor of this one is what a quicker way to read it gives.
    let length = "0.9385958677423489";
    let text =
        format!(r#"["in.ply", {{"type": "complete", "form_wavelength": {length}}}, "out.ply"]"#);
    place.text("p.json", &text);
    place.done("run p.json --validate --json said.json");
    let said = String::from_utf8(place.bytes("said.json")).unwrap();
    assert!(
        said.contains(&format!("\"form_wavelength\": {length},")),
        "{said}"
    );
    place.done("run said.json --validate --json again.json");
    assert!(place.json("again.json")["pipeline"] == place.json("said.json")["pipeline"]);
}
