//! `itarl model`: checks and shows model files.

use std::path::{Path, PathBuf};

use svenja::{Describe, Morphology};

use super::{Outcome, print_line};
use crate::{cli::Model, progress::notify};

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
    }
}

/// All files are looked at, whatever is wrong with some.
fn each(
    files: &[PathBuf],
    with: impl Fn(&Path, &Morphology) -> anyhow::Result<()>,
) -> anyhow::Result<Outcome> {
    let mut outcome = Outcome::Done;
    for file in files {
        match Morphology::open(file) {
            Ok(model) => with(file, &model)?,
            Err(problems) => {
                notify(problems);
                outcome = Outcome::Failed;
            }
        }
    }
    Ok(outcome)
}
