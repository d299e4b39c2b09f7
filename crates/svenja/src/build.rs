//! From a morphology to Bullet's shapes, bodies and joints.
//!
//! Bullet wants a body's frame along its principal axes of inertia, and a joint's axis along one of
//! its frame's that depends on the class. Both are turned here; [`Part`] knows the way back.

use bullet::{
    Axis, AxisSettings, BodyId, CollisionFilter, JointId, Lengthwise, Motor, Range, World,
};
use nalgebra::{Isometry3, Point3, Quaternion, UnitQuaternion};

use crate::{
    Body, Collider, Error, Freedom, Joint, JointAxis, JointKind, Morphology, Rod, Servo, ServoKind,
    Shape, Turn,
};

/// The collision group of robots, none of Bullet's own.
const ROBOT: i32 = 64;

/// Where a slider's translation is locked, in m. Bullet leaves its row out in a step that begins
/// with the translation exactly where it's locked: a leg under load then slips by a centimetre. At 0
/// that happens now and then, since positions are rounded to some 1e-7 m; here it doesn't.
const OFF_ZERO_M: f64 = 1e-30;

/// A body as it's in a world.
#[derive(Debug)]
pub(crate) struct Part {
    pub(crate) name: String,
    pub(crate) id: BodyId,
    pub(crate) mass_kg: f64,
    /// The model's frame of the body, seen from Bullet's.
    pub(crate) model_frame: UnitQuaternion<f64>,
}

pub(crate) fn add_body(
    body: &Body,
    morphology: &Morphology,
    world: &mut World,
) -> Result<Part, Error> {
    let inertia = body.inertia();
    let pose = morphology.start() * body.pose * inertia.axes;
    let shape = add_colliders(&body.colliders, &inertia.axes, world)?;
    let mask = match body.colliders.is_empty() {
        true => 0,
        false if morphology.self_collision() => -1,
        false => !ROBOT,
    };
    let id = world.add_body(&bullet::Body {
        inertia: Some(inertia.moments_kg_m2),
        friction: body.friction,
        filter: CollisionFilter { group: ROBOT, mask },
        ..bullet::Body::dynamic(shape, body.mass_kg, pose)
    })?;
    let model_frame = inertia.axes.inverse();
    Ok(Part { name: body.name.clone(), id, mass_kg: body.mass_kg, model_frame })
}

/// What the joint to the world holds on to: a body that never moves, and that nothing touches. Its frame is
/// that of the drawing.
fn add_anchor(morphology: &Morphology, world: &mut World) -> Result<BodyId, Error> {
    let shape = world.add_shape(&NOTHING)?;
    Ok(world.add_body(&bullet::Body {
        filter: CollisionFilter { group: ROBOT, mask: 0 },
        ..bullet::Body::fixed(shape, *morphology.start())
    })?)
}

/// The shape of what touches nothing: Bullet wants one.
const NOTHING: bullet::Shape = bullet::Shape::Sphere { radius: 1e-3 };

/// In the frame of the body's principal axes, with its centre of mass as origin.
fn add_colliders(
    colliders: &[Collider],
    axes: &UnitQuaternion<f64>,
    world: &mut World,
) -> Result<bullet::ShapeId, Error> {
    if colliders.is_empty() {
        return Ok(world.add_shape(&NOTHING)?);
    }
    let mut children = Vec::new();
    for collider in colliders {
        let shape = world.add_shape(&bullet_shape(&collider.shape))?;
        children.push((shape, place_in(axes, collider)));
    }
    match children[..] {
        [(shape, place)] if place == Isometry3::identity() => Ok(shape),
        _ => Ok(world.add_shape(&bullet::Shape::Compound { children })?),
    }
}

/// Where a shape of Bullet's lies, whose middle is its origin and whose length is along z.
fn place_in(axes: &UnitQuaternion<f64>, collider: &Collider) -> Isometry3<f64> {
    let origin = match collider.shape {
        Shape::Hull(_) => collider.pose * Point3::origin(),
        _ => collider.centre_m(),
    };
    let origin = axes.inverse_transform_point(&origin);
    let own = collider.principal_axes();
    // The body's axes are those of its only shape: a product would round.
    let turn = if own == *axes { UnitQuaternion::identity() } else { axes.inverse() * own };
    Isometry3::from_parts(origin.into(), turn)
}

fn bullet_shape(shape: &Shape) -> bullet::Shape {
    let along = Lengthwise::Z;
    let size = |rod: &Rod| (rod.radius_m, rod.length_m());
    match shape {
        Shape::Box { half_extents_m } => bullet::Shape::Box { half_extents: *half_extents_m },
        Shape::Sphere { radius_m } => bullet::Shape::Sphere { radius: *radius_m },
        Shape::Capsule(rod) => {
            let (radius, length) = size(rod);
            bullet::Shape::Capsule { radius, length, along }
        }
        Shape::Cylinder(rod) => {
            let (radius, length) = size(rod);
            bullet::Shape::Cylinder { radius, length, along }
        }
        Shape::Ellipsoid { radii_m } => bullet::Shape::Ellipsoid { radii: *radii_m },
        Shape::Hull(hull) => bullet::Shape::Hull { points: hull.points_m().to_vec(), margin: 0.0 },
    }
}

pub(crate) fn add_joint(
    joint: &Joint,
    morphology: &Morphology,
    parts: &[Part],
    world: &mut World,
) -> Result<JointId, Error> {
    let drawn = |body: usize| {
        let pose = morphology.bodies()[body].pose;
        (parts[body].id, pose * parts[body].model_frame.inverse())
    };
    let child = drawn(joint.child);
    let parent = match joint.parent {
        Some(parent) => drawn(parent),
        None => (add_anchor(morphology, world)?, Isometry3::identity()),
    };
    let turn = joint.axes.first().map_or_else(UnitQuaternion::identity, |axis| {
        frame_turn(joint.kind, axis.freedom.direction())
    });
    // Relative poses: where the robot starts doesn't matter.
    let frame = Isometry3::from_parts(joint.frame.translation, joint.frame.rotation * turn);
    let stop = bullet::Stop {
        erp: Some(joint.stop.erp),
        cfm: Some(joint.stop.cfm),
        bounce: Some(joint.stop.bounce),
    };
    let locked =
        AxisSettings { stop: bullet::Stop { bounce: None, ..stop }, ..AxisSettings::locked() };
    let settings = |axis| axis_settings(joint.kind, axis, stop);
    let only_axis = || joint.axes.first().map_or(locked, settings);
    let kind = match joint.kind {
        JointKind::Fixed => bullet::JointKind::Fixed,
        JointKind::Hinge => bullet::JointKind::Hinge(only_axis()),
        JointKind::SliderHinge => bullet::JointKind::Slider {
            linear: AxisSettings {
                range: Range::Limited { lower: OFF_ZERO_M, upper: OFF_ZERO_M },
                ..locked
            },
            angular: only_axis(),
            held: locked.stop,
        },
        JointKind::Spherical | JointKind::Slider | JointKind::General => {
            let mut axes = [locked; 6];
            for axis in &joint.axes {
                axes[bullet_axis(joint.kind, axis.freedom).index()] = settings(axis);
            }
            bullet::JointKind::SixDofSpring(Box::new(axes))
        }
    };
    let joint = bullet::Joint::at(&frame, kind, (parent.0, &parent.1), (child.0, &child.1));
    Ok(world.add_joint(&joint)?)
}

fn axis_settings(kind: JointKind, axis: &JointAxis, stop: bullet::Stop) -> AxisSettings {
    // What is right in degrees may be a rounding beyond in radians.
    let farthest = match axis.freedom {
        Freedom::About(turn) => kind.farthest_deg(turn).to_radians(),
        Freedom::Along(_) => f64::INFINITY,
    };
    let range = match axis.stops() {
        Some(stops) => {
            let [lower, upper] = stops.map(|stop| stop.clamp(-farthest, farthest));
            Range::Limited { lower, upper }
        }
        None => Range::Free,
    };
    AxisSettings {
        range,
        stop,
        motor: first_motor(axis),
        spring: axis.spring.map(|spring| bullet::Spring {
            stiffness: spring.stiffness,
            damping: spring.damping,
            equilibrium: spring.equilibrium,
        }),
    }
}

/// What drives or resists it as long as nothing is commanded: it holds.
fn first_motor(axis: &JointAxis) -> Option<Motor> {
    let max_force = match axis.servo {
        Some(Servo { kind: ServoKind::Torque, .. }) => 0.0,
        Some(servo) => servo.force_limit,
        None if axis.resistance.is_none() => return None,
        None => 0.0,
    };
    Some(Motor { target_velocity: 0.0, max_force })
}

/// Which of Bullet's axes moves.
pub(crate) fn bullet_axis(kind: JointKind, freedom: Freedom) -> Axis {
    match (kind, freedom) {
        (JointKind::Hinge, _) => Axis::AngularZ,
        (JointKind::SliderHinge, _) => Axis::AngularX,
        (_, Freedom::About(Turn::X)) => Axis::AngularX,
        (_, Freedom::About(Turn::Y)) => Axis::AngularY,
        (_, Freedom::About(Turn::Z)) => Axis::AngularZ,
        (_, Freedom::Along(Turn::X)) => Axis::LinearX,
        (_, Freedom::Along(Turn::Y)) => Axis::LinearY,
        (_, Freedom::Along(Turn::Z)) => Axis::LinearZ,
    }
}

/// Turns the joint's frame so that the axis `about` lies where Bullet's class wants it: z for a
/// hinge, x for a slider.
fn frame_turn(kind: JointKind, about: Turn) -> UnitQuaternion<f64> {
    // x to y, y to z, z to x: exact.
    let on = UnitQuaternion::new_unchecked(Quaternion::new(0.5, 0.5, 0.5, 0.5));
    let wanted = match kind {
        JointKind::Hinge => Turn::Z,
        JointKind::SliderHinge => Turn::X,
        _ => about,
    };
    match (3 + about.index() - wanted.index()) % 3 {
        0 => UnitQuaternion::identity(),
        1 => on,
        _ => on.inverse(),
    }
}
