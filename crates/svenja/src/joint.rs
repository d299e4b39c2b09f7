//! Joints of a body plan: what they let move, how far, and what drives it.

use std::f64::consts::{PI, TAU};

use nalgebra::Isometry3;

use crate::Turn;

/// A joint between two bodies, or between a body and the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Unique among the joints.
    pub name: String,
    /// The joint's kind: what it lets move.
    pub kind: JointKind,
    /// Index of a body; None: the world.
    pub parent: Option<usize>,
    /// Index of a body.
    pub child: usize,
    /// Where it is and how its axes lie, as the model is drawn.
    pub frame: Isometry3<f64>,
    /// The axes that move; all others are locked.
    pub axes: Vec<JointAxis>,
    /// What happens at the ends of the axes' ranges, and to what the joint locks.
    pub stop: Stop,
}

/// The kinds of joints, by what they let move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// The bodies don't move against each other.
    Fixed,
    /// One rotation: Bullet's hinge.
    Hinge,
    /// One rotation: Bullet's slider with its translation locked, which is how the simulator of the
    /// original experiments made its hinges.
    SliderHinge,
    /// One to three rotations: Bullet's 6-dof spring joint. They are taken about z, then about the
    /// new y, then about the newest x.
    Spherical,
    /// One translation: Bullet's 6-dof spring joint.
    Slider,
    /// Up to three translations, along the axes of the parent's frame, and up to three rotations as in a
    /// spherical joint: Bullet's 6-dof spring joint.
    General,
}

impl JointKind {
    /// Its name in model files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Fixed => "fixed",
            Self::Hinge => "hinge",
            Self::SliderHinge => "slider-hinge",
            Self::Spherical => "spherical",
            Self::Slider => "slider",
            Self::General => "general",
        }
    }

    /// Whether it's Bullet's 6-dof spring joint, which alone has springs.
    #[must_use]
    pub fn is_six_dof(self) -> bool {
        matches!(self, Self::Spherical | Self::Slider | Self::General)
    }

    /// How far from 0 an axis and its stops may be, in degrees. Of the three angles of Bullet's 6-dof
    /// joint, which it has whichever of them turn, the middle one's other half would be the same
    /// turns again.
    #[must_use]
    pub fn farthest_deg(self, about: Turn) -> f64 {
        if self.is_six_dof() && about == Turn::Y { 90.0 } else { 180.0 }
    }
}

/// What an axis of a joint lets happen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Freedom {
    /// A rotation about an axis of the joint's frame. Positions are in rad, forces torques in N m.
    About(Turn),
    /// A translation along one. Positions are in m, forces in N.
    Along(Turn),
}

impl Freedom {
    /// Whether it's a translation.
    #[must_use]
    pub fn is_linear(self) -> bool {
        matches!(self, Self::Along(_))
    }

    /// The axis of the joint's frame.
    #[must_use]
    pub fn direction(self) -> Turn {
        match self {
            Self::About(turn) | Self::Along(turn) => turn,
        }
    }

    /// What an axis is called by default: `x`, or `along x`.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::About(turn) => turn.name().into(),
            Self::Along(turn) => format!("along {}", turn.name()),
        }
    }
}

/// An axis of a joint: right-handed, 0 as the model is drawn. Positions are in rad, or in m along it.
#[derive(Clone, Debug, PartialEq)]
pub struct JointAxis {
    /// Unique within the joint.
    pub name: String,
    /// What moves.
    pub freedom: Freedom,
    /// Lower and upper end of what commands and readings cover; None: it turns on for ever.
    pub range: Option<[f64; 2]>,
    /// How far beyond either end the joint's stops are.
    pub stop_margin: f64,
    /// Whether +1 stands for the lower end, and -1 for the upper.
    pub reversed: bool,
    /// The servo that drives it, if it has one.
    pub servo: Option<Servo>,
    /// The damped spring that pulls it back, if it has one.
    pub spring: Option<Spring>,
    /// What resists its motion.
    pub resistance: Resistance,
}

impl JointAxis {
    /// Where the joint stops, the lower and the upper end; an axis that turns on for ever doesn't.
    #[must_use]
    pub fn stops(&self) -> Option<[f64; 2]> {
        let [lower, upper] = self.range?;
        Some([lower - self.stop_margin, upper + self.stop_margin])
    }

    /// What -1 to 1 covers: the range, or a whole turn.
    fn covered(&self) -> [f64; 2] {
        self.range.unwrap_or([-PI, PI])
    }

    /// Where -1..1 lies in the range, or in a whole turn.
    #[must_use]
    pub fn position_of(&self, value: f64) -> f64 {
        let value = if self.reversed { -value } else { value };
        let [lower, upper] = self.covered();
        lower + 0.5 * (value + 1.0) * (upper - lower)
    }

    /// Where a position lies on the scale from -1 to 1, and beyond; of an axis that turns on for ever
    /// never beyond: it begins again.
    #[must_use]
    pub fn value_of(&self, position: f64) -> f64 {
        let position = if self.range.is_none() { turned_back(position) } else { position };
        let [lower, upper] = self.covered();
        let part = (position - lower) / (upper - lower);
        let value = 2.0 * part - 1.0;
        if self.reversed { -value } else { value }
    }

    /// How far it is from one position to another: for an axis that turns on for ever, the short way.
    #[must_use]
    pub fn way(&self, from: f64, to: f64) -> f64 {
        if self.range.is_none() { turned_back(to - from) } else { to - from }
    }
}

/// An angle within half a turn of 0.
fn turned_back(angle_rad: f64) -> f64 {
    libm::remainder(angle_rad, TAU)
}

/// What a servo makes of its command, -1 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ServoKind {
    /// A place in the axis' range, which it moves to.
    Position,
    /// A share of its speed limit.
    Speed,
    /// A share of its force limit, up to its speed limit.
    Torque,
}

impl ServoKind {
    /// Its name in model files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Speed => "speed",
            Self::Torque => "torque",
        }
    }
}

/// What drives an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Servo {
    /// What its command stands for.
    pub kind: ServoKind,
    /// How fast it moves at most, in rad/s or m/s.
    pub speed_limit: f64,
    /// How hard it pushes at most, in N m or N.
    pub force_limit: f64,
}

/// A damped spring: force = -stiffness (position - equilibrium) - damping velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// The stiffness in N m/rad or N/m.
    pub stiffness: f64,
    /// The damping in N m s/rad or N s/m.
    pub damping: f64,
    /// The position at which the spring is at rest.
    pub equilibrium: f64,
}

/// What resists the motion of an axis: force = -friction sign(velocity) - damping velocity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Resistance {
    /// The damping in N m s/rad or N s/m.
    pub damping: f64,
    /// The friction in N m or N, whatever the load.
    pub friction: f64,
}

impl Resistance {
    /// Whether there is any.
    #[must_use]
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

/// What happens at the stops of a joint. To Bullet's sliders and 6-dof joints what is locked is a
/// range without a length, so it's held in the same way; hinges and fixed joints hold it as the
/// world's own settings say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// Share of the overshoot that a physics step takes back.
    pub erp: f64,
    /// Softness; 0 is rigid.
    pub cfm: f64,
    /// Share of the speed that comes back.
    pub bounce: f64,
}

/// Hard and without a bounce.
impl Default for Stop {
    fn default() -> Self {
        Self { erp: 1.0, cfm: 0.0, bounce: 0.0 }
    }
}
