//! `relievo render`

use std::io::Write;
use std::path::{Path, PathBuf};

use crate::base::FitParams;
use crate::picture::{
    self, Background, ChannelChoice, LookAt, PictureError, Projection, RenderParams, Up, View,
};
use crate::scan::{OutputFile, Scan};
use anyhow::Context;
use clap::{Args, ValueEnum};
use serde_json::{Map, Value, json};

use super::Common;
use super::held::{Kept, Slot, is_kept};
use super::outcome::{Failure, Reply};
use super::reading::{Input, Preparation};

#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    pub(super) input: Input,
    #[command(flatten)]
    prepare: Preparation,
    /// The picture: .png; - for standard output
    #[arg(short, long, value_name = "OUT")]
    pub(super) output: PathBuf,
    /// What the colours show: color, shape, height (over the base surface), completed, cost, source (where
    /// completed vertices were copied from), or the name of a vertex property [default: color if the scan has
    /// any, else shape]
    #[arg(long, value_name = "CHANNEL", value_parser = channel)]
    channel: Option<ChannelChoice>,
    /// Values at the two ends of the color bar [default: the 2 % and 98 % quantiles, around 0 for heights]
    #[arg(long, value_name = "MIN,MAX", value_parser = range, allow_hyphen_values = true)]
    range: Option<[f64; 2]>,
    /// From where: front, back, left, right, top, bottom, iso, or angles in degrees, from the front to the
    /// object's right and upwards; auto: from the side that the faces of a surface look to, others from where
    /// the completed part is seen, or iso
    #[arg(
        long,
        value_name = "auto|…|AZIMUTH,ELEVATION",
        default_value = "auto",
        value_parser = view,
        allow_hyphen_values = true
    )]
    view: View,
    /// Axis that points up [default: z if the scan is longest along it, else y]
    #[arg(long, value_name = "auto|x|y|z", default_value = "auto", value_parser = up)]
    up: Up,
    /// How depth is drawn: what is nearer is larger, or one length everywhere
    #[arg(long, value_enum, default_value_t = ProjectionName::Perspective)]
    projection: ProjectionName,
    /// Enlarge the middle of the picture
    #[arg(
        long,
        value_name = "FACTOR",
        default_value_t = 1.0,
        allow_negative_numbers = true
    )]
    zoom: f64,
    /// What fills the picture: all, or what was completed and what is around it
    #[arg(long, value_enum, default_value_t = LookAtName::All)]
    look_at: LookAtName,
    /// Leave out what was completed; camera and colours stay as they are with it
    #[arg(long)]
    before: bool,
    /// Draw the edges of the triangles
    #[arg(long)]
    wireframe: bool,
    /// Draw no color bar
    #[arg(long)]
    no_legend: bool,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1600x1200", value_parser = size)]
    size: [u32; 2],
    /// white, black, transparent or #RRGGBB
    #[arg(long, value_name = "COLOR", default_value = "white", value_parser = background)]
    background: Background,
    /// Allow OUT to be the same file as the input
    #[arg(long)]
    pub(super) overwrite: bool,
    #[arg(skip)]
    pub(super) slot: Option<Slot>,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum ProjectionName {
    Perspective,
    Orthographic,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum LookAtName {
    All,
    Completed,
}

impl Arguments {
    pub(super) fn params(&self, seed: u32) -> RenderParams {
        let [width, height] = self.size;
        RenderParams {
            width,
            height,
            channel: self.channel.clone().unwrap_or_default(),
            range: self.range,
            view: self.view,
            up: self.up,
            projection: match self.projection {
                ProjectionName::Perspective => Projection::Perspective,
                ProjectionName::Orthographic => Projection::Orthographic,
            },
            zoom: self.zoom,
            look_at: match self.look_at {
                LookAtName::All => LookAt::All,
                LookAtName::Completed => LookAt::Completed,
            },
            before: self.before,
            wireframe: self.wireframe,
            legend: !self.no_legend,
            background: self.background,
            fit: FitParams {
                seed,
                ..FitParams::default()
            },
        }
    }
}

pub(super) fn run(arguments: &Arguments, common: &Common) -> super::Result {
    let params = arguments.params(common.seed);
    let mut known = Map::new();
    known.insert("output".into(), json!(arguments.output.to_string_lossy()));
    known.insert("parameters".into(), json!(params));
    work(arguments, common, &params, &mut known).map_err(|failure| Failure {
        json: known,
        ..failure
    })
}

fn work(
    arguments: &Arguments,
    common: &Common,
    params: &RenderParams,
    known: &mut Map<String, Value>,
) -> super::Result {
    picture::check_built().map_err(|error| Failure {
        usage: true,
        ..error.into()
    })?;
    params.check().map_err(|error| failed(error, None))?;
    let output = if is_kept(&arguments.output) {
        None
    } else {
        check_extension(&arguments.output)?;
        let protected = (!arguments.overwrite).then_some(arguments.input.path.as_path());
        Some(OutputFile::create(&arguments.output, protected)?)
    };
    let surface = arguments.prepare.surface(&arguments.input, common, known)?;
    draw(&surface.scan, params, arguments, known, output)?;
    Ok(Reply {
        json: std::mem::take(known),
        ..Reply::default()
    })
}

fn draw(
    scan: &Scan,
    params: &RenderParams,
    arguments: &Arguments,
    known: &mut Map<String, Value>,
    output: Option<OutputFile>,
) -> Result<(), Failure> {
    let name = arguments.input.name();
    let picture =
        picture::render(scan, params).map_err(|error| failed(error, Some(name.clone())))?;
    if let Value::Object(members) = json!(picture.report) {
        known.extend(members);
    }
    if picture.report.legend_left_out {
        log::warn!(
            "{}: a picture of {} by {} pixels has no room for a color bar; make it larger",
            output.as_ref().map_or(name.as_str(), OutputFile::name),
            params.width,
            params.height
        );
    }
    if let Some(mut output) = output {
        let mut bytes = Vec::new();
        picture::write_png(&picture.raster, &mut bytes)
            .with_context(|| output.name().to_owned())?;
        output
            .write_all(&bytes)
            .map_err(|error| output.error(error))?;
        output.commit()?;
    }
    if let Some(slot) = &arguments.slot {
        slot.put(Kept::Picture(Box::new(picture.raster)));
    }
    Ok(())
}

/// A mistake on the command line, or a scan that cannot be drawn as it asks.
fn failed(error: PictureError, file: Option<String>) -> Failure {
    let usage = matches!(
        error,
        PictureError::Size { .. }
            | PictureError::Zoom(_)
            | PictureError::Range(_)
            | PictureError::Angles
            | PictureError::NoChannel { .. }
            | PictureError::NothingCompleted
    );
    let error = anyhow::Error::new(error);
    let error = match file {
        Some(file) => error.context(file),
        None => error,
    };
    Failure {
        usage,
        ..error.into()
    }
}

fn check_extension(path: &Path) -> Result<(), Failure> {
    let extension = path.extension().map(std::ffi::OsStr::to_ascii_lowercase);
    if path == Path::new("-") || extension.is_some_and(|extension| extension == "png") {
        return Ok(());
    }
    Err(Failure::usage(format!(
        "{}: pictures are written as .png: give the output this extension",
        path.display()
    )))
}

fn channel(text: &str) -> Result<ChannelChoice, String> {
    Ok(match text {
        "" => return Err("expected color, shape, height, completed, cost, source, or the name of a vertex property".into()),
        "color" => ChannelChoice::Color,
        "shape" => ChannelChoice::Shape,
        "height" => ChannelChoice::Height,
        "completed" => ChannelChoice::Completed,
        "cost" => ChannelChoice::Cost,
        "source" => ChannelChoice::Source,
        name => ChannelChoice::Property(name.to_owned()),
    })
}

/// Two numbers with a comma between.
fn pair(text: &str) -> Option<[f64; 2]> {
    let (first, second) = text.split_once(',')?;
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    Some([number(first)?, number(second)?])
}

fn range(text: &str) -> Result<[f64; 2], String> {
    pair(text)
        .filter(|[low, high]| low < high)
        .ok_or_else(|| "expected two numbers with a comma between, the smaller one first".into())
}

fn view(text: &str) -> Result<View, String> {
    Ok(match text {
        "auto" => View::Auto,
        "front" => View::Front,
        "back" => View::Back,
        "left" => View::Left,
        "right" => View::Right,
        "top" => View::Top,
        "bottom" => View::Bottom,
        "iso" => View::Iso,
        angles => match pair(angles) {
            Some([azimuth, elevation]) => View::Angles {
                azimuth: azimuth.to_radians(),
                elevation: elevation.to_radians(),
            },
            None => {
                return Err(
                    "expected auto, front, back, left, right, top, bottom, iso, or azimuth and elevation in degrees with a comma between, as in 30,20"
                        .into(),
                );
            }
        },
    })
}

fn up(text: &str) -> Result<Up, String> {
    Ok(match text {
        "auto" => Up::Auto,
        "x" => Up::X,
        "y" => Up::Y,
        "z" => Up::Z,
        _ => return Err("expected auto, x, y or z".into()),
    })
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let parts = text.split_once(['x', 'X']);
    let parts = parts.and_then(|(w, h)| Some([w.trim().parse().ok()?, h.trim().parse().ok()?]));
    parts.ok_or_else(|| "expected width and height in pixels, as in 1600x1200".into())
}

fn background(text: &str) -> Result<Background, String> {
    Ok(match text {
        "white" => Background::Color([255; 3]),
        "black" => Background::Color([0; 3]),
        "transparent" => Background::Transparent,
        hexadecimal => {
            let digits = hexadecimal.strip_prefix('#').unwrap_or_default();
            let is_color = digits.len() == 6 && digits.bytes().all(|b| b.is_ascii_hexdigit());
            let value = is_color.then(|| u32::from_str_radix(digits, 16).ok());
            match value.flatten() {
                Some(value) => {
                    let [_, r, g, b] = value.to_be_bytes();
                    Background::Color([r, g, b])
                }
                None => {
                    return Err(
                        "expected white, black, transparent, or six hexadecimal digits, as in #ff8000"
                            .into(),
                    );
                }
            }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_read_and_mistakes_refused() {
        assert_eq!(size("800x600"), Ok([800, 600]));
        assert_eq!(background("#0a80FF"), Ok(Background::Color([10, 128, 255])));
        assert_eq!(range("-1,2.5"), Ok([-1.0, 2.5]));
        let turned = View::Angles {
            azimuth: -std::f64::consts::FRAC_PI_2,
            elevation: 0.0,
        };
        assert_eq!(view("-90,0"), Ok(turned));
        for text in [
            "",
            "800",
            "800x",
            "x600",
            "-1x5",
            "8e2x600",
            "99999999999x1",
        ] {
            assert!(size(text).is_err(), "{text}");
        }
        for text in [
            "",
            "#12345",
            "#1234567",
            "#00000g",
            "red",
            "123456",
            "#\u{e9}\u{e9}\u{e9}",
        ] {
            assert!(background(text).is_err(), "{text}");
        }
        for text in ["", "1", "2,1", "1,1", "nan,1", "0,inf", "a,b"] {
            assert!(range(text).is_err(), "{text}");
        }
        for text in ["", "up", "30", "30,", "nan,0"] {
            assert!(view(text).is_err(), "{text}");
        }
    }
}
