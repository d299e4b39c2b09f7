//! `itarl model`: checks and shows model files, and those of other formats.

use std::path::{Path, PathBuf};

use svenja::{Describe, Morphology};

use super::{Outcome, import, print_line};
use crate::{cli::Model, models, progress::notify};

pub(super) fn model(arguments: &Model) -> anyhow::Result<Outcome> {
    match arguments {
        Model::Check { files } => each(files, |file, model| {
            for warning in model.warnings() {
                notify(format_args!("{}: warning: {}", warning.place, warning.message));
            }
            print_line(format_args!(
                "{}: {}, {} bodies, {} actuators: fine",
                file.display(),
                model.name(),
                model.bodies().len(),
                model.actuators().len()
            ))
        }),
        Model::Show { files } => each(files, |_, model| print_line(Describe(model))),
        Model::Import(arguments) => import::import(arguments),
    }
}

/// All files are looked at, whatever is wrong with some.
fn each(
    files: &[PathBuf],
    with: impl Fn(&Path, &Morphology) -> anyhow::Result<()>,
) -> anyhow::Result<Outcome> {
    let mut outcome = Outcome::Done;
    for file in files {
        match models::Model::open(file) {
            Ok(model) => with(file, &model.morphology)?,
            Err(problems) => {
                notify(problems);
                outcome = Outcome::Failed;
            }
        }
    }
    Ok(outcome)
}
