//! The arguments of `itarl model import`.

use std::path::PathBuf;

use clap::{Args, ValueEnum, ValueHint};

/// The arguments of `itarl model import`.
#[derive(Debug, Args)]
pub struct Import {
    /// The robot's file; its root element tells the format
    #[arg(value_hint = ValueHint::FilePath)]
    pub file: PathBuf,
    /// The model file to write [default: NAME.toml for NAME.urdf, here]
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub out: Option<PathBuf>,
    /// Where a ROS package is, for package://NAME/...; files in DIR may then be opened
    #[arg(long = "package", value_name = "NAME=DIR", value_parser = package)]
    pub packages: Vec<(String, PathBuf)>,
    /// Whether the base is free or fixed to the world [default: as in the file]
    #[arg(long, value_enum)]
    pub base: Option<Base>,
    /// The bodies that are feet [default: by their names, or the lowest bodies of limbs]
    #[arg(long, value_name = "BODY,...", value_delimiter = ',')]
    pub feet: Option<Vec<String>>,
    /// Fail if anything of the robot is left out
    #[arg(long)]
    pub strict: bool,
}

/// How a robot is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Base {
    /// It can fall
    Free,
    /// Its root is fixed to the world
    Fixed,
}

fn package(text: &str) -> Result<(String, PathBuf), String> {
    match text.split_once('=') {
        Some((name, folder)) if !name.is_empty() && !folder.is_empty() => {
            Ok((name.into(), folder.into()))
        }
        _ => Err(format!("NAME=DIR expected, got {text}")),
    }
}
