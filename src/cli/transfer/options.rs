//! What can be asked for.

use std::path::{Path, PathBuf};

use crate::completion::Paint;
use crate::scan::Format;
use crate::transfer::{Last, Rotations, Shape, TransferParams};
use clap::{Args, ValueEnum};
use nalgebra::Vector3;

use super::super::arguments;
use super::super::held::Writing;
use super::super::mesh_output::Destination;
use super::super::outcome::Failure;
use super::super::reading::{Input, Preparation, Reading};
use super::super::report::PageOption;
use super::is_same;

/// Shown below the options.
const USES: &str = "\
Uses:
  Colours from one mesh to another:
    relievo transfer --source ZEBRA.ply --target COW.ply -o OUT.ply
  Texture by example, on one mesh:
    relievo transfer --source MESH.ply --mask painted -o OUT.ply
  Colours again after an edit of the mesh:
    relievo transfer --source OLD.ply --target NEW.ply --shape position -o OUT.ply
  Relief from one mesh to another:
    relievo transfer --source ROCK.ply --target MESH.ply --channel height -o OUT.ply";

#[derive(Debug, Args)]
#[command(after_help = USES)]
pub(in super::super) struct Arguments {
    /// The mesh that is copied from: any format that scans are read in; - for standard input
    #[arg(long, value_name = "FILE")]
    pub(in super::super) source: PathBuf,
    /// The mesh that gets the source's colours or relief; with --mask it is the source
    #[arg(long, value_name = "FILE", required_unless_present = "mask")]
    target: Option<PathBuf>,
    /// Where to: .ply, .obj, .off, .stl or .glb; - for PLY on standard output
    #[arg(short, long, value_name = "OUT")]
    pub(in super::super) output: PathBuf,
    #[command(flatten)]
    pub(in super::super) reading: Reading,
    #[command(flatten)]
    pub(super) prepare: Preparation,
    /// What is copied
    #[arg(long, value_enum, default_value_t = ChannelName::Color)]
    channel: ChannelName,
    /// Relief: what is longer than this is form, what is shorter relief, in the source's unit [default: where heights
    /// depend on it least]
    #[arg(long, value_name = "LENGTH", value_parser = arguments::length)]
    pub(super) form_wavelength: Option<f64>,
    /// Move vertices along their normals by SCALE times the source's relief (1 keeps its proportions) [default: 1]
    #[arg(long, value_name = "SCALE", allow_negative_numbers = true)]
    displace: Option<f64>,
    /// Only one mesh: spread what is painted over the rest; painted is where this vertex property is not 0, or has the
    /// value of NAME=VALUE, or where the colour is not exactly #RRGGBB
    #[arg(
        long,
        value_name = "NAME|NAME=VALUE|#RRGGBB",
        value_parser = arguments::paint,
        conflicts_with_all = ["init", "correspondences", "scale"]
    )]
    pub(super) mask: Option<Paint>,
    /// Places that belong together: JSON, a list of pairs [SOURCE, TARGET] of vertices (from 0) or points [x, y, z], or
    /// {"pairs": [{"source": …, "target": … or a list}, …]}; what is near them is alike
    #[arg(long, value_name = "FILE.json", conflicts_with = "shape")]
    pub(super) correspondences: Option<PathBuf>,
    /// What tells which parts of the meshes are alike
    #[arg(long, value_enum, default_value_t = ShapeName::HeatKernel)]
    shape: ShapeName,
    /// What is up on both meshes: x, y, z, none, or a direction
    #[arg(
        long,
        value_name = "x|y|z|none|DX,DY,DZ",
        default_value = "y",
        value_parser = upward,
        allow_hyphen_values = true
    )]
    up: Upward,
    /// What is up on the source [default: as --up]
    #[arg(
        long,
        value_name = "x|y|z|none|DX,DY,DZ",
        value_parser = upward,
        allow_hyphen_values = true
    )]
    source_up: Option<Upward>,
    /// How much shape counts against colours or relief, from 0 to 1
    #[arg(
        long,
        value_name = "W",
        default_value_t = 0.2,
        allow_negative_numbers = true
    )]
    shape_weight: f64,
    /// Size of the texture on the target, where 1 keeps its size against the mesh
    #[arg(
        long,
        value_name = "FACTOR",
        default_value_t = 1.0,
        allow_negative_numbers = true
    )]
    pub(super) scale: f64,
    /// Work on at least so many vertices of the target; those that it lacks are put on its edges [default: as many as
    /// the source has, up to 65536]
    #[arg(long, value_name = "N")]
    pub(super) vertices: Option<usize>,
    /// Share of its cost that a match is spared if it continues that of a neighbor: more keeps larger pieces of the
    /// source together
    #[arg(
        long,
        value_name = "SHARE",
        default_value_t = 0.3,
        allow_negative_numbers = true
    )]
    coherence: f64,
    /// Penalty, in units of the cost, of a vertex of the source that is used twice as often as others: more spreads
    /// all of the source over the target where its shape does not tell
    #[arg(
        long,
        value_name = "COST",
        default_value_t = 0.02,
        allow_negative_numbers = true
    )]
    overuse: f64,
    /// Compare the matches of so many vertices with the best of all that there are; the JSON tells how they do
    #[arg(long, value_name = "N", default_value_t = 0)]
    audit: usize,
    /// Rounds of search and votes on each level
    #[arg(long, value_name = "N", default_value_t = 5)]
    rounds: u32,
    /// How rotations are compared
    #[arg(long, value_enum, default_value_t = RotationsName::All)]
    rotations: RotationsName,
    /// What the target gets in the end
    #[arg(long = "final", value_enum, default_value_t = LastName::Nearest)]
    last: LastName,
    /// Start from a map: the source's vertex for each of the target's, as text with one number a line (from 0; -1 or
    /// nan for none), as a JSON list, or as a mesh with the vertex property source, such as what this command writes
    #[arg(long, value_name = "FILE")]
    pub(super) init: Option<PathBuf>,
    /// Put no vertices on the target's edges: what comes out has its own vertices only
    #[arg(long)]
    pub(super) keep_mesh: bool,
    /// Largest side of the texture image that targets with texture coordinates get, in pixels [default: by the vertices
    /// worked on, up to 8192]
    #[arg(long, value_name = "PIXELS")]
    image_size: Option<u32>,
    #[command(flatten)]
    pub(super) page: PageOption,
    #[command(flatten)]
    pub(in super::super) writing: Writing,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ChannelName {
    /// Colours, of vertices or of a texture image
    Color,
    /// Relief: how far vertices are from the source's smooth form
    Height,
    /// Colours and relief of the same places
    Both,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum ShapeName {
    /// How heat spreads from each vertex: limbs are like limbs, however they are bent
    HeatKernel,
    /// Where a vertex is: for meshes that lie alike, such as edited ones
    Position,
    /// Only what is up
    None,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum RotationsName {
    /// Each of 18 in every comparison
    All,
    /// Those of neighbors, and some at random: faster
    Search,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum LastName {
    /// What each vertex was matched with
    Nearest,
    /// The mean of all that reach over it: smoother
    Vote,
}

/// A direction that is up, or none.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Upward(Option<Vector3<f64>>);

fn upward(text: &str) -> Result<Upward, String> {
    Ok(Upward(match text {
        "x" => Some(Vector3::x()),
        "y" => Some(Vector3::y()),
        "z" => Some(Vector3::z()),
        "none" => None,
        _ => Some(arguments::vector(text).map_err(|_| {
            "expected x, y, z, none, or a direction: three numbers with commas between".to_owned()
        })?),
    }))
}

impl Arguments {
    /// All but correspondences, which are in a file.
    pub(in super::super) fn params(&self, seed: u32) -> TransferParams {
        let up = self.up;
        TransferParams {
            vertices: self.vertices,
            scale: self.scale,
            shape: match self.shape {
                ShapeName::HeatKernel => Shape::HeatKernel,
                ShapeName::Position => Shape::Position,
                ShapeName::None => Shape::None,
            },
            up: [self.source_up.unwrap_or(up).0, up.0],
            shape_weight: self.shape_weight,
            coherence: self.coherence,
            overuse: self.overuse,
            audit: self.audit,
            rotations: match self.rotations {
                RotationsName::All => Rotations::All,
                RotationsName::Search => Rotations::Search,
            },
            rounds: self.rounds,
            last: match self.last {
                LastName::Nearest => Last::Nearest,
                LastName::Vote => Last::Vote,
            },
            seed,
        }
    }

    /// What the parser cannot tell.
    pub(super) fn check(&self) -> Result<(), Failure> {
        if let (Some(_), Some(target)) = (&self.mask, &self.target)
            && !is_same(target, &self.source)
        {
            return Err(Failure::usage(format!(
                "{}: --mask spreads what is painted over the same mesh: leave out --target, or --mask",
                target.display()
            )));
        }
        let stream = Path::new("-");
        let streams = [Some(&self.source), self.target.as_ref(), self.init.as_ref()];
        if streams
            .into_iter()
            .flatten()
            .filter(|path| *path == stream)
            .count()
            > 1
        {
            return Err(Failure::usage(
                "standard input can be read only once: give all but one of source, target and map as files",
            ));
        }
        if self.image_size.is_some() && !self.has_colors() {
            return Err(Failure::usage(
                "--image-size is about a texture image of colours: leave it out, or add --channel both",
            ));
        }
        if let Some(scale) = self.displace.filter(|scale| !scale.is_finite()) {
            return Err(Failure::usage(format!(
                "--displace must be a finite number, not {scale}"
            )));
        }
        let relief_only = [
            ("--displace", self.displace.is_some()),
            ("--form-wavelength", self.form_wavelength.is_some()),
        ];
        if let Some((option, _)) = relief_only.iter().find(|(_, given)| *given)
            && !self.has_relief()
        {
            return Err(Failure::usage(format!(
                "{option} is about relief: add --channel height, or both"
            )));
        }
        Ok(())
    }

    pub(super) fn has_colors(&self) -> bool {
        self.channel != ChannelName::Height
    }

    pub(super) fn has_relief(&self) -> bool {
        self.channel != ChannelName::Color
    }

    /// What relief is multiplied with.
    pub(super) fn displacement(&self) -> Option<f64> {
        self.has_relief().then(|| self.displace.unwrap_or(1.0))
    }

    pub(super) fn source_input(&self) -> Input {
        self.reading.of(&self.source)
    }

    pub(super) fn target_input(&self) -> Input {
        self.reading.of(self.target_path())
    }

    pub(in super::super) fn target_path(&self) -> &Path {
        self.target.as_deref().unwrap_or(&self.source)
    }

    /// What is read beside source and target.
    fn beside(&self) -> impl Iterator<Item = &Path> {
        let image = self.reading.color_image();
        (self.correspondences.as_deref().into_iter())
            .chain(self.init.as_deref())
            .chain(image)
    }

    /// All files that are read, the target first.
    pub(in super::super) fn files(&self) -> impl Iterator<Item = &Path> {
        (self.reading.files(self.target_path()))
            .chain(self.reading.files(&self.source))
            .chain(self.beside())
    }

    pub(super) fn destination(&self, format: Option<Format>) -> Destination<'_> {
        let target = self.target_path();
        let source = (!is_same(&self.source, target)).then_some(self.source.as_path());
        Destination {
            path: &self.output,
            format,
            own: vec![target],
            writing: &self.writing,
            others: source.into_iter().chain(self.beside()).collect(),
            with_image: self.has_colors(),
            image_size: self.image_size,
        }
    }
}
