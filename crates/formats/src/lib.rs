//! Robots from other formats: URDF, MJCF, SDF and RoSiML read, and written as a model file.
//!
//! [`import`] tells a file's format by its root element, and gives the text of a model file that a
//! person can read on, the meshes to copy beside it, and a [`Report`]: what was carried over, what was
//! left out, what was chosen.
//!
//! ```
//! let folder = tempfile::tempdir()?;
//! let file = folder.path().join("stick.urdf");
//! std::fs::write(&file, r#"<robot name="stick">
//!   <link name="rod">
//!     <inertial>
//!       <mass value="2"/>
//!       <inertia ixx="0.1" iyy="0.1" izz="0.01" ixy="0" ixz="0" iyz="0"/>
//!     </inertial>
//!     <collision><geometry><cylinder radius="0.1" length="0.7"/></geometry></collision>
//!   </link>
//! </robot>"#)?;
//! let imported = formats::import(&file, &formats::Options::default())?;
//! assert!(imported.text.contains("inertia_kg_m2 = [0.1, 0.1, 0.01]"));
//! assert!(imported.text.contains("start = { position_m = [0.0, 0.0, 0.35] }"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | file | what |
//! |---|---|
//! | `xml`, `files`, `mesh` | files read, within limits |
//! | `urdf`, `mjcf`, `sdf`, `rosiml` | one format each, into a [`Robot`] |
//! | `robot`, `solid` | what all have in common |
//! | `tree`, `weight`, `shapes`, `ranges`, `compound`, `stand`, `names`, `motors` | what a model file needs, step by step |
//! | `write`, `report` | the text, and the account |
//!
//! What always holds: a file gives the same text, whatever the machine. A problem names its file, line
//! and column, of an included file, too. No file leads to a panic, or to files outside its folder.

#![forbid(unsafe_code)]

mod compound;
mod files;
mod mesh;
mod mjcf;
mod motors;
mod names;
mod ranges;
mod report;
mod robot;
mod rosiml;
mod sdf;
mod shapes;
mod solid;
mod stand;
mod tree;
mod urdf;
mod weight;
mod write;
mod xml;

use std::path::{Path, PathBuf};

use config::{Place, Problem, Problems, shown};

pub use report::{Chosen, LeftOut, Report};
pub use robot::{
    Axis, Inertial, Joint, Link, Motion, Motor, MotorKind, Robot, Shape, Solid, Spring,
};
pub use stand::Base;
pub use write::MeshCopy;
pub use xml::LARGEST_FILE;

use self::{
    files::Files,
    motors::Servos,
    robot::Solid::Mesh,
    write::Setting,
    xml::{Element, Log},
};

/// Endings of files that robots of other formats are in.
pub const ENDINGS: [&str; 7] = ["urdf", "xml", "mjcf", "sdf", "world", "rosiml", "xacro"];

/// What can be asked of an import.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Folders of ROS packages, by name; what is in them may be opened.
    pub packages: Vec<(String, PathBuf)>,
    /// Whether the base is free or fixed, if not as in the file.
    pub base: Option<Base>,
    /// Names of the bodies that are feet, if not to be found out.
    pub feet: Option<Vec<String>>,
    /// Where meshes are copied to, relative to the model file. Without it the model file has the
    /// corners of their hulls itself, and needs no other files.
    pub mesh_folder: Option<String>,
}

/// What came of an import.
#[derive(Clone, Debug)]
pub struct Imported {
    /// The model file, which begins with the report in comments.
    pub text: String,
    /// Meshes that the model file names.
    pub meshes: Vec<MeshCopy>,
    /// What was carried over, left out and chosen.
    pub report: Report,
    /// The robot as its file describes it, at its joints' zero: frames among its links.
    pub written: Robot,
    /// The robot of the model file.
    pub robot: Robot,
}

/// Whether a path looks like that of a robot in another format.
#[must_use]
pub fn is_foreign(path: &Path) -> bool {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    ENDINGS.contains(&ending.as_str())
}

/// Reads a robot in another format.
///
/// # Errors
/// All that is wrong with it, each with its place.
pub fn import(path: &Path, options: &Options) -> Result<Imported, Problems> {
    let text = xml::read(path)?;
    import_text(path, text, options)
}

/// As [`import`], of the text of a file that would be at `path`.
///
/// # Errors
/// Likewise.
pub fn import_text(path: &Path, text: String, options: &Options) -> Result<Imported, Problems> {
    let source = path.display().to_string();
    let root = xml::parse(&source, text)?;
    let log = Log::default();
    let files = Files::new(path, &options.packages);
    let (format, robot) = read(root, &files, &log)?;
    log.result()?;
    let whole = |message: &str| Problems::one(Place::whole(&source), message);
    let Some(mut robot) = robot else {
        return Err(whole("can't be read; that's a mistake in itarl: please report it"));
    };
    let written = prepare_tree(&mut robot, &log)?;
    let had_mesh = prepare(&mut robot, &files, options, &log)?;
    shapes::stand_in(&mut robot, &had_mesh, &log);
    let lift_m = stand::lift_m(&robot, &files, &log);
    let feet =
        stand::feet(&robot, options.feet.as_deref(), &files, &log).map_err(|it| whole(&it))?;
    let servos = Servos::of(&robot, &log);
    let root = stand::root(&robot);
    log.chose("forward", &forward(&robot));
    log.result()?;
    let setting = Setting {
        lift_m,
        root,
        feet: &feet,
        servos: &servos,
        mesh_folder: options.mesh_folder.as_deref(),
        files: &files,
    };
    let (body, meshes) = write::model(&robot, &setting);
    let mut report = log.report.take();
    carried(&mut report, &robot, &feet, &meshes);
    let text = format!("{}\n{body}", heading(path, format, &report));
    Ok(Imported { text, meshes, report, written, robot })
}

/// The format's name, and the robot; what is wrong is in the log.
fn read(
    root: Element,
    files: &Files,
    log: &Log,
) -> Result<(&'static str, Option<Robot>), Problems> {
    if root.children.iter().any(|it| it.name.starts_with("xacro:")) {
        return Err(problem(root.problem("a robot in URDF expected, got xacro: run xacro first")));
    }
    match root.name.as_str() {
        "robot" => Ok(("URDF", urdf::read(&root, log))),
        "mujoco" => Ok(("MJCF", mjcf::read(root, files, log))),
        "sdf" => Ok(("SDF", sdf::read(&root, log))),
        "rosiml" => Ok(("RoSiML", rosiml::read(&root, log))),
        "mujocoinclude" => {
            Err(problem(root.problem("a whole model expected, got a part of one in MJCF")))
        }
        other => Err(problem(root.problem(format!(
            "a robot in URDF (<robot>), MJCF (<mujoco>), SDF (<sdf>) or RoSiML (<rosiml>) expected, \
             got <{}>",
            shown(other)
        )))),
    }
}

fn problem(problem: Problem) -> Problems {
    Problems::one(problem.place, problem.message)
}

/// Leaves one tree, its joints in order: the largest, where there are several. Returns the robot as
/// its file describes it.
fn prepare_tree(robot: &mut Robot, log: &Log) -> Result<Robot, Problems> {
    if tree::is_small(robot, log) {
        tree::keep_the_largest(robot, log);
    }
    let order = tree::order(robot, log);
    log.result()?;
    if let Some(order) = order {
        let place = |joint: usize| order.iter().position(|it| *it == joint).unwrap_or(joint);
        robot.actuators.iter_mut().for_each(|[joint, _]| *joint = place(*joint));
        robot.joints = order.iter().map(|joint| robot.joints[*joint].clone()).collect();
    }
    Ok(robot.clone())
}

/// Makes of a robot one that a model file can have. Returns which links had a mesh.
fn prepare(
    robot: &mut Robot,
    files: &Files,
    options: &Options,
    log: &Log,
) -> Result<Vec<bool>, Problems> {
    let is_mesh = |shape: &Shape| matches!(shape.solid, Mesh { .. });
    let had_mesh: Vec<String> = robot
        .links
        .iter()
        .filter(|link| link.shapes.iter().chain(&link.seen).any(is_mesh))
        .map(|link| link.name.clone())
        .collect();
    shapes::check(robot, log);
    shapes::find_meshes(robot, files, log);
    weight::mend_moments(robot, log);
    weight::let_float(robot, log);
    weight::take_in_frames(robot, log);
    log.result()?;
    stand::set_base(robot, options.base, log);
    shapes::bound_friction(robot, log);
    ranges::mend(robot, log);
    weight::check_bounds(robot, log);
    log.result()?;
    names::mend(robot, log);
    Ok(robot.links.iter().map(|link| had_mesh.contains(&link.name)).collect())
}

fn forward(robot: &Robot) -> String {
    let axis = ["x", "y", "z"][robot.forward.iamax()];
    format!("+{axis} of the drawing, as is usual in the format")
}

fn carried(report: &mut Report, robot: &Robot, feet: &[usize], meshes: &[MeshCopy]) {
    let mass = format!("{}, {} kg", robot.links.len(), digits(robot.mass_kg()));
    report.carry("bodies", mass);
    let shapes: usize = robot.links.iter().map(|link| link.shapes.len()).sum();
    report.carry("shapes", format!("{shapes}, of {} mesh files", meshes.len()));
    let moving = robot.joints.iter().filter(|joint| !joint.axes.is_empty()).count();
    let fixed = robot.joints.len() - moving;
    report.carry("joints", format!("{moving} that move, {fixed} fixed"));
    let axes: Vec<&Axis> = robot.joints.iter().flat_map(|joint| &joint.axes).collect();
    let turning = axes.iter().filter(|axis| axis.motion == Motion::Turns).count();
    report.carry("axes", format!("{turning} that turn, {} that slide", axes.len() - turning));
    let driven = axes.iter().filter(|axis| axis.motor.is_some()).count();
    report.carry("actuators", driven.to_string());
    let touched = robot.touch.iter().filter(|link| !feet.contains(link)).count();
    report.carry("sensors", format!("{} positions, {} contacts", axes.len(), feet.len() + touched));
}

/// Six digits, for people.
fn digits(number: f64) -> String {
    let rounded: f64 = format!("{number:.5e}").parse().unwrap_or(number);
    rounded.to_string()
}

/// The report in comments, above the model.
fn heading(path: &Path, format: &str, report: &Report) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let mut text =
        format!("# Imported from {} ({format}) by `itarl model import`.\n#\n", shown(&name));
    for line in report.to_string().lines() {
        let plain: String = line.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        text += format!("# {plain}").trim_end();
        text.push('\n');
    }
    text
}
