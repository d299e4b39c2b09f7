//! A model as tables to read.

use std::fmt::{self, Write};

use comfy_table::{CellAlignment, Table, presets::ASCII_MARKDOWN};
use nalgebra::Point3;

use crate::{AxisId, JointAxis, Morphology, ServoKind, Shape};

/// Shows bodies, joints, sensors and actuators as tables in plain text.
///
/// ```
/// use svenja::{Describe, Morphology};
/// let model = "
/// name = 'pebble'
/// heading = { body = 'stone' }
/// body = [{ name = 'stone', mass_kg = 0.2, shape = { kind = 'sphere', radius_m = 0.03 } }]";
/// let text = Describe(&Morphology::parse("pebble.toml", model)?).to_string();
/// assert!(text.contains("1 body, 0.2 kg, 6 degrees of freedom"));
/// # Ok::<(), svenja::Problems>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Describe<'a>(pub &'a Morphology);

impl fmt::Display for Describe<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let model = self.0;
        let n = model.bodies().len();
        match model.description() {
            "" => writeln!(out, "{}", model.name())?,
            description => writeln!(out, "{}: {description}", model.name())?,
        }
        writeln!(
            out,
            "{n} {}, {} kg, {} degrees of freedom; {} position sensors, {} contact sensors, {} \
             actuators; heading along {} of '{}'",
            if n == 1 { "body" } else { "bodies" },
            rounded(model.total_mass_kg()),
            model.degrees_of_freedom(),
            model.sensors().len(),
            model.contacts().len(),
            model.actuators().len(),
            triple(&model.heading().axis.into_inner().into()),
            model.bodies()[model.heading().body].name,
        )?;
        let apart = model
            .no_collision()
            .iter()
            .map(|pair| pair.map(|body| format!("'{}'", model.bodies()[body].name)).join(" and "));
        let apart: Vec<_> = apart.collect();
        if !apart.is_empty() {
            writeln!(out, "never collide: {}", apart.join(", "))?;
        }
        writeln!(out, "\n{}", bodies(model))?;
        if !model.joints().is_empty() {
            writeln!(out, "\n{}", joints(model))?;
        }
        if !model.groups().is_empty() {
            writeln!(out)?;
        }
        for group in model.groups() {
            let joints: Vec<_> =
                group.joints.iter().map(|&j| model.joints()[j].name.as_str()).collect();
            writeln!(out, "group '{}': {}", group.name, joints.join(", "))?;
        }
        Ok(())
    }
}

fn bodies(model: &Morphology) -> Table {
    let mut header = vec!["body", "mass kg", "friction", "x m", "y m", "z m", "shape m", "contact"];
    // Most robots have none, and a table is wide enough.
    let has_inertia = model.bodies().iter().any(|body| body.inertia_kg_m2.is_some());
    if has_inertia {
        header.push("inertia kg m2");
    }
    let mut table = table(&header);
    for (index, body) in model.bodies().iter().enumerate() {
        let position = body.pose.translation.vector;
        let role = |name: &str, at: Option<usize>| at.map(|i| format!("{name} {}", i + 1));
        let contact = role("foot", model.feet().iter().position(|&foot| foot == index))
            .or(role("touch", model.contacts().iter().position(|&touch| touch == index)));
        let penalised = model.penalised().contains(&index).then(|| "penalised".to_owned());
        let roles: Vec<_> = contact.into_iter().chain(penalised).collect();
        let mut row = vec![
            body.name.clone(),
            rounded(body.mass_kg),
            rounded(body.friction),
            rounded(position.x),
            rounded(position.y),
            rounded(position.z),
            shapes(body),
            roles.join(", "),
        ];
        if has_inertia {
            let given = body.inertia_kg_m2.map(|it| [it.x, it.y, it.z].map(significant).join(", "));
            row.push(given.unwrap_or_else(|| "of its shape".into()));
        }
        table.add_row(row);
    }
    right_align(&mut table, 1..6);
    table
}

fn joints(model: &Morphology) -> Table {
    let mut header = vec![
        "joint",
        "kind",
        "parent",
        "child",
        "axis",
        "-1 deg",
        "+1 deg",
        "stops deg",
        "rad/s",
        "N m",
        "sensor",
        "actuator",
    ];
    let is_resisted = model.axes().any(|id| !model.axis(id).resistance.is_none());
    if is_resisted {
        header.extend(["friction", "damping"]);
    }
    let mut table = table(&header);
    for (j, joint) in model.joints().iter().enumerate() {
        let parent = joint.parent.map_or("world", |parent| model.bodies()[parent].name.as_str());
        let child = model.bodies()[joint.child].name.as_str();
        let lead = [joint.name.as_str(), joint.kind.name(), parent, child].map(str::to_owned);
        if joint.axes.is_empty() {
            table.add_row(&lead);
        }
        for (a, axis) in joint.axes.iter().enumerate() {
            let ports = ports(model, AxisId { joint: j, axis: a });
            let resistance = [axis.resistance.friction, axis.resistance.damping].map(significant);
            let row = lead
                .iter()
                .cloned()
                .chain(axis_cells(axis))
                .chain(ports)
                .chain(resistance.into_iter().filter(|_| is_resisted));
            table.add_row(row);
        }
    }
    right_align(&mut table, 5..header.len());
    table
}

/// An axis's numbers among the sensors and among the actuators, from 1.
fn ports(model: &Morphology, id: AxisId) -> [String; 2] {
    let place = |of: &[AxisId]| {
        of.iter().position(|&other| other == id).map_or(String::new(), |i| (i + 1).to_string())
    };
    let actuator = match model.axis(id).servo {
        Some(servo) if servo.kind != ServoKind::Position => {
            format!("{} ({})", place(model.actuators()), servo.kind.name())
        }
        _ => place(model.actuators()),
    };
    [place(model.sensors()), actuator]
}

/// In the columns' units, or with their own.
fn axis_cells(axis: &JointAxis) -> [String; 6] {
    let is_linear = axis.freedom.is_linear();
    let (unit, speed_unit, force_unit) =
        if is_linear { (" m", " m/s", " N") } else { ("", "", "") };
    let position =
        |position: f64| rounded(if is_linear { position } else { position.to_degrees() }) + unit;
    let short = axis.freedom.name();
    let name = match axis.name == short {
        true => axis.name.clone(),
        false => format!("{} ({short})", axis.name),
    };
    let servo = |value: fn(&crate::Servo) -> f64, unit: &str| {
        axis.servo.as_ref().map_or(String::new(), |servo| rounded(value(servo)) + unit)
    };
    [
        name,
        position(axis.position_of(-1.0)),
        position(axis.position_of(1.0)),
        axis.stops().map_or("none".into(), |stops| stops.map(position).join(" .. ")),
        servo(|servo| servo.speed_limit, speed_unit),
        servo(|servo| servo.force_limit, force_unit),
    ]
}

fn shapes(body: &crate::Body) -> String {
    let all: Vec<_> = body.colliders.iter().map(|collider| shape(&collider.shape)).collect();
    if all.is_empty() { "none".into() } else { all.join("; ") }
}

fn shape(shape: &Shape) -> String {
    let mut text = shape.name().to_owned();
    // Writing to a string can't fail.
    let _ = match shape {
        Shape::Box { half_extents_m } => {
            write!(text, ", half extents {}", triple(&(*half_extents_m).into()))
        }
        Shape::Sphere { radius_m } => write!(text, ", radius {}", rounded(*radius_m)),
        Shape::Capsule(rod) | Shape::Cylinder(rod) => {
            write!(text, ", radius {}, length {}", rounded(rod.radius_m), rounded(rod.length_m()))
        }
        Shape::Ellipsoid { radii_m } => write!(text, ", radii {}", triple(&(*radii_m).into())),
        Shape::Hull(hull) => write!(text, " of {} points", hull.points_m().len()),
    };
    text
}

fn triple(point: &Point3<f64>) -> String {
    format!("({}, {}, {})", rounded(point.x), rounded(point.y), rounded(point.z))
}

/// To three places, without zeros at the end.
fn rounded(value: f64) -> String {
    let text = format!("{value:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}

/// To three digits or so, of any size.
fn significant(value: f64) -> String {
    let text = match value {
        0.0 | 1.0.. => return rounded(value),
        0.001.. => format!("{value:.5}"),
        _ => return format!("{value:.2e}"),
    };
    text.trim_end_matches('0').into()
}

fn table(header: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_preset(ASCII_MARKDOWN).set_header(header);
    table
}

fn right_align(table: &mut Table, columns: std::ops::Range<usize>) {
    for column in columns {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
}
