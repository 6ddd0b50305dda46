//! `relievo`: completes range scans with their relief and colour. The command line only; see the
//! library for what it calls.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::run(std::env::args_os())
}
