//! The robots of experiments and of runs: models found and read, in whatever format they are, with what
//! an experiment changes of them; and a run's copies of them.

use std::path::Path;

use anyhow::Context;
use config::{Document, Problems};
use formats::{Imported, Options};
use runs::Run;
use svenja::Morphology;
use toml::{Table, Value};

use crate::experiment::{Experiment, RobotSettings, absolute};

/// The text of a model file, or what a robot in another format is imported as.
///
/// # Errors
/// A file that can't be read, or imported.
fn text(path: &Path) -> Result<String, Problems> {
    if formats::is_foreign(path) {
        let Imported { text, .. } = formats::import(path, &Options::default())?;
        return Ok(text);
    }
    config::read_text(path)
}

/// A model as its file has it.
///
/// # Errors
/// All that is wrong with it.
pub(crate) fn open_model(path: &Path) -> Result<Morphology, Problems> {
    Morphology::parse(&path.display().to_string(), &text(path)?)
}

/// The text of an experiment with a robot and the paper's settings, but for information where there are
/// no sensors to have any.
pub(crate) fn defaults(path: &Path, robot: &Morphology) -> String {
    let mut text = format!("model = {}", Value::String(absolute(path)));
    if robot.sensors().is_empty() {
        text += "\nreward = { intrinsic.kind = \"none\", mix.xi = 1 }";
    }
    text
}

/// The text of a model's copy, which needs no other files: it has what all robots that are made of it
/// take from meshes.
///
/// # Errors
/// All that is wrong with the robots.
pub(crate) fn copied(path: &Path, robots: &[&RobotSettings]) -> Result<String, Problems> {
    let (mut whole, mut problems) = (text(path)?, Vec::new());
    for robot in robots {
        match changed(path, &whole, robot) {
            // Without those that it has by then.
            Ok(robot) => whole = with(&whole, &robot.meshes_as_text()),
            Err(found) => problems.extend(Vec::from(found)),
        }
    }
    if problems.is_empty() { Ok(whole) } else { Err(Problems::new(problems)) }
}

/// A model's text with more meshes. Nothing can be put behind a list that's written in brackets,
/// `mesh = [...]`: a file with such a one is written anew.
fn with(text: &str, meshes: &str) -> String {
    const LIST: &str = "mesh";
    let both = format!("{text}{meshes}");
    let (Ok(mut model), Ok(mut more)) = (text.parse::<Table>(), meshes.parse::<Table>()) else {
        return both;
    };
    match (model.get_mut(LIST), more.get_mut(LIST)) {
        (Some(Value::Array(list)), Some(Value::Array(more))) if both.parse::<Table>().is_err() => {
            list.append(more);
            model.to_string()
        }
        _ => both,
    }
}

/// The robot of an experiment.
///
/// # Errors
/// All that is wrong with its file, or with what the experiment changes of it.
pub fn open(experiment: &Experiment) -> Result<Morphology, Problems> {
    let path = Path::new(&experiment.model);
    changed(path, &text(path)?, &experiment.robot)
}

/// What tells an experiment's robot from others.
pub(crate) fn key(experiment: &Experiment) -> (String, String) {
    (experiment.model.clone(), experiment.robot.to_table().to_string())
}

/// Where a run's copies of model files are, in the order of the manifest, as experiments name them.
pub(crate) fn paths(run: &Run) -> Vec<String> {
    run.manifest().models.iter().map(|model| absolute(&run.model_path(&model.file))).collect()
}

/// The robot of a copy.
///
/// # Errors
/// A copy that isn't what the run was made with.
pub(crate) fn read(run: &Run, index: usize, robot: &RobotSettings) -> anyhow::Result<Morphology> {
    let model = run.manifest().models.get(index).context("no such model in manifest.json")?;
    Ok(changed(&run.model_path(&model.file), &run.model(model)?, robot)?)
}

fn changed(path: &Path, text: &str, robot: &RobotSettings) -> Result<Morphology, Problems> {
    let mut model = Document::parse(&path.display().to_string(), text)?;
    robot.change(&mut model)?;
    Morphology::read(&model, path)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    const CORNERS: &str = "[[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]";

    /// Two meshes in files beside one that's in the text, which may be written in brackets, as a table
    /// of its own, or not be there.
    #[test]
    fn a_copy_needs_no_other_files_however_its_meshes_are_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("model.toml");
        let corners = "v 0 0 0\nv 2 0 0\nv 0 2 0\nv 0 0 2\n";
        for name in ["a.obj", "b.obj"] {
            fs::write(folder.path().join(name), corners).unwrap();
        }
        let mesh = format!("file = \"own.obj\", points = {CORNERS}");
        let table = format!("[[mesh]]\n{}\n", mesh.replace(", points", "\npoints"));
        let head = |mesh: &str| {
            format!("name = \"m\" # mine\n{mesh}heading = {{ body = \"b\", axis = [0, 1, 0] }}\n")
        };
        let body = |files: &[&str]| {
            let hulls =
                files.iter().map(|file| format!("{{ kind = \"hull\", file = \"{file}\" }}"));
            let hulls = hulls.collect::<Vec<_>>().join(", ");
            format!(
                "[[body]]\nname = \"b\"\nmass_kg = 1\nposition_m = [0, 0, 0]\nshapes = [{hulls}]\n"
            )
        };
        let all = body(&["a.obj", "own.obj", "b.obj"]);
        let texts = [
            head("") + &body(&["a.obj", "b.obj"]),
            head("") + &all + &table,
            head("") + &table + &all,
            head(&format!("mesh = [{{ {mesh} }}]\n")) + &all,
            head("mesh = []\n") + &body(&["a.obj", "b.obj"]),
        ];
        for text in texts {
            fs::write(&path, &text).unwrap();
            let original = open_model(&path).unwrap();
            let copy = copied(&path, &[&RobotSettings::default()]).unwrap();
            let elsewhere = Morphology::parse("elsewhere/model.toml", &copy).unwrap();
            assert_eq!(elsewhere.bodies(), original.bodies(), "{copy}");
            assert_eq!(elsewhere.meshes_as_text(), "");
        }
    }
}
