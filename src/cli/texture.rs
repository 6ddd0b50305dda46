//! `relievo texture`

mod output;

use std::fmt::Write;
use std::path::{Path, PathBuf};

use crate::base::FitParams;
use crate::report::{self, TexturedPage};
use crate::scan;
use crate::texture::{
    self, DIRECTION, Density, Method, Orientation, Sample, Search, TextureError, TextureParams,
    Textured,
};
use clap::{ArgGroup, Args, ValueEnum};
use nalgebra::Vector3;
use serde_json::{Map, Value, json};

use super::held::Writing;
use super::mesh_output::{MeshOutput, output_format};
use super::messages::Bar;
use super::outcome::{Failure, Reply};
use super::reading::{Input, Preparation};
use super::report::PageOption;
use super::{Common, arguments, histograms};

#[derive(Debug, Args)]
#[command(group = ArgGroup::new("density").multiple(false))]
pub(super) struct Arguments {
    #[command(flatten)]
    pub(super) input: Input,
    #[command(flatten)]
    prepare: Preparation,
    /// The sample of texture: an image (PNG, JPEG, TIFF), or a scan whose relief and colours are taken
    #[arg(short, long, value_name = "FILE")]
    pub(super) exemplar: PathBuf,
    /// The textured mesh: .ply, .obj, .off, .stl or .glb; - for PLY on standard output
    #[arg(short, long, value_name = "OUT")]
    pub(super) output: PathBuf,
    /// Number of vertices of the textured mesh; each takes a texel of the sample [default: as many as the mesh has, at
    /// least 24576; for a scan as sample, so many that its texture keeps its size]
    #[arg(long, value_name = "N", group = "density")]
    vertices: Option<usize>,
    /// Length of a texel of the sample on the mesh, in the scan's unit
    #[arg(
        long,
        value_name = "LENGTH",
        group = "density",
        allow_negative_numbers = true
    )]
    texel: Option<f64>,
    /// Where the sample's first axis (an image's rows) points: relax (as parallel as the surface allows), random, x, y,
    /// z, DX,DY,DZ, or a file with points x, y, z and directions tx, ty, tz, such as a textured PLY
    #[arg(
        long,
        value_name = "relax|random|x|y|z|DX,DY,DZ|FILE",
        default_value = "relax",
        value_parser = pointed,
        allow_hyphen_values = true
    )]
    orientation: Pointed,
    /// The texture looks the same after a turn by a whole share of this: 1, 2 for lines, 4 for grids, …
    #[arg(long, value_name = "N", default_value_t = 1)]
    symmetry: u32,
    /// How the texture grows
    #[arg(long, value_enum, default_value_t = MethodName::Coherent)]
    method: MethodName,
    /// How --method wei-levoy finds the nearest neighborhood
    #[arg(long, value_enum, default_value_t = SearchName::Tree)]
    search: SearchName,
    /// Number of resolutions [default: as many as leave the coarsest sample 8 texels wide; wei-levoy: 4]
    #[arg(long, value_name = "N")]
    levels: Option<usize>,
    /// Put the texture on the mesh as it is: colours at its vertices and, if it has texture coordinates and OUT is .ply,
    /// .obj or .glb, a texture image
    #[arg(long)]
    keep_mesh: bool,
    /// Largest side of the texture image, in pixels [default: by the texel, up to 8192]
    #[arg(long, value_name = "PIXELS", requires = "keep_mesh")]
    image_size: Option<u32>,
    /// Move vertices along their normals: SCALE times the sample's relief (1 keeps its proportions) or, of an image, SCALE
    /// (in the scan's unit) from black to white around the mean [default: 1 for a scan with relief, else not]
    #[arg(long, value_name = "SCALE", allow_negative_numbers = true)]
    displace: Option<f64>,
    #[command(flatten)]
    page: PageOption,
    #[command(flatten)]
    pub(super) writing: Writing,
}

/// Where to take directions from.
#[derive(Debug, Clone, PartialEq)]
enum Pointed {
    Known(Orientation),
    File(PathBuf),
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum MethodName {
    /// What continues the sources of a vertex's neighbors, or looks like that: fast, keeps the sample's structure
    Coherent,
    /// Wei & Levoy 2001: every neighborhood of the sample, two passes a level
    WeiLevoy,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum SearchName {
    /// A tree over what tells neighborhoods apart most, and a comparison of the nearest: not always the very nearest
    Tree,
    /// Every neighborhood is compared
    Exhaustive,
}

fn pointed(text: &str) -> Result<Pointed, String> {
    Ok(Pointed::Known(match text {
        "" => return Err("expected relax, random, x, y, z, a direction, or a file".into()),
        "relax" => Orientation::Relax,
        "random" => Orientation::Random,
        "x" => Orientation::Along(Vector3::x()),
        "y" => Orientation::Along(Vector3::y()),
        "z" => Orientation::Along(Vector3::z()),
        _ => match arguments::vector(text) {
            Ok(direction) => Orientation::Along(direction),
            Err(_) => return Ok(Pointed::File(text.into())),
        },
    }))
}

impl Arguments {
    /// All but directions that are in a file.
    pub(super) fn params(&self, seed: u32) -> TextureParams {
        TextureParams {
            density: match (self.vertices, self.texel) {
                (Some(vertices), _) => Density::Vertices(vertices),
                (None, Some(texel)) => Density::Texel(texel),
                (None, None) => Density::Auto,
            },
            orientation: match &self.orientation {
                Pointed::Known(orientation) => orientation.clone(),
                Pointed::File(_) => Orientation::Relax,
            },
            symmetry: self.symmetry,
            method: match self.method {
                MethodName::Coherent => Method::Coherent,
                MethodName::WeiLevoy => Method::WeiLevoy,
            },
            search: match self.search {
                SearchName::Tree => Search::Tree,
                SearchName::Exhaustive => Search::Exhaustive,
            },
            levels: self.levels,
            seed,
        }
    }

    /// What is read beside the mesh.
    pub(super) fn others(&self) -> impl Iterator<Item = &Path> {
        let directions = match &self.orientation {
            Pointed::File(path) => Some(path.as_path()),
            Pointed::Known(_) => None,
        };
        (self.input.reading.files(&self.exemplar)).chain(directions)
    }

    /// The file that an error is about.
    fn blamed(&self, error: &TextureError) -> String {
        match error {
            TextureError::SampleTooSmall { .. }
            | TextureError::SampleSurfaceTooSmall { .. }
            | TextureError::SampleTooLarge { .. } => self.input.with_path(&self.exemplar).name(),
            _ => self.input.name(),
        }
    }
}

pub(super) fn run(arguments: &Arguments, common: &Common) -> super::Result {
    let mut known = Map::new();
    known.insert("output".into(), json!(arguments.output.to_string_lossy()));
    known.insert(
        "exemplar".into(),
        json!(arguments.input.with_path(&arguments.exemplar).name()),
    );
    work(arguments, common, &mut known).map_err(|failure| Failure {
        json: known,
        ..failure
    })
}

fn work(arguments: &Arguments, common: &Common, known: &mut Map<String, Value>) -> super::Result {
    let mut params = arguments.params(common.seed);
    params.check().map_err(|error| failed(error, None))?;
    if let Some(scale) = arguments.displace.filter(|scale| !scale.is_finite()) {
        return Err(failed(TextureError::Displace(scale), None));
    }
    let format = output_format(&arguments.output)?;
    if let Pointed::File(path) = &arguments.orientation {
        params.orientation = directions(path)?;
        params
            .check()
            .map_err(|error| failed(error, Some(path.display().to_string())))?;
    }
    known.insert("parameters".into(), json!(params));
    let inputs: Vec<&Path> = arguments.input.files().chain(arguments.others()).collect();
    let page = arguments
        .page
        .open(&inputs, &[("-o", Some(&arguments.output))], common)?;
    let (surface, mut prepared) =
        (arguments.prepare).told_surface(&arguments.input, common, known)?;
    let to = arguments.destination(format);
    let output = MeshOutput::open(&to, &surface, &arguments.input.name())?;
    let (sample, of_sample) = sample(arguments, common, known)?;
    prepared.extend(of_sample);
    let mesh = surface.scan.mesh();
    let mut bar = Bar::new(common);
    let textured = texture::synthesize(&mesh, &sample, &params, &mut |progress| {
        bar.show(progress);
    });
    drop(bar);
    let mut textured = textured.map_err(|error| {
        let file = arguments.blamed(&error);
        failed(error, Some(file))
    })?;
    let scale = arguments.displace.or(sample.has_heights().then_some(1.0));
    if arguments.displace.is_some() {
        textured.heights_from_colors();
    }
    if let Value::Object(members) = json!(textured.report) {
        known.extend(members);
    }
    let colors = (sample.colors().zip(textured.colors.as_ref()))
        .map(|(of_sample, found)| histograms::beside_source(of_sample, found));
    let correlation = colors.as_ref().map(histograms::correlations);
    known.insert("histogram_correlation".into(), json!(correlation));
    known.insert(
        "displaced".into(),
        json!(scale.filter(|_| textured.heights.is_some())),
    );
    known.insert("mesh_kept".into(), json!(arguments.keep_mesh));
    let bar = Bar::doing(common, "writing");
    arguments.write((&to, output), &surface, &textured, scale, known)?;
    drop(bar);
    if let Some(page) = page {
        page.write(&report::textured(&TexturedPage {
            input: &arguments.input.name(),
            exemplar: &arguments.input.with_path(&arguments.exemplar).name(),
            prepared: &prepared,
            params: &params,
            mesh: &mesh,
            sample: &sample,
            textured: &textured,
            scale,
            colors: colors.as_ref(),
        }))?;
    }
    tell(&textured, correlation, common);
    Ok(Reply {
        json: std::mem::take(known),
        ..Reply::default()
    })
}

/// A mistake on the command line, or files that no texture comes of.
fn failed(error: TextureError, file: Option<String>) -> Failure {
    let usage = matches!(
        error,
        TextureError::Vertices { .. }
            | TextureError::VerticesOfTexel { .. }
            | TextureError::VerticesOfOwnTexel { .. }
            | TextureError::Texel(_)
            | TextureError::Symmetry { .. }
            | TextureError::Levels { .. }
            | TextureError::Direction
            | TextureError::Displace(_)
    );
    let error = anyhow::Error::new(error);
    Failure {
        usage,
        ..match file {
            Some(file) if !usage => error.context(file).into(),
            _ => error.into(),
        }
    }
}

/// Points and directions of a file.
fn directions(path: &Path) -> Result<Orientation, Failure> {
    let scan = scan::read(path, &scan::ReadOptions::default())?;
    let column = |name: &str| scan.vertices.channel(name).map(|channel| &channel.values);
    let [Some(x), Some(y), Some(z)] = DIRECTION.map(column) else {
        return Err(anyhow::anyhow!(
            "{}: its points have no directions: give them the properties tx, ty and tz (a file of text needs a first line of names: x,y,z,tx,ty,tz)",
            path.display()
        )
        .into());
    };
    let direction =
        |v: usize| Vector3::from([x, y, z].map(|column| column.get_f64(v).unwrap_or(f64::NAN)));
    let points = scan.positions().into_iter().enumerate();
    Ok(Orientation::Given(
        points.map(|(v, point)| (point, direction(v))).collect(),
    ))
}

/// Reads the sample; and what was done to it, in sentences.
fn sample(
    arguments: &Arguments,
    common: &Common,
    known: &mut Map<String, Value>,
) -> Result<(Sample, Vec<String>), Failure> {
    let input = arguments.input.with_path(&arguments.exemplar);
    if !input.is_image() {
        let mut about = Map::new();
        let (surface, told) = arguments.prepare.told_surface(&input, common, &mut about)?;
        known.insert("exemplar_prepared".into(), Value::Object(about));
        let fit = FitParams {
            seed: common.seed,
            ..FitParams::default()
        };
        let bar = Bar::doing(common, "sample");
        let sample = Sample::of_scan(&surface.scan, &fit);
        drop(bar);
        return match sample {
            Ok(sample) => {
                let told = told.iter().map(|what| format!("{}: {what}", input.name()));
                Ok((sample, told.collect()))
            }
            Err(error) => Err(failed(error, Some(input.name()))),
        };
    }
    let image = input.image()?;
    Ok((Sample::of_image(&image), Vec::new()))
}

/// A summary for people, on standard error: standard output may carry the mesh.
fn tell(textured: &Textured, correlation: Option<[f64; 3]>, common: &Common) {
    let report = &textured.report;
    let Some(level) = report.levels.first().filter(|_| !common.quiet) else {
        return;
    };
    let mut text = format!(
        "relievo: {} vertices, texels of {:.6}, edges vary by {:.1} % of their mean\n",
        level.vertices,
        level.texel,
        100.0 * level.edge_variation
    );
    let _ = writeln!(
        text,
        "relievo: {} level(s), {:.1} % of the edges continue the sample; directions turn around {} point(s)",
        report.levels.len(),
        100.0 * level.coherent_edges,
        report.orientation.singularities.len()
    );
    if let Some(correlation) = correlation {
        let _ = writeln!(
            text,
            "relievo: {}",
            histograms::in_words(correlation, "sample")
        );
    }
    // Nowhere is left to report that standard error is closed.
    let _ = std::io::Write::write_all(&mut std::io::stderr(), text.as_bytes());
}
