//! `docs/formats.md` against the reader: its keys, its robots, its defaults.
#![allow(clippy::panic, clippy::unwrap_used, missing_docs)]

use std::collections::BTreeSet;

use svenja::Morphology;

const READER: &str = concat!(
    include_str!("../src/file/mod.rs"),
    include_str!("../src/file/body.rs"),
    include_str!("../src/file/joint.rs"),
);

/// The section about model files.
fn section() -> &'static str {
    let page = include_str!("../../../docs/formats.md");
    let (_, section) = page.split_once("\n## Model files\n").unwrap();
    section.split_once("\n## ").map_or(section, |(section, _)| section)
}

/// What stands in fences of a language, in the order of the page.
fn snippets() -> Vec<&'static str> {
    let fences = section().split("```toml\n").skip(1);
    fences.map(|rest| rest.split_once("```").unwrap().0).collect()
}

fn complete_robot() -> &'static str {
    let (_, after) = section().split_once("\n### A complete robot\n").unwrap();
    let robot = snippets()[0];
    assert!(after.contains(robot));
    robot
}

/// All snippets but the complete robot, put together.
fn all_snippets() -> String {
    snippets()[1..].concat()
}

fn parse(text: &str) -> Morphology {
    Morphology::parse("docs/formats.md", text).unwrap_or_else(|problems| panic!("{problems}"))
}

/// Keys that the reader asks for.
fn keys_read() -> BTreeSet<&'static str> {
    let methods = ["required", "optional", "or", "given_or", "table", "required_table", "tables"];
    let mut keys = BTreeSet::new();
    for method in methods.into_iter().chain(["named_tables"]) {
        for call in READER.split(&format!(".{method}(")).skip(1) {
            let key = call.trim_start().strip_prefix('"').and_then(|rest| rest.split_once('"'));
            keys.insert(key.unwrap_or_else(|| panic!("no key in .{method}({call:.40}")).0);
        }
    }
    assert!(keys.len() > 40, "{keys:?}");
    keys
}

/// Keys in the first column of the tables that have one of keys.
fn keys_explained() -> BTreeSet<&'static str> {
    let mut keys = BTreeSet::new();
    let mut of_keys = false;
    for line in section().lines() {
        of_keys = line.starts_with("| key") || of_keys && line.starts_with('|');
        if let Some(rest) = line.strip_prefix("| `").filter(|_| of_keys) {
            keys.insert(rest.split_once('`').unwrap().0);
        }
    }
    keys
}

#[test]
fn every_key_is_explained_and_no_other() {
    let (read, explained) = (keys_read(), keys_explained());
    let missing: Vec<_> = read.difference(&explained).collect();
    assert!(missing.is_empty(), "not in docs/formats.md: {missing:?}");
    let unknown: Vec<_> = explained.difference(&read).collect();
    assert!(unknown.is_empty(), "in docs/formats.md, but never read: {unknown:?}");
}

#[test]
fn every_key_has_an_example() {
    let snippets = all_snippets();
    let has = |form: String| snippets.contains(&form);
    for key in keys_read() {
        let shown = has(format!("{key} = ")) || has(format!("[{key}]]")) || has(format!("[{key}."));
        assert!(shown, "no snippet of docs/formats.md has {key}");
    }
}

#[test]
fn the_complete_robot_is_one() {
    let text = complete_robot();
    let lines = text.lines().filter(|line| !line.is_empty()).count();
    assert!((15..=25).contains(&lines), "{lines} lines");
    assert!(section().contains(&format!("in {lines} lines")), "it has {lines} lines");
    let robot = parse(text);
    assert_eq!((robot.sensors().len(), robot.actuators().len(), robot.contacts().len()), (1, 1, 1));
}

#[test]
fn the_snippets_together_are_a_robot() {
    let text = all_snippets();
    let robot = parse(&text);
    let mut shapes = robot.bodies().iter().flat_map(|body| &body.colliders);
    for kind in ["box", "sphere", "cylinder", "capsule", "ellipsoid", "hull"] {
        assert!(shapes.clone().any(|it| it.shape.name() == kind), "no {kind}");
    }
    assert!(shapes.any(|it| it.pose != nalgebra::Isometry3::identity()));
    for kind in ["fixed", "hinge", "slider-hinge", "spherical", "slider", "general"] {
        assert!(robot.joints().iter().any(|joint| joint.kind.name() == kind), "no {kind} joint");
    }

    // The row of readings.
    let positions = robot.sensors().iter().map(|&id| robot.axis_name(id));
    let contacts = robot.contacts().iter().map(|&body| robot.bodies()[body].name.clone());
    let readings: Vec<_> = positions.chain(contacts).collect();
    assert!(section().contains(&format!("| of | {} |\n", readings.join(" | "))), "{readings:?}");

    // The angles of the last chapter.
    let axis = |name: &str| {
        let id = robot.actuators().iter().find(|&&id| robot.axis_name(id) == name);
        robot.axis(*id.unwrap())
    };
    let degrees = |name: &str, command: f64| axis(name).position_of(command).to_degrees();
    // Roundings of radians.
    let is = |angle: f64, expected: f64| assert!((angle - expected).abs() < 1e-12, "{angle}");
    is(degrees("left shoulder/lift", -1.0), -20.0);
    is(degrees("left shoulder/lift", 0.0), 10.0);
    is(degrees("left shoulder/lift", 1.0), 40.0);
    is(degrees("left shoulder/swing", 1.0), -30.0);
    assert_eq!((axis("weight").position_of(-1.0), axis("weight").position_of(1.0)), (-0.15, 0.15));

    // One that turns on for ever.
    let turn = axis("rail/turn");
    is(degrees("rail/turn", -1.0), -180.0);
    is(turn.value_of(190_f64.to_radians()), turn.value_of(-170_f64.to_radians()));
    is(turn.way(170_f64.to_radians(), -170_f64.to_radians()), 20_f64.to_radians());
}

/// With the same corners in the model's own text no file is read.
#[test]
fn a_model_with_its_meshes_needs_no_files() {
    let folder = tempfile::TempDir::new().unwrap();
    std::fs::create_dir(folder.path().join("meshes")).unwrap();
    let obj = "v -80 -60 0\nv 80 -60 0\nv 0 120 0\nv 0 0 90\nv 0 0 -60\nv 1 2 3\n";
    std::fs::write(folder.path().join("meshes/skull.obj"), obj).unwrap();
    let text = all_snippets().replace("skull.stl", "skull.obj");
    let (start, rest) = text.split_once("[[mesh]]").unwrap();
    let without = format!("{start}{}", &rest[rest.find("[[body]]").unwrap()..]);
    let path = folder.path().join("model.toml");
    let read = Morphology::parse(path.to_str().unwrap(), &without).unwrap();
    let whole = without.clone() + &read.meshes_as_text();
    let copy = parse(&whole);
    assert_eq!(copy.bodies(), read.bodies());
    assert_eq!(copy.bodies(), parse(&text).bodies());
    assert_eq!(copy.meshes_as_text(), "", "it's whole already");
    let said = Morphology::parse("elsewhere.toml", &without).unwrap_err().to_string();
    assert!(said.contains("file must be a mesh: meshes/skull.obj: can't be read: "), "{said}");
}

/// A joint's anchor is of its parent; the page draws children where it puts them.
#[test]
fn the_snippets_fit_together() {
    let robot = parse(&all_snippets());
    let tail = robot.joints().iter().find(|joint| joint.name == "tail").unwrap();
    let body = &robot.bodies()[tail.child];
    let root = body.pose * nalgebra::Point3::new(0.0, 0.2, 0.0);
    // The figures have four decimals.
    assert!((root.coords - tail.frame.translation.vector).norm() < 1e-3, "{root}");
}

#[test]
fn defaults_are_as_stated() {
    let bare = complete_robot();
    let stated = bare
        .replacen(
            "heading",
            "self_collision = false\nlocomotion_scale = 1.0\n\
             touch_distance_m = 0.002\ntouch = []\npenalised = []\nno_collision = []\nsensors = ['nod']\n\
             actuators = ['nod']\nstart = { position_m = [0, 0, 0], rotation_deg = [0, 0, 0] }\n\
             heading",
            1,
        )
        .replace(", axis = [0.0, 1.0, 0.0]", "")
        .replace(
            "mass_kg",
            "friction = 1.0\ncolour = '#8c8c8c'\nrotation_deg = [0.0, 0.0, 0.0]\nmass_kg",
        )
        .replace(
            "anchor_m",
            "frame_deg = [0.0, 0.0, 0.0]\nstop = { erp = 1.0, cfm = 0.0, bounce = 0.0 }\nanchor_m",
        )
        .replace(
            "about = \"x\"",
            "about = \"x\", name = \"x\", reversed = false, stop_margin_deg = 0.0, \
             friction_nm = 0.0, damping_nms_rad = 0.0",
        )
        .replace("[servo.motor]", "[servo.motor]\nkind = 'position'")
        .replace(
            "shape = { ",
            "shape = { position_m = [0.0, 0.0, 0.0], rotation_deg = [0.0, 0.0, 0.0], ",
        );
    assert_eq!(parse(&stated), parse(bare));
}
