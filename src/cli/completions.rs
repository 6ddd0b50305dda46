//! `relievo completions`

use clap::{Args, Command};
use clap_complete::Shell;

use super::outcome::Reply;

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The shell
    #[arg(value_name = "SHELL")]
    shell: Shell,
}

/// `relievo` is the whole command line.
pub(super) fn run(arguments: &Arguments, mut relievo: Command) -> super::Result {
    let name = relievo.get_name().to_owned();
    // Not to standard output at once: a pipe that is closed early would be a panic.
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut relievo, name, &mut script);
    Ok(Reply {
        text: String::from_utf8(script)?,
        ..Reply::default()
    })
}
