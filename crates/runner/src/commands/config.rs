//! `itarl config`: the complete settings of an experiment file, or what settings mean.

use anyhow::Context;
use clap::CommandFactory;
use comfy_table::{ContentArrangement, Table, presets::NOTHING};
use config::{Presence, Setting};

use super::{Outcome, open, print_line};
use crate::{
    cli::{Cli, Config, ExperimentFile},
    experiment::explained,
};

/// Characters of a line.
const WIDTH: u16 = 100;

pub(super) fn config(arguments: Config) -> anyhow::Result<Outcome> {
    match arguments {
        Config { help: Some(Some(key)), .. } => {
            let explained: Vec<_> = explained(&key).iter().map(explanation).collect();
            print_line(explained.join("\n\n"))?;
        }
        Config { help: None, file: Some(file), set } => {
            print_line(open(&ExperimentFile { file, set })?.to_toml().trim_end())?;
        }
        Config { .. } => help()?,
    }
    Ok(Outcome::Done)
}

/// As the other commands print theirs.
fn help() -> anyhow::Result<()> {
    let mut itarl = Cli::command();
    itarl.build();
    let config = itarl.find_subcommand_mut("config").context("there is no such command")?;
    config.print_help().context("standard output: writing")
}

/// The key, and below it what there is to say of it.
fn explanation(setting: &Setting) -> String {
    let default = match &setting.presence {
        Presence::Required => "none: it must be there",
        Presence::Optional => "none",
        Presence::Default(value) => value,
    };
    let mut table = Table::new();
    table
        .load_preset(NOTHING)
        .set_content_arrangement(ContentArrangement::Dynamic)
        .set_width(WIDTH);
    table.add_row(["meaning", &setting.about]);
    for (kind, about) in &setting.kinds {
        table.add_row(["", &format!("\"{kind}\": {about}")]);
    }
    table.add_row(["value", &setting.expected]).add_row(["default", default]);
    if let Some(only) = &setting.only {
        let kinds: Vec<_> = only.kinds.iter().map(|kind| format!("\"{kind}\"")).collect();
        table.add_row(["only where", &format!("{} is {}", only.key, kinds.join(" or "))]);
    }
    // Code isn't marked in a terminal.
    format!("{}\n{}", setting.key, table.trim_fmt().replace('`', ""))
}
