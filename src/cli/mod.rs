//! The command line: one file a subcommand, arguments → params → one library call.
//!
//! stdout carries results only; messages, bars and errors go to stderr.

mod arguments;
mod compare;
mod comparison;
mod complete;
mod convert;
mod evaluate;
mod fit;
mod height_map;
mod histograms;
mod holes;
mod info;
mod interrupt;
mod left_open;
mod mesh_output;
mod messages;
mod outcome;
mod reading;
mod render;
mod report;
mod scores;
mod stats;
mod synth;
mod texture;
mod transfer;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};

use outcome::{Outcome, Reply};

/// Completes range scans: where the scanner saw nothing, the shape, the relief and the colour are
/// restored, so that the completed part passes as original.
///
/// Exit codes: 0 done; 1 the work failed; 2 wrong usage; 3 partly done (some holes could not be
/// filled, the JSON says which and why).
#[derive(Debug, Parser)]
#[command(name = "relievo", version, propagate_version = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    common: Common,
}

/// Options that mean the same in every subcommand.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Options of every command")]
struct Common {
    /// Seed of all random choices: the same seed gives the same bytes
    #[arg(long, global = true, value_name = "N", default_value_t = 0)]
    seed: u32,
    /// Number of threads [default: all cores]; the result does not depend on it
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    /// Write the results as JSON to FILE, or to standard output (-); also on failure
    #[arg(long, global = true, value_name = "FILE|-")]
    json: Option<PathBuf>,
    /// Print errors only
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,
    /// Print what is done at each step, and how long it takes
    #[arg(short, long, global = true)]
    verbose: bool,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Compare two scans, or two parts of one, in figures and in units of natural variation
    Compare(compare::Arguments),
    /// Complete the missing parts of a scan
    Complete(complete::Arguments),
    /// Write a scan in another format
    Convert(convert::Arguments),
    /// Cut holes out of a scan, complete them, and judge the fills by how the surface itself varies
    Evaluate(evaluate::Arguments),
    /// Fit a base surface: parameters, residuals, how the other kinds compare
    Fit(fit::Arguments),
    /// List every boundary loop: id, edges, length, area estimate, hole or outer rim
    Holes(holes::Arguments),
    /// Tell what is in a file: vertices, faces, properties, extent, pieces, holes, what would be repaired
    Info(info::Arguments),
    /// Draw a scan or one of its channels as a PNG picture, without a display
    Render(render::Arguments),
    /// Compare the original part of a completed scan with the completed part, or tell the areal parameters of a
    /// height map (--step)
    Stats(stats::Arguments),
    /// Make a test scan with known truth: by default with a hole, or --full, or seen from one side
    Synth(synth::Arguments),
    /// Put the texture of a sample, an image or a scan, all over a mesh: in colour, or as relief
    Texture(texture::Arguments),
    /// Copy colours or relief from one mesh onto another, following its shape, or from a part of a mesh onto the rest
    Transfer(transfer::Arguments),
}

/// Runs the command line and gives its exit code.
pub(crate) fn run(arguments: impl Iterator<Item = OsString>) -> ExitCode {
    let arguments: Vec<OsString> = arguments.collect();
    let cli = match Cli::try_parse_from(&arguments) {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version are no errors and go to stdout; a closed pipe is not ours to report.
            let _ = error.print();
            if error.use_stderr() {
                outcome::report_usage_error(&arguments, &error);
            }
            return ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2));
        }
    };
    let common = cli.common;
    messages::install(&common);
    interrupt::install();
    if let Some(threads) = common.threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into());
        if let Err(error) = pool.build_global() {
            log::warn!("--threads: {error}");
        }
    }
    let Files {
        command: name,
        inputs,
        output,
    } = cli.command.files();
    let input = inputs.first().copied();
    let report = match outcome::Report::open(common.json.as_deref(), &inputs, output) {
        Ok(report) => report,
        Err(failure) => return Outcome::of(name, input, Err(failure)).deliver(None),
    };
    let reply = match &cli.command {
        Command::Compare(arguments) => compare::run(arguments, &common),
        Command::Complete(arguments) => complete::run(arguments, &common),
        Command::Convert(arguments) => convert::run(arguments, &common),
        Command::Evaluate(arguments) => evaluate::run(arguments, &common),
        Command::Fit(arguments) => fit::run(arguments, &common),
        Command::Holes(arguments) => holes::run(arguments, &common),
        Command::Info(arguments) => info::run(arguments),
        Command::Render(arguments) => render::run(arguments, &common),
        Command::Stats(arguments) => stats::run(arguments, &common),
        Command::Synth(arguments) => synth::run(arguments, &common),
        Command::Texture(arguments) => texture::run(arguments, &common),
        Command::Transfer(arguments) => transfer::run(arguments, &common),
    };
    Outcome::of(name, input, reply).deliver(report)
}

/// What a subcommand is called, reads and writes.
struct Files<'a> {
    command: &'static str,
    /// The scan first.
    inputs: Vec<&'a Path>,
    /// What -o names.
    output: Option<&'a Path>,
}

impl Command {
    fn files(&self) -> Files<'_> {
        let (command, input, output) = match self {
            Self::Compare(a) => ("compare", Some(&a.input), None),
            Self::Complete(a) => ("complete", Some(&a.input), Some(&a.output)),
            Self::Convert(a) => ("convert", Some(&a.input), Some(&a.output)),
            Self::Evaluate(a) => ("evaluate", Some(&a.input), None),
            Self::Fit(a) => ("fit", Some(&a.input), None),
            Self::Holes(a) => ("holes", Some(&a.input), None),
            Self::Info(a) => ("info", Some(&a.input), None),
            Self::Render(a) => ("render", Some(&a.input), Some(&a.output)),
            Self::Stats(a) => ("stats", Some(&a.input), None),
            Self::Synth(a) => ("synth", None, Some(&a.output)),
            Self::Texture(a) => ("texture", Some(&a.input), Some(&a.output)),
            Self::Transfer(a) => ("transfer", None, Some(&a.output)),
        };
        let mut inputs: Vec<&Path> = input.into_iter().flat_map(reading::Input::files).collect();
        if let Self::Compare(a) = self {
            inputs.extend(a.other.as_deref());
        }
        if let Self::Texture(a) = self {
            inputs.extend(a.others());
        }
        if let Self::Transfer(a) = self {
            inputs.extend(a.files());
        }
        Files {
            command,
            inputs,
            output: output.map(PathBuf::as_path),
        }
    }
}

/// What a subcommand gives back.
type Result = std::result::Result<Reply, outcome::Failure>;

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definition_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn bare_arguments_are_the_librarys_defaults() {
        let params = |line: &str| match Cli::try_parse_from(line.split(' ')).unwrap().command {
            Command::Complete(arguments) => arguments.params(0),
            _ => unreachable!(),
        };
        let default = relievo::completion::CompleteParams::default();
        assert_eq!(params("relievo complete in.ply -o out.ply"), default);
        let all = params(
            "relievo complete in.ply -o out.ply --base auto --holes interior --method coherent \
             --coherence 0.3 --sites 8192 --memory 2GiB --audit 0 \
             --tolerance 0.1",
        );
        assert_eq!(all, default);
        let blend =
            |options: &str| params(&format!("relievo complete in.ply -o out.ply {options}")).blend;
        assert_eq!(blend("--blend"), Some(true));
        assert_eq!(blend("--blend=no"), Some(false));
        let given = params(
            "relievo complete in.ply -o out.ply --window 5 --rotations 4 --error-threshold 0.3 \
             --shape-weight 0.5 --spacing nyquist",
        );
        let as_in_paper = relievo::completion::CompleteParams {
            window: Some(5),
            rotations: Some(4),
            error_threshold: Some(0.3),
            mu: Some(0.5),
            spacing: Some(relievo::sampling::SpacingRule::Nyquist),
            ..default
        };
        assert_eq!(given, as_in_paper);
    }

    #[test]
    fn bare_evaluate_arguments_are_the_librarys_defaults() {
        let params = |line: &str| match Cli::try_parse_from(line.split(' ')).unwrap().command {
            Command::Evaluate(arguments) => arguments.params(0),
            _ => unreachable!(),
        };
        let default = relievo::evaluation::EvaluationParams::default();
        assert_eq!(params("relievo evaluate in.ply"), default);
        let all = "relievo evaluate in.ply --hole 0.04 --repeat 3 --pieces 128 --fill completed";
        assert_eq!(params(all), default);
    }

    #[test]
    fn bare_render_arguments_are_the_librarys_defaults() {
        let params = |line: &str| match Cli::try_parse_from(line.split(' ')).unwrap().command {
            Command::Render(arguments) => arguments.params(0),
            _ => unreachable!(),
        };
        let default = relievo::picture::RenderParams::default();
        assert_eq!(params("relievo render in.ply -o out.png"), default);
        let all = "relievo render in.ply -o out.png --view auto --up auto --zoom 1 --look-at all \
                   --projection perspective --size 1600x1200 --background white";
        assert_eq!(params(all), default);
    }

    #[test]
    fn bare_transfer_arguments_are_the_librarys_defaults() {
        let params = |line: &str| match Cli::try_parse_from(line.split(' ')).unwrap().command {
            Command::Transfer(arguments) => arguments.params(0),
            _ => unreachable!(),
        };
        let default = relievo::transfer::TransferParams::default();
        let bare = "relievo transfer --source a.ply --target b.ply -o out.ply";
        assert_eq!(params(bare), default);
        let all = "--shape heat-kernel --up y --source-up 0,1,0 --shape-weight 0.2 --scale 1 --rounds 5 \
                   --rotations all --final nearest --coherence 0.3 --overuse 0.02 --audit 0";
        assert_eq!(params(&format!("{bare} {all}")), default);
        let turned = params(&format!("{bare} --up z --source-up none"));
        assert_eq!(turned.up, [None, Some(nalgebra::Vector3::z())]);
    }

    #[test]
    fn bare_preparation_is_the_librarys_default() {
        let parsed = |line: &str| match Cli::try_parse_from(line.split(' ')).unwrap().command {
            Command::Complete(arguments) => arguments.prepare.cloud_params(0),
            _ => unreachable!(),
        };
        let default = relievo::cloud::CloudParams::default();
        assert_eq!(parsed("relievo complete in.xyz -o out.ply"), default);
        let all = "relievo complete in.xyz -o out.ply --join auto --gap 4";
        assert_eq!(parsed(all), default);
        let kept = parsed("relievo complete in.xyz -o out.ply --keep-outliers");
        assert_eq!(kept.outliers, None);
    }

    #[test]
    fn bare_synth_arguments_are_the_librarys_defaults_but_for_the_hole() {
        let cli = Cli::try_parse_from("relievo synth golf-ball -o out.ply".split(' ')).unwrap();
        let Command::Synth(arguments) = cli.command else {
            unreachable!();
        };
        let expected = relievo::synth::SynthParams {
            part: relievo::synth::Part::hole(0.1),
            ..Default::default()
        };
        assert_eq!(arguments.params(0), expected);
    }
}
