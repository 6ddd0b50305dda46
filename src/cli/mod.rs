//! The command line: one file a subcommand, arguments → params → one library call.
//!
//! stdout carries results only; messages, bars and errors go to stderr.

mod arguments;
mod batch;
mod call;
mod compare;
mod comparison;
mod complete;
mod completions;
mod convert;
mod evaluate;
mod fit;
mod height_map;
mod held;
mod histograms;
mod holes;
mod info;
mod interrupt;
mod left_open;
mod man;
mod mesh_output;
mod messages;
mod outcome;
mod pipeline;
mod plan;
mod reading;
mod render;
mod repeated;
mod report;
mod run;
mod scan_command;
mod schema;
mod scores;
mod stats;
mod step_files;
mod step_options;
mod synth;
mod texture;
mod transfer;
mod watch;

use crate::progress::Progress;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand};

#[cfg(feature = "python")]
pub(crate) use arguments::format_to_write;
pub use batch::{SharedBatch, called_again_by, work_for_batch};
pub use call::{Call, CallError, CallErrorKind, Called};
pub use complete::{TiledCall, grow_tile};
pub use held::{Content, Held};
pub use schema::schema;
pub use watch::Watch;

use outcome::{Outcome, Reply};
use scan_command::ScanCommand;

/// Completes range scans: where the scanner saw nothing, the shape, the relief and the colour are
/// restored, so that the completed part passes as original.
///
/// Exit codes: 0 done; 1 the work failed; 2 wrong usage; 3 partly done (some holes could not be
/// filled, the JSON says which and why).
#[derive(Debug, Parser)]
#[command(name = "relievo", version, propagate_version = true, next_display_order = None)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    common: Common,
}

impl Common {
    /// Gives this process as many threads as --threads says.
    fn start_threads(&self) {
        if let Some(threads) = self.threads {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into());
            if let Err(error) = pool.build_global() {
                log::warn!("--threads: {error}");
            }
        }
    }

    /// Lets whoever watches hear how far the work is.
    fn tell(&self, progress: Progress) {
        if let Some(watch) = &self.watch {
            watch.tell(progress);
        }
    }
}

/// Options that mean the same in every subcommand.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Options of every command")]
struct Common {
    /// Seed of all random choices: the same seed gives the same bytes
    #[arg(long, global = true, value_name = "N", default_value_t = 0)]
    seed: u32,
    #[arg(skip)]
    seed_given: bool,
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
    /// Who hears how far the work is, and may end it.
    #[arg(skip)]
    watch: Option<Watch>,
}

#[derive(Debug, Subcommand)]
enum Command {
    #[command(flatten)]
    Scan(ScanCommand),
    /// Do the same to many scans: complete them, or run a pipeline for each, several at a time
    Batch(batch::Arguments),
    /// What a batch calls for each scan.
    #[command(hide = true)]
    BatchJob,
    /// Print a script that completes relievo's commands and options in a shell
    Completions(completions::Arguments),
    /// Write a scan in another format
    Convert(convert::Arguments),
    /// Cut holes out of a scan, complete them, and judge the fills by how the surface itself varies
    Evaluate(evaluate::Arguments),
    /// Print the manual's page of relievo or of a command, or write all pages (--out)
    Man(man::Arguments),
    /// Do what a pipeline in a file says: read a scan, complete it, measure, draw, write
    Run(run::Arguments),
    /// Print the JSON schema of pipelines, with all options of all steps
    Schema,
    /// Make a test scan with known truth: by default with a hole, or --full, or seen from one side
    Synth(synth::Arguments),
}

/// Runs the command line and gives its exit code: 0 done, 1 the work failed, 2 wrong usage, 3 partly done.
///
/// `arguments` begin with the program's name. It listens to interrupts and sends messages to standard error, both for
/// the whole process: it is meant to be called once, by a program's `main`.
pub fn run(arguments: impl Iterator<Item = OsString>) -> ExitCode {
    let (cli, matches) = match parsed(arguments) {
        Ok(parsed) => parsed,
        Err(code) => return code,
    };
    let common = Common {
        seed_given: repeated::is_given(&matches, "seed"),
        ..cli.common
    };
    interrupt::install();
    if matches!(cli.command, Command::BatchJob) {
        return batch::child();
    }
    messages::install(&common);
    common.start_threads();
    let Files {
        command: name,
        inputs,
        output,
    } = cli.command.files();
    let input = inputs.first().copied();
    let mut protected = inputs.clone();
    protected.extend(cli.command.protected());
    let plan = match cli.command.plan(&common) {
        Ok(plan) => plan,
        Err(failure) => {
            let report = outcome::Report::open_new(common.json.as_deref(), &protected);
            return Outcome::of(name, input, None, Err(failure)).deliver(report);
        }
    };
    let (reads, writes) = plan.files();
    protected.extend(reads.iter().map(PathBuf::as_path));
    let mut outputs = vec![("-o", output)];
    outputs.extend(
        writes
            .iter()
            .map(|(what, path)| (*what, Some(path.as_path()))),
    );
    let report = match outcome::Report::open(common.json.as_deref(), &protected, &outputs) {
        Ok(report) => report,
        Err(failure) => return Outcome::of(name, input, None, Err(failure)).deliver(None),
    };
    let reply = match &cli.command {
        Command::Scan(command) => command.run(&common),
        Command::Batch(_) | Command::Run(_) => plan.run(&common),
        Command::BatchJob => return batch::child(),
        Command::Completions(arguments) => completions::run(arguments, Cli::command()),
        Command::Convert(arguments) => convert::run(arguments, &common),
        Command::Evaluate(arguments) => evaluate::run(arguments, &common),
        Command::Man(arguments) => man::run(arguments, Cli::command()),
        Command::Schema => schema::run(),
        Command::Synth(arguments) => synth::run(arguments, &common),
    };
    let repeated = repeated::repeated(&matches, common.seed);
    Outcome::of(name, input, repeated, reply).deliver(report)
}

/// What the command line says; the exit code where it is wrong, or asks for help or the version.
fn parsed(
    arguments: impl Iterator<Item = OsString>,
) -> std::result::Result<(Cli, clap::ArgMatches), ExitCode> {
    let arguments: Vec<OsString> = arguments.map(run::in_one_word).collect();
    (Cli::command().try_get_matches_from(&arguments))
        .and_then(|matches| Ok((Cli::from_arg_matches(&matches)?, matches)))
        .map_err(|error| {
            // Help and version are no errors and go to stdout; a closed pipe is not ours to report.
            let _ = error.print();
            if error.use_stderr() {
                outcome::report_usage_error(&arguments, &error);
            }
            ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2))
        })
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
            Self::Scan(command) => return command.files(),
            Self::Batch(_) => ("batch", None, None),
            Self::BatchJob => (batch::CHILD, None, None),
            Self::Completions(_) => ("completions", None, None),
            Self::Convert(a) => ("convert", Some(&a.input), Some(&a.output)),
            Self::Evaluate(a) => ("evaluate", Some(&a.input), None),
            Self::Man(_) => ("man", None, None),
            Self::Run(_) => ("run", None, None),
            Self::Schema => ("schema", None, None),
            Self::Synth(a) => ("synth", None, Some(&a.output)),
        };
        Files {
            command,
            inputs: input.into_iter().flat_map(reading::Input::files).collect(),
            output: output.map(PathBuf::as_path),
        }
    }
}

/// What a subcommand gives back.
type Result = std::result::Result<Reply, outcome::Failure>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_definition_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn bare_arguments_are_the_librarys_defaults() {
        let params = |line: &str| match Cli::try_parse_from(line.split(' ')).unwrap().command {
            Command::Scan(ScanCommand::Complete(arguments)) => arguments.params(0),
            _ => unreachable!(),
        };
        let default = crate::completion::CompleteParams::default();
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
        let as_in_paper = crate::completion::CompleteParams {
            window: Some(5),
            rotations: Some(4),
            error_threshold: Some(0.3),
            mu: Some(0.5),
            spacing: Some(crate::sampling::SpacingRule::Nyquist),
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
        let default = crate::evaluation::EvaluationParams::default();
        assert_eq!(params("relievo evaluate in.ply"), default);
        let all = "relievo evaluate in.ply --hole 0.04 --repeat 3 --pieces 128 --fill completed";
        assert_eq!(params(all), default);
    }

    #[test]
    fn bare_render_arguments_are_the_librarys_defaults() {
        let params = |line: &str| match Cli::try_parse_from(line.split(' ')).unwrap().command {
            Command::Scan(ScanCommand::Render(arguments)) => arguments.params(0),
            _ => unreachable!(),
        };
        let default = crate::picture::RenderParams::default();
        assert_eq!(params("relievo render in.ply -o out.png"), default);
        let all = "relievo render in.ply -o out.png --view auto --up auto --zoom 1 --look-at all \
                   --projection perspective --size 1600x1200 --background white";
        assert_eq!(params(all), default);
    }

    #[test]
    fn bare_transfer_arguments_are_the_librarys_defaults() {
        let params = |line: &str| match Cli::try_parse_from(line.split(' ')).unwrap().command {
            Command::Scan(ScanCommand::Transfer(arguments)) => arguments.params(0),
            _ => unreachable!(),
        };
        let default = crate::transfer::TransferParams::default();
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
            Command::Scan(ScanCommand::Complete(arguments)) => arguments.prepare.cloud_params(0),
            _ => unreachable!(),
        };
        let default = crate::cloud::CloudParams::default();
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
        let expected = crate::synth::SynthParams {
            part: crate::synth::Part::hole(0.1),
            ..Default::default()
        };
        assert_eq!(arguments.params(0), expected);
    }
}
