//! `[[joint]]`: what holds a child to its parent, and the axes that move.

use config::{Place, Placed, Section, flag, name, one_of, vector, within};
use nalgebra::{Isometry3, Translation3};

use super::{LARGEST, LONGEST_M, TURNS, angles_deg, part, point_m};
use crate::{
    joint::{Freedom, JointKind, Resistance, Spring, Stop},
    rotation::{Turn, from_euler_deg},
};

const HALF_TURN_DEG: f64 = 180.0;

pub(crate) struct JointFile {
    pub(crate) name: Placed<String>,
    pub(crate) kind: JointKind,
    pub(crate) parent: Placed<String>,
    pub(crate) child: Placed<String>,
    /// In the parent's frame.
    pub(crate) frame: Isometry3<f64>,
    pub(crate) axes: Vec<AxisFile>,
    pub(crate) stop: Stop,
}

/// In rad, or in m.
pub(crate) struct AxisFile {
    /// Of its range, or its own if it has none.
    pub(crate) place: Place,
    pub(crate) name: String,
    pub(crate) freedom: Freedom,
    pub(crate) range: Option<[f64; 2]>,
    pub(crate) stop_margin: f64,
    pub(crate) reversed: bool,
    pub(crate) servo: Option<Placed<String>>,
    pub(crate) spring: Option<Spring>,
    pub(crate) resistance: Resistance,
}

const JOINT_KINDS: &[(&str, JointKind)] = &[
    ("fixed", JointKind::Fixed),
    ("hinge", JointKind::Hinge),
    ("slider-hinge", JointKind::SliderHinge),
    ("spherical", JointKind::Spherical),
    ("slider", JointKind::Slider),
    ("general", JointKind::General),
];

impl JointFile {
    pub(super) fn read(joint: &mut Section<'_>) -> Option<Self> {
        let name = joint.required("name", part());
        if let Some(name) = &name {
            joint.call(format!("joint '{}'", name.value));
        }
        let kind = joint.required("kind", one_of(JOINT_KINDS));
        let parent = joint.required("parent", part());
        let child = joint.required("child", part());
        let anchor = joint.required("anchor_m", point_m());
        let rotation = joint.or("frame_deg", angles_deg(), [0.0; 3]);
        let stop = joint.table("stop", read_stop).unwrap_or_default();
        let axes = read_axes(joint, kind);
        Some(Self {
            name: name?,
            kind: kind?,
            parent: parent?,
            child: child?,
            frame: Isometry3::from_parts(Translation3::from(anchor?), from_euler_deg(rotation)),
            axes: axes?,
            stop,
        })
    }
}

/// Without a kind, which is a problem already, it can't be said what is wrong with the axes.
fn read_axes(joint: &mut Section<'_>, kind: Option<JointKind>) -> Option<Vec<AxisFile>> {
    let count = joint.count("axes");
    let kind = kind?;
    let (counts, expected) = match kind {
        JointKind::Fixed => (0..=0, "absent for a fixed joint"),
        JointKind::Hinge | JointKind::SliderHinge | JointKind::Slider => {
            (1..=1, "a list of one axis")
        }
        JointKind::Spherical => (1..=3, "a list of one to three axes"),
        JointKind::General => (1..=6, "a list of one to six axes"),
    };
    if !counts.contains(&count) {
        joint.refuse("axes", expected, format!("{count} of them"));
        return None;
    }
    let mut earlier: Vec<(Freedom, String)> = Vec::new();
    let axes = joint.tables("axes", |axis| {
        let read = AxisFile::read(axis, kind)?;
        let key = if read.freedom.is_linear() { "along" } else { "about" };
        if earlier.iter().any(|(freedom, _)| *freedom == read.freedom) {
            axis.refuse_value(key, "another direction than that of the joint's other axes");
        } else if earlier.iter().any(|(_, name)| *name == read.name) {
            axis.refuse_value("name", "another name than those of the joint's other axes");
        }
        earlier.push((read.freedom, read.name.clone()));
        Some(read)
    });
    Some(axes)
}

impl AxisFile {
    fn read(axis: &mut Section<'_>, kind: JointKind) -> Option<Self> {
        match kind {
            JointKind::Slider => Self::read_along(axis),
            JointKind::General if axis.has("along") => {
                if axis.has("about") {
                    axis.refuse_value("about", "absent beside along: an axis is one of them");
                    axis.accept_all();
                    return None;
                }
                Self::read_along(axis)
            }
            JointKind::General if !axis.has("about") => {
                axis.complain(
                    axis.place(),
                    "'about' or 'along' is missing: \"x\" or \"y\" or \"z\"",
                );
                axis.accept_all();
                None
            }
            _ => Self::read_about(axis, kind),
        }
    }

    fn read_about(axis: &mut Section<'_>, kind: JointKind) -> Option<Self> {
        let about = axis.required("about", one_of(TURNS));
        let name = axis.optional("name", name());
        let rule = vector::<_, 2>(within(-HALF_TURN_DEG, HALF_TURN_DEG));
        let range_deg = axis.optional("range_deg", rule);
        let margin_deg = axis.or("stop_margin_deg", within(0.0, HALF_TURN_DEG), 0.0);
        let reversed = axis.or("reversed", flag(), false);
        let servo = axis.optional("servo", part());
        let spring = axis.table("spring", |spring| read_spring(spring, range_deg));
        let damping = axis.or("damping_nms_rad", within(0.0, LARGEST), 0.0);
        let friction = axis.or("friction_nm", within(0.0, LARGEST), 0.0);
        if !kind.is_six_dof() && axis.has("spring") {
            axis.refuse(
                "spring",
                "absent (only spherical, slider and general joints have springs)",
                "one",
            );
        }
        let about = about?;
        let range_deg = match range_deg {
            Some(range) => {
                check_range(axis, range, margin_deg, kind.farthest_deg(about))?;
                Some(range)
            }
            None if axis.has("range_deg") => return None,
            None => {
                check_endless(axis, about, kind)?;
                None
            }
        };
        Some(Self {
            place: axis.place_of("range_deg"),
            name: name.unwrap_or_else(|| about.name().into()),
            freedom: Freedom::About(about),
            range: range_deg.map(|range| range.map(f64::to_radians)),
            stop_margin: margin_deg.to_radians(),
            reversed,
            servo,
            spring,
            resistance: Resistance { damping, friction },
        })
    }

    fn read_along(axis: &mut Section<'_>) -> Option<Self> {
        let along = axis.required("along", one_of(TURNS));
        let name = axis.optional("name", name());
        let range_m = axis.required("range_m", vector::<_, 2>(within(-LONGEST_M, LONGEST_M)));
        let margin_m = axis.or("stop_margin_m", within(0.0, LONGEST_M), 0.0);
        let reversed = axis.or("reversed", flag(), false);
        let servo = axis.optional("servo", part());
        let spring = axis.table("spring", |spring| read_linear_spring(spring, range_m));
        let damping = axis.or("damping_ns_m", within(0.0, LARGEST), 0.0);
        let friction = axis.or("friction_n", within(0.0, LARGEST), 0.0);
        let (along, range) = (along?, range_m?);
        if range[0] >= range[1] {
            axis.refuse_value("range_m", "[lower, upper] with lower < upper");
            return None;
        } else if range[0] > 0.0 || range[1] < 0.0 {
            axis.refuse_value("range_m", "around 0, the position in which the model is drawn");
            return None;
        }
        Some(Self {
            place: axis.place_of("range_m"),
            name: name.unwrap_or_else(|| Freedom::Along(along).name()),
            freedom: Freedom::Along(along),
            range: Some(range),
            stop_margin: margin_m,
            reversed,
            servo,
            spring,
            resistance: Resistance { damping, friction },
        })
    }
}

/// Whether a range is one, has 0 in it, and leaves its stops where the joint can tell angles apart.
fn check_range(
    axis: &mut Section<'_>,
    [lower, upper]: [f64; 2],
    margin: f64,
    farthest: f64,
) -> Option<()> {
    let reach = upper.max(-lower);
    if lower >= upper {
        axis.refuse_value("range_deg", "[lower, upper] with lower < upper");
    } else if lower > 0.0 || upper < 0.0 {
        axis.refuse_value("range_deg", "around 0, the angle in which the model is drawn");
    } else if reach > farthest {
        let expected = format!(
            "from {} to {farthest} (about y of a spherical joint; about x or z, and in a hinge, \
             there's no such bound)",
            -farthest
        );
        axis.refuse_value("range_deg", &expected);
    } else if reach + margin > farthest {
        let expected = format!("at most {farthest} less the {reach} of range_deg");
        axis.refuse_value("stop_margin_deg", &expected);
    } else {
        return Some(());
    }
    None
}

/// Whether an axis can turn on for ever, and has nothing that belongs to a range.
fn check_endless(axis: &mut Section<'_>, about: Turn, kind: JointKind) -> Option<()> {
    if kind.farthest_deg(about) < HALF_TURN_DEG {
        let message = "'range_deg' is missing: [lower, upper] within -90 to 90 (about y of a \
                       spherical joint; about x or z, and in a hinge, an axis without a range turns \
                       on for ever)";
        axis.complain(axis.place(), message);
    } else if axis.has("stop_margin_deg") {
        axis.refuse_value("stop_margin_deg", "absent (an axis without a range_deg has no stops)");
    } else {
        return Some(());
    }
    None
}

fn read_spring(spring: &mut Section<'_>, range_deg: Option<[f64; 2]>) -> Option<Spring> {
    let stiffness = spring.required("stiffness_nm_rad", within(0.0, LARGEST));
    let damping = spring.required("damping_nms_rad", within(0.0, LARGEST));
    let rule = within(-HALF_TURN_DEG, HALF_TURN_DEG);
    let equilibrium_deg = spring.or("equilibrium_deg", rule, 0.0);
    check_equilibrium(spring, ("equilibrium_deg", equilibrium_deg), ("range_deg", range_deg));
    let equilibrium = equilibrium_deg.to_radians();
    Some(Spring { stiffness: stiffness?, damping: damping?, equilibrium })
}

fn read_linear_spring(spring: &mut Section<'_>, range_m: Option<[f64; 2]>) -> Option<Spring> {
    let stiffness = spring.required("stiffness_n_m", within(0.0, LARGEST));
    let damping = spring.required("damping_ns_m", within(0.0, LARGEST));
    let equilibrium = spring.or("equilibrium_m", within(-LONGEST_M, LONGEST_M), 0.0);
    check_equilibrium(spring, ("equilibrium_m", equilibrium), ("range_m", range_m));
    Some(Spring { stiffness: stiffness?, damping: damping?, equilibrium })
}

fn check_equilibrium(
    spring: &mut Section<'_>,
    (key, equilibrium): (&str, f64),
    (range_key, range): (&str, Option<[f64; 2]>),
) {
    if let Some([lower, upper]) = range
        && spring.has(key)
        && lower < upper
        && !(lower..=upper).contains(&equilibrium)
    {
        spring.refuse_value(key, &format!("in {range_key}, {lower} to {upper}"));
    }
}

#[allow(clippy::unnecessary_wraps)] // a reader
fn read_stop(stop: &mut Section<'_>) -> Option<Stop> {
    let default = Stop::default();
    Some(Stop {
        erp: stop.or("erp", within(0.0, 1.0), default.erp),
        cfm: stop.or("cfm", within(0.0, 1.0), default.cfm),
        bounce: stop.or("bounce", within(0.0, 1.0), default.bounce),
    })
}
