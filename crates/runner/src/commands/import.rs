//! `itarl model import`: a robot in another format as a model file, and the account of it.

use std::{
    fs,
    path::{Path, PathBuf},
};

use anyhow::{Context, bail};
use formats::{Imported, Options};
use runs::atomic;
use svenja::Morphology;

use super::{Outcome, print_line};
use crate::{
    cli::{Base, Import},
    progress::notify,
};

pub(super) fn import(arguments: &Import) -> anyhow::Result<Outcome> {
    let out = match &arguments.out {
        Some(out) => out.clone(),
        None => PathBuf::from(arguments.file.file_stem().context("FILE must be a file's name")?)
            .with_extension("toml"),
    };
    let stem = out.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let options = Options {
        packages: arguments.packages.clone(),
        base: arguments.base.map(|base| match base {
            Base::Free => formats::Base::Free,
            Base::Fixed => formats::Base::Fixed,
        }),
        feet: arguments.feet.clone(),
        mesh_folder: Some(format!("{stem}-meshes")),
    };
    let imported = match formats::import(&arguments.file, &options) {
        Ok(imported) => imported,
        Err(problems) => {
            notify(problems);
            return Ok(Outcome::Failed);
        }
    };
    write(&imported, &out)?;
    print_line(&imported.report)?;
    print_line(format_args!("\n{}: written", out.display()))?;
    check(&out, arguments.strict && !imported.report.is_complete())
}

/// The model file last, so that it's never there without its meshes. One that is there may have been
/// worked on, and is left as it is.
fn write(imported: &Imported, out: &Path) -> anyhow::Result<()> {
    let older = atomic::read(out)?;
    if older.is_some_and(|older| older != imported.text.as_bytes()) {
        bail!(
            "{}: there is another file of this name; name a new one with -o, or take it away",
            out.display()
        );
    }
    let folder = out.parent().unwrap_or(Path::new(""));
    for mesh in &imported.meshes {
        let to = folder.join(&mesh.to);
        let bytes =
            fs::read(&mesh.from).with_context(|| format!("{}: reading", mesh.from.display()))?;
        if let Some(meshes) = to.parent() {
            fs::create_dir_all(meshes)
                .with_context(|| format!("{}: making the folder", meshes.display()))?;
        }
        atomic::write(&to, &bytes)?;
    }
    Ok(atomic::write(out, imported.text.as_bytes())?)
}

/// Reads what was written as anybody does.
fn check(out: &Path, is_strict: bool) -> anyhow::Result<Outcome> {
    match Morphology::open(out) {
        Ok(model) => {
            for warning in model.warnings() {
                notify(format_args!("{}: warning: {}", warning.place, warning.message));
            }
        }
        Err(problems) => {
            notify(problems);
            notify("the model file isn't one; that's a mistake in itarl: please report it");
            return Ok(Outcome::Failed);
        }
    }
    if is_strict {
        notify("--strict: not everything was carried over");
        return Ok(Outcome::Failed);
    }
    Ok(Outcome::Done)
}
