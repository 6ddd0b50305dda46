//! `relievo`: completes range scans with their relief and colour. The command line is the library's room
//! [`relievo::cli`].

use std::process::ExitCode;

fn main() -> ExitCode {
    relievo::cli::run(std::env::args_os())
}
