//! Imports against what MuJoCo makes of MJCF files, and PyBullet of URDF files.
//!
//! They are compared where they are installed: `make import-oracles` does that. More files than those
//! in the repository are compared if `IMPORT_MORE` names a folder of them.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

use std::{
    env, fs,
    path::{Path, PathBuf},
    process::Command,
};

use formats::{Motion, Options, Robot};
use nalgebra::{Point3, Vector3};

/// Relative, of masses and moments; PyBullet keeps nothing more exactly.
const SHARE: f64 = 1e-6;
/// In m, and of directions.
const NEAR: f64 = 1e-6;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

fn python() -> Option<PathBuf> {
    let python = root().join("target/oracles/bin/python");
    env::var_os("ORACLES").map(PathBuf::from).or(Some(python)).filter(|it| it.is_file())
}

fn files(ending: &str) -> Vec<PathBuf> {
    let folders =
        [Some(root().join("tests/robots")), env::var_os("IMPORT_MORE").map(PathBuf::from)];
    let mut files = Vec::new();
    let mut waiting: Vec<PathBuf> = folders.into_iter().flatten().collect();
    while let Some(folder) = waiting.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                waiting.push(path);
            } else if path.extension().is_some_and(|it| it == ending) {
                files.push(path);
            }
        }
    }
    files.sort();
    files
}

#[derive(Debug)]
struct Body {
    name: String,
    mass: f64,
    centre: Point3<f64>,
    moments: Vector3<f64>,
    frame: Point3<f64>,
}

#[derive(Debug)]
struct Axis {
    child: String,
    kind: String,
    direction: Vector3<f64>,
    anchor: Point3<f64>,
    limits: Option<[f64; 2]>,
}

/// What an oracle says of a file; `None` if it can't read it.
fn oracle(which: &str, file: &Path) -> Option<(Vec<Body>, Vec<Axis>)> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/oracle.py");
    let said = Command::new(python()?).arg(script).arg(which).arg(file).output().unwrap();
    if !said.status.success() {
        return None;
    }
    let (mut bodies, mut axes) = (Vec::new(), Vec::new());
    for line in String::from_utf8(said.stdout).unwrap().lines() {
        let fields: Vec<&str> = line.split('\t').collect();
        let number = |i: usize| fields[i].parse::<f64>().unwrap();
        let three = |i: usize| [number(i), number(i + 1), number(i + 2)];
        match fields[0] {
            "body" => bodies.push(Body {
                name: fields[1].into(),
                mass: number(2),
                centre: three(3).into(),
                moments: three(6).into(),
                frame: three(9).into(),
            }),
            "axis" => axes.push(Axis {
                child: fields[1].into(),
                kind: fields[2].into(),
                direction: three(3).into(),
                anchor: three(6).into(),
                limits: (fields[9] != "-").then(|| [number(9), number(10)]),
            }),
            _ => {}
        }
    }
    Some((bodies, axes))
}

fn alike(a: f64, b: f64) -> bool {
    (a - b).abs() <= SHARE * a.abs().max(b.abs())
}

/// All that differs.
fn differences(robot: &Robot, bodies: &[Body], axes: &[Axis]) -> Vec<String> {
    let mut found = Vec::new();
    // A body without a name has one here.
    let named = |theirs: &str, own: &str| theirs == own || theirs.is_empty();
    for link in &robot.links {
        let Some(inertial) = link.inertial else { continue };
        let centre = link.pose * inertial.centre_m;
        let mut moments: Vec<f64> = inertial.principal().0.iter().copied().collect();
        moments.sort_by(f64::total_cmp);
        let frame = Point3::from(link.pose.translation.vector);
        let of_name = bodies.iter().filter(|body| named(&body.name, &link.name));
        let Some(body) = of_name
            .min_by(|a, b| (a.centre - centre).norm().total_cmp(&(b.centre - centre).norm()))
        else {
            found.push(format!("no body {}", link.name));
            continue;
        };
        // PyBullet gives moments that no body has up for others.
        let possible = moments[0] > 0.0 && moments[2] <= moments[0] + moments[1];
        let same_moments = (0..3).all(|i| alike(moments[i], body.moments[i]));
        if !alike(inertial.mass_kg, body.mass)
            || (centre - body.centre).norm() > NEAR
            || (frame - body.frame).norm() > NEAR
            || (possible && !same_moments)
        {
            let own = (inertial.mass_kg, centre, &moments, frame);
            found.push(format!("body {}: {own:?}, not {body:?}", link.name));
        }
    }
    let mut count = 0;
    for joint in &robot.joints {
        let child = &robot.links[joint.child].name;
        for axis in &joint.axes {
            count += 1;
            let kind = if axis.motion == Motion::Turns { "turns" } else { "slides" };
            let is_same = |other: &&Axis| {
                let apart = (axis.anchor_m - other.anchor).cross(&other.direction).norm();
                let limits = match (axis.range, other.limits) {
                    (None, None) => true,
                    (Some(own), Some(theirs)) => (0..2).all(|i| (own[i] - theirs[i]).abs() < NEAR),
                    _ => false,
                };
                named(&other.child, child)
                    && other.kind == kind
                    && (axis.direction.into_inner() - other.direction).norm() < NEAR
                    && (kind == "slides" || apart < NEAR)
                    && limits
            };
            if !axes.iter().any(|other| is_same(&other)) {
                let of_child: Vec<_> = axes.iter().filter(|it| named(&it.child, child)).collect();
                found.push(format!("axis of {}: {axis:?}, not one of {of_child:?}", joint.name));
            }
        }
    }
    if count > axes.len() {
        found.push(format!("{count} axes, not {}", axes.len()));
    }
    found
}

fn compare(which: &str, ending: &str) {
    if python().is_none() {
        println!("{which} isn't installed: make import-oracles");
        return;
    }
    let (mut wrong, mut compared) = (Vec::new(), 0);
    for file in files(ending) {
        let name = file.display();
        let Ok(imported) = formats::import(&file, &Options::default()) else {
            println!("{name}: isn't imported");
            continue;
        };
        let Some((bodies, axes)) = oracle(which, &file) else {
            println!("{name}: {which} can't read it");
            continue;
        };
        compared += 1;
        let robot = &imported.written;
        let mut moved = robot.clone();
        moved.links[0].pose.translation.vector.x += 1e-3;
        let sees =
            moved.links[0].inertial.is_none() || !differences(&moved, &bodies, &axes).is_empty();
        assert!(sees, "{name}: a millimetre isn't seen");
        let mut found = differences(robot, &bodies, &axes);
        let whole =
            imported.report.left_out.iter().all(|it| !it.element.starts_with("a body that"));
        if whole {
            let weighing = robot.links.iter().filter(|it| it.inertial.is_some()).count();
            let theirs: Vec<_> = bodies
                .iter()
                .filter(|body| {
                    robot.links.iter().any(|it| {
                        it.inertial.is_some() && (it.name == body.name || body.name.is_empty())
                    })
                })
                .collect();
            let total: f64 = theirs.iter().map(|body| body.mass).sum();
            if weighing != theirs.len() || !alike(robot.mass_kg(), total) {
                found.push(format!("{} kg, not {total}", robot.mass_kg()));
            }
        }
        wrong.extend(found.into_iter().map(|it| format!("{name}: {it}")));
    }
    println!("{compared} files compared with {which}");
    assert!(compared > 0, "no file was compared");
    assert!(wrong.is_empty(), "{} differences:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn mjcf_is_what_mujoco_makes_of_it() {
    compare("mujoco", "xml");
}

#[test]
fn urdf_is_what_pybullet_makes_of_it() {
    compare("pybullet", "urdf");
}
