//! A robot with all that a model file can have, from its mesh to its film.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use crate::common::*;
use tempfile::TempDir;

/// Four corners of a mesh, and a point within.
const SKULL: &str = "v -80 -60 0\nv 80 -60 0\nv 0 120 0\nv 0 0 90\nv 10 10 10\nf 1 2 3\n";

/// The robot of the snippets in docs/formats.md, but with its mesh in a file.
fn robot(folder: &Path) -> PathBuf {
    let page = fs::read_to_string(root().join("docs/formats.md")).unwrap();
    let snippets = page.split("```toml\n").skip(2).map(|rest| rest.split_once("```").unwrap().0);
    let text = snippets.collect::<String>().replace("skull.stl", "skull.obj");
    let (before, rest) = text.split_once("[[mesh]]").unwrap();
    let (_, after) = rest.split_once("[[body]]").unwrap();
    fs::create_dir_all(folder.join("meshes")).unwrap();
    fs::write(folder.join("meshes/skull.obj"), SKULL).unwrap();
    let path = folder.join("robot.toml");
    fs::write(&path, format!("{before}[[body]]{after}")).unwrap();
    path
}

fn trained(model: &Path, run: &Path, more: &[&str]) -> BTreeMap<String, Vec<u8>> {
    let model = format!("model={:?}", text(model));
    let words = ["--set", &model, "--set", "learning.updates=3"];
    let _ = train(run, &[&words, more].concat()).ends(DONE);
    results(run)
}

fn folders() -> (TempDir, PathBuf, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let (models, run) = (folder.path().join("models"), folder.path().join("run"));
    (folder, robot(&models), run)
}

#[test]
fn it_learns_in_lanes_what_it_learns_by_bullet_alone() {
    let (folder, model, run) = folders();
    let one = trained(&model, &run, &["--threads", "1"]);
    for (name, how) in [("bullet", ["--solver", "bullet"]), ("lanes", ["--lanes", "3"])] {
        assert_same(&one, &trained(&model, &folder.path().join(name), &how));
    }
    // Stopped, and without the files that it was begun with.
    let run = folder.path().join("in two");
    let words = format!("model={:?}", text(&model));
    let words = ["--set", &words, "--set", "learning.updates=3", "--stop-after", "1"];
    train(&run, &words).ends(STOPPED);
    fs::remove_dir_all(model.parent().unwrap()).unwrap();
    itarl(&["resume", text(&run)]).ends(DONE);
    assert_same(&one, &results(&run));
}

#[test]
fn it_is_checked_and_shown_in_all_ways_without_its_files() {
    let (folder, model, run) = folders();
    itarl(&["model", "check", text(&model)]).ends(DONE).prints(&["8 bodies, 9 actuators: fine"]);
    itarl(&["model", "show", text(&model)]).ends(DONE).prints(&[
        "| hull of 4 points; ellipsoid, radii (0.02, 0.04, 0.02); sphere, radius 0.03 |",
        "| general      | world           | trunk           | turn (z)  |",
        "never collide: 'trunk' and 'left hand', 'trunk' and 'right hand'",
        "(speed)",
    ]);
    trained(&model, &run, &[]);
    fs::remove_dir_all(model.parent().unwrap()).unwrap();
    let cell = run.join("cells/xi=1/seed=2");
    for end in ["html", "glb", "gif", "png"] {
        let path = folder.path().join(format!("film.{end}"));
        let to = format!("--{end}");
        let words = ["replay", text(&cell), "--size", "48x32", "--seconds", "1"];
        itarl(&[&words[..], &[&to, text(&path)]].concat()).ends(DONE);
        assert!(fs::metadata(&path).unwrap().len() > 500);
    }
    itarl(&["rollout", text(&cell)]).ends(DONE);
    itarl(&["report", text(&run)]).ends(DONE);
    // A copy is a model like any other.
    itarl(&["model", "check", text(&run.join("models/robot.toml"))]).ends(DONE);
    let sheet = folder.path().join("sheet.png");
    itarl(&["replay", text(&run.join("models/robot.toml")), "--png", text(&sheet)]).ends(DONE);
}
