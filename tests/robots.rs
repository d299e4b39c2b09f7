//! Robots that differ from their model files: a cell's robot is that of a file in which the keys were
//! changed by hand, wherever the cell is looked at.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use crate::common::*;
use tempfile::TempDir;

/// What is changed by hand in the crawler's file, and by the experiment: a servo's speed, and a body's
/// shape, which is in a list.
const BY_HAND: [(&str, &str); 2] = [
    ("speed_limit_rad_s = 2.5", "speed_limit_rad_s = 1.5"),
    ("[0.2, 0.2, 0.06]", "[0.25, 0.2, 0.05]"),
];
const BY_EXPERIMENT: &str = "\n[sweep.robot]\n\
    servo.motor.speed_limit_rad_s = [2.5, 1.5]\n\
    body.block.shape.half_extents_m = [[0.2, 0.2, 0.06], [0.25, 0.2, 0.05]]\n";

struct Lab(TempDir);

impl Lab {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// The crawler's experiment, shorter and with a plain policy, and its model beside it, each with
    /// changes.
    fn experiment(&self, folder: &str, model: &[(&str, &str)], more: &str) -> PathBuf {
        let folder = self.path(folder);
        fs::create_dir(&folder).unwrap();
        let read = |path: &str| fs::read_to_string(root().join(path)).unwrap();
        let mut text = read("tests/models/crawler.toml");
        for (from, to) in model {
            assert!(text.contains(from), "{from}");
            text = text.replace(from, to);
        }
        fs::write(folder.join("crawler.toml"), text).unwrap();
        let text = read(CRAWLER)
            .replace("../models/crawler.toml", "crawler.toml")
            .replace("hidden_units = 4\nsamples = 8", "kind = 'logistic'")
            .replace("updates = 30", "updates = 8");
        let file = folder.join("x.toml");
        fs::write(&file, text + more).unwrap();
        file
    }
}

/// Of the cells of a setting what they learned, but for the checkpoint, which knows its cell.
fn learned(run: &Path, setting: &str) -> BTreeMap<String, Vec<u8>> {
    let mut files = tree(&run.join("cells").join(setting));
    files.retain(|name, _| {
        ["metrics.csv", "policy.safetensors"].iter().any(|it| name.ends_with(it))
    });
    assert_eq!(files.len(), 4, "{:?}", files.keys());
    files
}

/// The cell of a setting that is looked at.
fn cell(run: &Path, setting: &str) -> PathBuf {
    run.join("cells").join(setting).join("seed=2")
}

fn rollout(cell: &Path) -> String {
    itarl(&["rollout", text(cell), "--steps", "20"]).ends(DONE).out
}

/// The robot from three sides, as replays and reports have it.
fn picture(lab: &Lab, cell: &Path) -> Vec<u8> {
    let picture = lab.path("robot.png");
    itarl(&["replay", text(cell), "--png", text(&picture)]).ends(DONE);
    fs::read(picture).unwrap()
}

/// Information is of positions, which neither has.
#[test]
fn a_robot_without_sensors_can_be_rolled_out() {
    let folder = tempfile::tempdir().unwrap();
    let ball = folder.path().join("ball.toml");
    let text_of_ball = "name = 'Ball'\nstart = { position_m = [0.0, 0.0, 0.5] }\nlocomotion_scale = 1.0\n\
        heading = { body = 'ball', axis = [0.0, 1.0, 0.0] }\n\
        [[body]]\nname = 'ball'\nmass_kg = 1.0\nshape = { kind = 'sphere', radius_m = 0.1 }\n";
    fs::write(&ball, text_of_ball).unwrap();
    let blind = folder.path().join("blind.toml");
    let worm = fs::read_to_string(root().join("models/worm.toml")).unwrap();
    fs::write(&blind, worm.replacen("name =", "sensors = []\nname =", 1)).unwrap();
    for model in [&ball, &blind] {
        for policy in ["neutral", "random"] {
            let words = ["rollout", text(model), "--policy", policy, "--steps", "20"];
            let said =
                itarl(&words).ends(DONE).prints(&["20 control steps", "speed along heading"]);
            assert!(!said.out.contains("information"), "{said:?}");
        }
        let page = folder.path().join("page.html");
        itarl(&["replay", text(model), "--html", text(&page), "--steps", "20"]).ends(DONE);
    }
}

#[test]
fn a_changed_robot_is_that_of_a_changed_file() {
    let lab = Lab::new();
    let swept = lab.experiment("swept", &[], BY_EXPERIMENT);
    let run = lab.path("run");
    // In pieces, in lanes beside each other, and extended.
    itarl(&["train", text(&swept), "--out", text(&run), "--stop-after", "3"]).ends(STOPPED);
    fs::remove_dir_all(swept.parent().unwrap()).unwrap();
    itarl(&["resume", text(&run), "--threads", "1"]).ends(DONE);
    itarl(&["resume", text(&run), "--updates", "12"]).ends(DONE);
    for (name, by_hand, values) in [
        ("old", &[][..], "speed_limit_rad_s=2.5,half_extents_m=0.2-0.2-0.06"),
        ("new", &BY_HAND, "speed_limit_rad_s=1.5,half_extents_m=0.25-0.2-0.05"),
        ("slow", &BY_HAND[..1], "speed_limit_rad_s=1.5,half_extents_m=0.2-0.2-0.06"),
    ] {
        let changed = lab.experiment(name, by_hand, "");
        let alone = lab.path(&format!("{name} run"));
        itarl(&["train", text(&changed), "--set", "learning.updates=12", "--out", text(&alone)])
            .ends(DONE);
        for xi in ["xi=0.75", "xi=1"] {
            let setting = format!("{xi},{values}");
            assert_same(&learned(&run, &setting), &learned(&alone, xi));
            assert_eq!(rollout(&cell(&run, &setting)), rollout(&cell(&alone, xi)), "{setting}");
        }
        if name == "new" {
            let changed = cell(&run, &format!("xi=1,{values}"));
            assert_eq!(picture(&lab, &changed), picture(&lab, &cell(&alone, "xi=1")));
        }
    }
    // One copy of the file is enough: the experiment has the changes.
    assert_eq!(tree(&run.join("models")).len(), 1);
}

/// Corners of a box, as an OBJ file.
fn mesh(path: &Path, [x, y, z]: [f64; 3]) {
    let signs = (0..8).map(|i| [0, 1, 2].map(|bit| f64::from((i >> bit & 1) * 2 - 1)));
    let line = |[a, b, c]: [f64; 3]| format!("v {} {} {}\n", a * x, b * y, c * z);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, signs.map(line).collect::<String>()).unwrap();
}

/// Those that the model file names, and those that the experiment names in their place.
#[test]
fn a_run_has_the_meshes_of_all_its_robots() {
    const BOX: &str = "kind = \"box\", half_extents_m = [0.2, 0.2, 0.06]";
    let lab = Lab::new();
    let experiment = |folder: &str, file: &str, more: &str| {
        let hull = format!("kind = \"hull\", file = \"{file}\"");
        let experiment = lab.experiment(folder, &[(BOX, &hull)], more);
        let folder = experiment.parent().unwrap();
        mesh(&folder.join("flat.obj"), [0.2, 0.2, 0.06]);
        mesh(&folder.join("meshes/narrow.obj"), [0.12, 0.25, 0.06]);
        experiment
    };
    let sweep = "[sweep.robot]\nbody.block.shape.file = ['flat.obj', 'meshes/narrow.obj']\n";
    for (name, in_the_model) in [("one", "flat.obj"), ("none", "nowhere.obj")] {
        let swept = experiment(name, in_the_model, sweep);
        let (begun, run) = (lab.path("begun"), lab.path(&format!("{name} run")));
        itarl(&["train", text(&swept), "--out", text(&begun), "--stop-after", "3"]).ends(STOPPED);
        fs::remove_dir_all(swept.parent().unwrap()).unwrap();
        fs::rename(&begun, &run).unwrap();
        itarl(&["resume", text(&run)]).ends(DONE);
        let published = lab.path(&format!("{name} published"));
        itarl(&["publish", text(&run), "--out", text(&published)]).ends(DONE);
    }
    for (file, value) in [("flat.obj", "flat.obj"), ("meshes/narrow.obj", "meshes-narrow.obj")] {
        let (alone, setting) = (lab.path(&format!("{value} run")), format!("xi=1,file={value}"));
        let by_hand = experiment(value, file, "");
        itarl(&["train", text(&by_hand), "--out", text(&alone)]).ends(DONE);
        let by_hand = cell(&alone, "xi=1");
        for run in ["one run", "none run"].map(|name| lab.path(name)) {
            let swept = cell(&run, &setting);
            assert_same(&learned(&run, &setting), &learned(&alone, "xi=1"));
            assert_eq!(rollout(&swept), rollout(&by_hand), "{setting}");
            assert_eq!(picture(&lab, &swept), picture(&lab, &by_hand), "{setting}");
        }
        for published in ["one published", "none published"].map(|name| lab.path(name)) {
            assert_eq!(picture(&lab, &cell(&published, &setting)), picture(&lab, &by_hand));
        }
    }
}

#[test]
fn a_key_is_changed_on_the_command_line_and_is_part_of_a_run() {
    let lab = Lab::new();
    let file = lab.experiment("x", &[], "");
    let run = lab.path("run");
    let train = |set: &str| {
        let words = ["train", text(&file), "--out", text(&run), "--stop-after", "1", "--set", set];
        itarl(&words)
    };
    train("robot.body.upper arm.mass_kg=0.4").ends(STOPPED);
    let text = fs::read_to_string(run.join("experiment.toml")).unwrap();
    assert!(text.contains("[robot.body.\"upper arm\"]\nmass_kg = 0.4\n"), "{text}");
    let difference = "robot.body.upper arm.mass_kg: 0.4 there, 0.5 here";
    train("robot.body.upper arm.mass_kg=0.5").ends(FAILED).complains(&[difference]);
}

/// By the model's rules, with the experiment's places.
#[test]
fn mistakes_are_those_of_a_model_at_the_place_of_the_change() {
    let lab = Lab::new();
    let more = "'robot.servo.motor.speed_limit_rad_s' = [1, -1, 'fast']\n\
                [robot]\nservo.motor.speed = 3\nbody.blok.mass_kg = 3\n";
    let file = lab.experiment("x", &[], more);
    let name = text(&file);
    let list = |words: &[&str]| itarl(&[&["train", name, "--list"], words].concat()).ends(FAILED);
    list(&[]).complains(&[&format!(
        "{name}:30:11: body.blok.mass_kg lies within a list in which nothing is called 'blok', did \
             you mean 'block'?"
    )]);
    fs::write(&file, fs::read_to_string(&file).unwrap().replace("body.blok", "body.block"))
        .unwrap();
    list(&[]).complains(&[
        &format!("{name}:27:45: servo 'motor': speed_limit_rad_s must be a number above 0, up to 1e9, got -1"),
        &format!("{name}:27:49: servo 'motor': speed_limit_rad_s must be a number above 0, up to 1e9, got \"fast\""),
        &format!("{name}:29:13: servo 'motor': unknown key 'speed', did you mean 'speed_limit_rad_s'?"),
    ]);
    // Names are looked up where all values fit.
    let file = lab.experiment("fine", &[], "");
    for (set, why) in [
        ("robot.feet=['hand']", "'hand'"),
        ("robot=3", "robot must be a table of the model file's keys, got 3"),
    ] {
        let words = ["train", text(&file), "--list", "--set", set];
        itarl(&words).ends(FAILED).complains(&[&format!("--set {set}: "), why]);
    }
}
