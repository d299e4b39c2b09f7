//! Robots in other formats, from their files to training.

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::common::{CRAWLER, DONE, FAILED, itarl, root, text};

/// All robots by others in the repository.
fn robots() -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut waiting = vec![root().join("tests/robots")];
    while let Some(folder) = waiting.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                waiting.push(path);
            } else if path.extension().is_some_and(|it| it != "md") {
                files.push(path);
            }
        }
    }
    files.sort();
    assert!(files.len() > 10, "{files:?}");
    files
}

#[test]
fn each_robot_is_imported_checked_and_lives_for_twenty_seconds() {
    let folder = tempfile::tempdir().unwrap();
    for robot in robots() {
        let out = folder.path().join(robot.file_stem().unwrap()).with_extension("toml");
        let said = itarl(&["model", "import", text(&robot), "-o", text(&out)]).ends(DONE);
        said.prints(&["carried over", "bodies", "written"]);
        let model = fs::read_to_string(&out).unwrap();
        let again = itarl(&["model", "import", text(&robot), "-o", text(&out)]).ends(DONE);
        assert!(again.err.lines().all(|line| line.contains("warning")), "{again:?}");
        assert_eq!(fs::read_to_string(&out).unwrap(), model, "the same file, the same text");
        itarl(&["model", "check", text(&out)]).ends(DONE);
        itarl(&["rollout", text(&out), "--policy", "neutral", "--steps", "200"]).ends(DONE);
    }
}

/// Of a file, and of an experiment that changes it.
#[test]
fn every_command_takes_a_robot_in_another_format() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let (go2, experiment) =
        (root().join("tests/robots/unitree/go2.urdf"), root().join("experiments/go2.toml"));
    let (go2, experiment) = (text(&go2), text(&experiment));
    let (png, glb) = (at("go2.png"), at("go2.glb"));
    for words in [
        &["model", "check", go2][..],
        &["model", "show", go2],
        &["rollout", go2, "--steps", "2"],
        &["replay", go2, "--png", text(&png)],
        &["replay", go2, "--steps", "2", "--glb", text(&glb)],
        &["config", experiment],
        &["train", experiment, "--list"],
        &["slurm", experiment, "--out", text(&at("run"))],
    ] {
        itarl(words).ends(DONE);
    }
    assert!(png.is_file() && glb.is_file());
}

#[test]
fn an_experiment_takes_a_robot_in_another_format() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::copy(root().join("tests/robots/gymnasium/ant.xml"), at("ant.xml")).unwrap();
    let write = |name: &str, model: &str| {
        let settings = "[learning]\nupdates = 3\nsteps_per_update = 10\n[sweep]\nseeds = 2\n";
        fs::write(at(name), format!("model = \"{model}\"\n{settings}")).unwrap();
    };
    write("direct.toml", "ant.xml");
    write("imported.toml", "ant.toml");
    itarl(&["model", "import", text(&at("ant.xml")), "-o", text(&at("ant.toml"))]).ends(DONE);
    for name in ["direct", "imported"] {
        let file = at(&format!("{name}.toml"));
        itarl(&["train", text(&file), "--out", text(&at(name)), "--stop-after", "2"]);
        // The run needs the robot's own file no more.
        fs::rename(at("ant.xml"), at("away.xml")).unwrap();
        itarl(&["resume", text(&at(name))]).ends(DONE);
        fs::rename(at("away.xml"), at("ant.xml")).unwrap();
    }
    let read = |run: &str, file: &str| fs::read(at(run).join(file)).unwrap();
    let model = String::from_utf8(read("direct", "models/ant.toml")).unwrap();
    assert!(
        model.starts_with("# Imported from ant.xml (MJCF) by `itarl model import`."),
        "{model}"
    );
    for row in ["# carried over", "#   joint/armature", "# chosen"] {
        assert!(model.contains(row), "{row} isn't in {model}");
    }
    assert_eq!(read("direct", "models/ant.toml"), read("imported", "models/ant.toml"));
    let metrics = "cells/base/seed=1/metrics.csv";
    assert_eq!(read("direct", metrics), read("imported", metrics));
}

/// Lanes and Bullet's own solver, with imported robots.
#[test]
fn imported_robots_train_in_lanes_with_the_bits_of_bullet() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    for robot in ["gymnasium/ant.xml", "gymnasium/half_cheetah.xml", "unitree/go2.urdf"] {
        let set = format!("model='{}'", text(&root().join("tests/robots").join(robot)));
        let name = Path::new(robot).file_stem().unwrap().to_str().unwrap();
        let mut metrics = Vec::new();
        for solver in ["lockstep", "bullet"] {
            let run = at(&format!("{name}-{solver}"));
            let words = ["--set", "learning.updates=3", "--set", "learning.steps_per_update=10"];
            let base = ["train", CRAWLER, "--out", text(&run), "--set", &set, "--solver", solver];
            itarl(&[&base[..], &words].concat()).ends(DONE);
            let mut files = Vec::new();
            for seed in fs::read_dir(run.join("cells")).unwrap() {
                for cell in fs::read_dir(seed.unwrap().path()).unwrap() {
                    files.push(fs::read(cell.unwrap().path().join("metrics.csv")).unwrap());
                }
            }
            files.sort();
            metrics.push(files);
        }
        assert!(!metrics[0].is_empty() && metrics[0] == metrics[1], "{robot}");
    }
}

#[test]
fn strict_imports_fail_where_something_is_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let plain = "<mujoco><worldbody><body name=\"a\"><freejoint/><geom size=\"0.1\"/></body></worldbody>\
                 </mujoco>";
    fs::write(at("plain.xml"), plain).unwrap();
    let plain = at("plain.xml");
    let import = ["model", "import", text(&plain), "--strict", "-o"];
    itarl(&[&import[..], &[text(&at("plain.toml"))]].concat()).ends(DONE);
    let ant = root().join("tests/robots/gymnasium/ant.xml");
    let import = ["model", "import", text(&ant), "--strict", "-o"];
    let said = itarl(&[&import[..], &[text(&at("ant.toml"))]].concat()).ends(FAILED);
    said.complains(&["--strict: not everything was carried over"]).prints(&["joint/armature"]);
    assert!(at("ant.toml").is_file(), "it's written all the same");
}

#[test]
fn a_model_file_that_was_worked_on_is_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("ant.toml");
    let ant = root().join("tests/robots/gymnasium/ant.xml");
    let import = ["model", "import", text(&ant), "-o", text(&out)];
    itarl(&import).ends(DONE);
    let mine = fs::read_to_string(&out).unwrap() + "# mine\n";
    fs::write(&out, &mine).unwrap();
    itarl(&import).ends(FAILED).complains(&["there is another file of this name"]);
    assert_eq!(fs::read_to_string(&out).unwrap(), mine);
}

#[test]
fn meshes_are_copied_beside_the_model_or_kept_in_it() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir_all(at("pkg/meshes")).unwrap();
    let corners = "v 0 0 0\nv 200 0 0\nv 0 200 0\nv 0 0 200\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    fs::write(at("pkg/meshes/a.obj"), corners).unwrap();
    let robot = "<robot name=\"r\"><link name=\"a\"><inertial><mass value=\"1\"/>\
        <inertia ixx=\"0.01\" iyy=\"0.01\" izz=\"0.01\"/></inertial><collision><geometry>\
        <mesh filename=\"package://pkg/meshes/a.obj\" scale=\"0.001 0.001 0.001\"/>\
        </geometry></collision></link><link name=\"b\"><inertial><mass value=\"1\"/>\
        <inertia ixx=\"0.01\" iyy=\"0.01\" izz=\"0.01\"/></inertial></link>\
        <joint name=\"j\" type=\"continuous\"><parent link=\"a\"/><child link=\"b\"/></joint></robot>";
    fs::write(at("r.urdf"), robot).unwrap();
    let (file, out) = (at("r.urdf"), at("out/b.toml"));
    fs::create_dir(at("out")).unwrap();
    itarl(&["model", "import", text(&file), "-o", text(&out)]).ends(DONE).prints(&["1 mesh files"]);
    assert!(fs::read_to_string(&out).unwrap().contains("file = \"b-meshes/a.obj\""));
    assert_eq!(fs::read(at("out/b-meshes/a.obj")).unwrap(), corners.as_bytes());
    itarl(&["rollout", text(&out), "--steps", "5"]).ends(DONE);
    itarl(&["rollout", text(&file), "--steps", "5"]).ends(DONE);
    fs::remove_file(at("pkg/meshes/a.obj")).unwrap();
    let named = at("c.toml");
    let said = itarl(&["model", "import", text(&file), "-o", text(&named), "--package", "pkg=pkg"]);
    said.ends(DONE).prints(&["mesh package://pkg/meshes/a.obj", "a box with its inertia"]);
}
