//! `relievo fit`

use std::fmt::Write;

use crate::base::{self, BaseChoice, BaseSurface, FitParams, FitReport};
use anyhow::Context;
use clap::Args;
use serde_json::{Map, Value, json};

use super::outcome::Reply;
use super::reading::{Input, Preparation};
use super::{Common, arguments};

#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    pub(super) input: Input,
    #[command(flatten)]
    prepare: Preparation,
    /// Base surface: auto, plane, sphere, cylinder or cone
    #[arg(long, value_name = "KIND", default_value = "auto", value_parser = arguments::base)]
    base: BaseChoice,
}

pub(super) fn run(arguments: &Arguments, common: &Common) -> super::Result {
    let mut known = Map::new();
    let surface = arguments
        .prepare
        .surface(&arguments.input, common, &mut known)?;
    let mesh = surface.scan.mesh();
    let params = FitParams {
        base: arguments.base,
        seed: common.seed,
        ..FitParams::default()
    };
    let fit = base::fit(&mesh, &params).with_context(|| arguments.input.name())?;
    let mut reply = Reply {
        text: table(&fit),
        json: known,
        ..Reply::default()
    };
    reply.json.insert("fits".into(), json!(fit.fits()));
    if let Value::Object(members) = json!(fit) {
        reply.json.extend(members);
    }
    Ok(reply)
}

fn table(fit: &FitReport) -> String {
    let mut text = format!("{}\n", in_words(&fit.base));
    let _ = writeln!(
        text,
        "relief {:.6} (RMS of inliers), {:.6} (RMS of all), largest height {:.6}, {:.1} % inliers, {} iterations ({:?}){}",
        fit.inlier_rms,
        fit.rms,
        fit.max_residual,
        100.0 * fit.inlier_share,
        fit.iterations,
        fit.reason,
        if fit.fits() {
            ""
        } else {
            "\nit does not fit: this is no relief but form"
        },
    );
    let _ = writeln!(
        text,
        "\n{:<9} {:>14} {:>14} {:>14}",
        "kind", "RMS", "robust", "criterion"
    );
    for candidate in &fit.ranking {
        let _ = writeln!(
            text,
            "{:<9} {:>14.6} {:>14.6} {:>14.2}{}",
            candidate.kind(),
            candidate.rms,
            candidate.scale,
            candidate.criterion,
            candidate
                .degenerate
                .map_or(String::new(), |why| format!("  excluded: {why:?}")),
        );
    }
    text
}

fn in_words(base: &BaseSurface) -> String {
    let point = |p: &nalgebra::Point3<f64>| format!("({:.6}, {:.6}, {:.6})", p.x, p.y, p.z);
    let axis = |v: &nalgebra::Vector3<f64>| format!("({:.6}, {:.6}, {:.6})", v.x, v.y, v.z);
    match base {
        BaseSurface::Plane(b) => {
            format!(
                "plane through {} with normal {}",
                point(&b.point),
                axis(&b.normal)
            )
        }
        BaseSurface::Sphere(b) => {
            format!(
                "sphere around {} of radius {:.6}",
                point(&b.center),
                b.radius
            )
        }
        BaseSurface::Cylinder(b) => format!(
            "cylinder around the axis through {} along {} of radius {:.6}",
            point(&b.point),
            axis(&b.axis),
            b.radius
        ),
        BaseSurface::Cone(b) => format!(
            "cone with apex {} along {} and a half angle of {:.4} degrees",
            point(&b.apex),
            axis(&b.axis),
            b.half_angle.to_degrees()
        ),
    }
}
