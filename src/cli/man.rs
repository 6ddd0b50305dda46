//! `relievo man`

use std::path::{Path, PathBuf};

use crate::scan::OutputFile;
use anyhow::Context;
use clap::{Args, Command};
use clap_mangen::Man;
use serde_json::{Map, json};

use super::outcome::{Failure, Reply, written};

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The command whose page is printed [default: that of relievo itself]
    #[arg(value_name = "COMMAND", conflicts_with = "out")]
    command: Option<String>,
    /// Write the pages of relievo and of all commands into this folder, as man/man1; it is made if it is not there
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// `relievo` is the whole command line.
pub(super) fn run(arguments: &Arguments, relievo: Command) -> super::Result {
    // Without a page for `help`, which has none of its own to tell; built, so that pages have the options of every command.
    let mut relievo = relievo.disable_help_subcommand(true);
    relievo.build();
    match &arguments.out {
        Some(folder) => write_all(&relievo, folder),
        None => print(&relievo, arguments.command.as_deref()),
    }
}

fn print(relievo: &Command, command: Option<&str>) -> super::Result {
    let command = match command {
        Some(name) => (subcommands(relievo).find(|command| command.get_name() == name))
            .ok_or_else(|| unknown(relievo, name))?,
        None => relievo,
    };
    Ok(Reply {
        text: String::from_utf8(page(command)?)?,
        ..Reply::default()
    })
}

fn write_all(relievo: &Command, folder: &Path) -> super::Result {
    std::fs::create_dir_all(folder).with_context(|| {
        let shown = folder.display();
        format!("{shown}: this folder is not there and cannot be made")
    })?;
    let mut pages = Vec::new();
    for command in std::iter::once(relievo).chain(subcommands(relievo)) {
        let path = folder.join(Man::new(command.clone()).get_filename());
        written(OutputFile::create(&path, None)?, &page(command)?)?;
        pages.push(json!(path.to_string_lossy()));
    }
    Ok(Reply {
        json: Map::from_iter([("pages".to_owned(), pages.into())]),
        ..Reply::default()
    })
}

/// Those that are shown in the help.
fn subcommands(relievo: &Command) -> impl Iterator<Item = &Command> {
    (relievo.get_subcommands()).filter(|command| !command.is_hide_set())
}

fn page(command: &Command) -> std::io::Result<Vec<u8>> {
    let mut page = Vec::new();
    Man::new(command.clone()).render(&mut page)?;
    Ok(page)
}

fn unknown(relievo: &Command, name: &str) -> Failure {
    let names: Vec<&str> = subcommands(relievo).map(Command::get_name).collect();
    Failure::usage(format!(
        "{name}: relievo has no command of this name: give one of {}",
        names.join(", ")
    ))
}
