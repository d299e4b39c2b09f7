//! `itarl model`: checks and shows model files, and those of other formats.

use std::path::{Path, PathBuf};

use serde::Serialize;
use svenja::{AxisId, Describe, Morphology};

use super::{Outcome, import, json::print_json, print_line};
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
        Model::Show { files, print } => each(files, |_, model| match print.json {
            true => print_json("model show", Robot::new(model)),
            false => print_line(Describe(model)),
        }),
        Model::Import(arguments) => import::import(arguments),
    }
}

/// What `--json` prints of a robot. Sensors, actuators and contacts are in the order in which readings
/// and targets have them.
#[derive(Serialize)]
struct Robot<'a> {
    name: &'a str,
    description: &'a str,
    mass_kg: f64,
    degrees_of_freedom: usize,
    bodies: Vec<Body<'a>>,
    joints: Vec<Joint<'a>>,
    sensors: Vec<String>,
    actuators: Vec<String>,
    contacts: Vec<&'a str>,
    feet: Vec<&'a str>,
    penalised: Vec<&'a str>,
}

#[derive(Serialize)]
struct Body<'a> {
    name: &'a str,
    mass_kg: f64,
    friction: f64,
    position_m: [f64; 3],
    shapes: Vec<&'static str>,
}

#[derive(Serialize)]
struct Joint<'a> {
    name: &'a str,
    kind: &'static str,
    /// Null: the world.
    parent: Option<&'a str>,
    child: &'a str,
    axes: Vec<Axis<'a>>,
}

#[derive(Serialize)]
struct Axis<'a> {
    name: &'a str,
    /// Of its positions: rad, or m for one that slides.
    unit: &'static str,
    /// At -1 and 1.
    positions: [f64; 2],
    stops: Option<[f64; 2]>,
    servo: Option<Servo>,
}

#[derive(Serialize)]
struct Servo {
    kind: &'static str,
    /// In rad/s or m/s.
    speed_limit: f64,
    /// In N m or N.
    force_limit: f64,
}

impl<'a> Robot<'a> {
    fn new(model: &'a Morphology) -> Self {
        let name = |&body: &usize| model.bodies()[body].name.as_str();
        let names = |bodies: &[usize]| bodies.iter().map(name).collect();
        let axes = |ids: &[AxisId]| ids.iter().map(|&id| model.axis_name(id)).collect();
        let servo = |servo: &svenja::Servo| Servo {
            kind: servo.kind.name(),
            speed_limit: servo.speed_limit,
            force_limit: servo.force_limit,
        };
        let axis = |axis: &'a svenja::JointAxis| Axis {
            name: &axis.name,
            unit: if axis.freedom.is_linear() { "m" } else { "rad" },
            positions: [-1.0, 1.0].map(|value| axis.position_of(value)),
            stops: axis.stops(),
            servo: axis.servo.as_ref().map(servo),
        };
        let body = |body: &'a svenja::Body| Body {
            name: &body.name,
            mass_kg: body.mass_kg,
            friction: body.friction,
            position_m: body.pose.translation.vector.into(),
            shapes: body.colliders.iter().map(|it| it.shape.name()).collect(),
        };
        let joint = |joint: &'a svenja::Joint| Joint {
            name: &joint.name,
            kind: joint.kind.name(),
            parent: joint.parent.as_ref().map(name),
            child: name(&joint.child),
            axes: joint.axes.iter().map(axis).collect(),
        };
        Self {
            name: model.name(),
            description: model.description(),
            mass_kg: model.total_mass_kg(),
            degrees_of_freedom: model.degrees_of_freedom(),
            bodies: model.bodies().iter().map(body).collect(),
            joints: model.joints().iter().map(joint).collect(),
            sensors: axes(model.sensors()),
            actuators: axes(model.actuators()),
            contacts: names(model.contacts()),
            feet: names(model.feet()),
            penalised: names(model.penalised()),
        }
    }
}

/// All files are looked at, whatever is wrong with some.
fn each(
    files: &[PathBuf],
    with: impl Fn(&Path, &Morphology) -> anyhow::Result<()>,
) -> anyhow::Result<Outcome> {
    let mut outcome = Outcome::Done;
    for file in files {
        match models::open_model(file) {
            Ok(model) => with(file, &model)?,
            Err(problems) => {
                notify(problems);
                outcome = Outcome::Failed;
            }
        }
    }
    Ok(outcome)
}
