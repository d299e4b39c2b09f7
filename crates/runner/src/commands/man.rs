//! `itarl man`: manual pages, made of what the command line says of itself.

use std::{fs, path::Path};

use anyhow::Context;
use clap::CommandFactory;
use runs::atomic;

use super::{Outcome, print, print_line};
use crate::cli::Cli;

/// Prints the program's own page, or writes all pages into a folder: `itarl.1`, `itarl-train.1`, ...
pub(super) fn man(folder: Option<&Path>) -> anyhow::Result<Outcome> {
    let mut command = Cli::command().disable_help_subcommand(true);
    command.build();
    match folder {
        None => print(&page(&command)?.1)?,
        Some(folder) => {
            let place = || format!("{}: making it", folder.display());
            fs::create_dir_all(folder).with_context(place)?;
            for (name, bytes) in pages(&command)? {
                let path = folder.join(name);
                atomic::write(&path, &bytes)?;
                print_line(path.display())?;
            }
        }
    }
    Ok(Outcome::Done)
}

/// A file's name and bytes.
type Page = (String, Vec<u8>);

fn page(command: &clap::Command) -> anyhow::Result<Page> {
    let man = clap_mangen::Man::new(command.clone());
    let mut bytes = Vec::new();
    man.render(&mut bytes).context("writing a manual page")?;
    Ok((man.get_filename(), bytes))
}

/// Of a command and all that belong to it.
fn pages(command: &clap::Command) -> anyhow::Result<Vec<Page>> {
    let mut all = vec![page(command)?];
    for inner in command.get_subcommands() {
        all.extend(pages(inner)?);
    }
    Ok(all)
}
