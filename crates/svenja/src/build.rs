//! From a morphology to Bullet's shapes, bodies and joints.
//!
//! Bullet wants a body's frame along its principal axes of inertia, and a joint's axis along one of
//! its frame's that depends on the class. Both are turned here; [`Part`] knows the way back.

use bullet::{Axis, AxisSettings, BodyId, CollisionFilter, Lengthwise, Motor, Range, World};
use nalgebra::{Isometry3, Point3, Quaternion, UnitQuaternion};

use crate::{Body, Error, Joint, JointAxis, JointKind, Morphology, Rod, Shape, Turn};

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
    let principal = body.shape.principal_axes();
    let pose = morphology.start() * body.pose * principal;
    let shape = add_shape(&body.shape, world)?;
    let mask = if morphology.self_collision() { -1 } else { !ROBOT };
    let id = world.add_body(&bullet::Body {
        inertia: Some(body.shape.inertia_kg_m2(body.mass_kg)),
        friction: body.friction,
        filter: CollisionFilter { group: ROBOT, mask },
        ..bullet::Body::dynamic(shape, body.mass_kg, pose)
    })?;
    let model_frame = principal.inverse();
    Ok(Part { name: body.name.clone(), id, mass_kg: body.mass_kg, model_frame })
}

/// In the frame of its own axes, with the body's centre of mass as origin.
fn add_shape(shape: &Shape, world: &mut World) -> Result<bullet::ShapeId, Error> {
    let along = Lengthwise::Z;
    let (primitive, rod) = match shape {
        Shape::Box { half_extents_m } => {
            (bullet::Shape::Box { half_extents: *half_extents_m }, None)
        }
        Shape::Sphere { radius_m } => (bullet::Shape::Sphere { radius: *radius_m }, None),
        Shape::Capsule(rod) => {
            let (radius, length) = (rod.radius_m, rod.length_m());
            (bullet::Shape::Capsule { radius, length, along }, Some(rod))
        }
        Shape::Cylinder(rod) => {
            let (radius, length) = (rod.radius_m, rod.length_m());
            (bullet::Shape::Cylinder { radius, length, along }, Some(rod))
        }
    };
    let primitive = world.add_shape(&primitive)?;
    match rod.map(Rod::centre_m) {
        Some(centre) if centre != Point3::origin() => {
            let centre = shape.principal_axes().inverse_transform_point(&centre);
            let children = vec![(primitive, Isometry3::translation(centre.x, centre.y, centre.z))];
            Ok(world.add_shape(&bullet::Shape::Compound { children })?)
        }
        _ => Ok(primitive),
    }
}

pub(crate) fn bullet_joint(
    joint: &Joint,
    morphology: &Morphology,
    parts: &[Part],
) -> bullet::Joint {
    let pose = |body: usize| {
        let drawn = morphology.bodies()[body].pose;
        drawn * parts[body].model_frame.inverse()
    };
    let turn = joint
        .axes
        .first()
        .map_or_else(UnitQuaternion::identity, |axis| frame_turn(joint.kind, axis.about));
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
        JointKind::Spherical => {
            let mut axes = [locked; 6];
            for axis in &joint.axes {
                axes[bullet_axis(joint.kind, axis.about).index()] = settings(axis);
            }
            bullet::JointKind::SixDofSpring(Box::new(axes))
        }
    };
    bullet::Joint::at(
        &frame,
        kind,
        (parts[joint.parent].id, &pose(joint.parent)),
        (parts[joint.child].id, &pose(joint.child)),
    )
}

fn axis_settings(kind: JointKind, axis: &JointAxis, stop: bullet::Stop) -> AxisSettings {
    // What is right in degrees may be a rounding beyond in radians.
    let farthest = kind.farthest_deg(axis.about).to_radians();
    let [lower, upper] = axis.stops_rad().map(|stop| stop.clamp(-farthest, farthest));
    AxisSettings {
        range: Range::Limited { lower, upper },
        stop,
        motor: axis
            .servo
            .map(|servo| Motor { target_velocity: 0.0, max_force: servo.torque_limit_nm }),
        spring: axis.spring.map(|spring| bullet::Spring {
            stiffness: spring.stiffness_nm_rad,
            damping: spring.damping_nms_rad,
            equilibrium: spring.equilibrium_rad,
        }),
    }
}

/// Which of Bullet's axes a joint turns about.
pub(crate) fn bullet_axis(kind: JointKind, about: Turn) -> Axis {
    match (kind, about) {
        (JointKind::Hinge, _) => Axis::AngularZ,
        (JointKind::SliderHinge, _) => Axis::AngularX,
        (_, Turn::X) => Axis::AngularX,
        (_, Turn::Y) => Axis::AngularY,
        (_, Turn::Z) => Axis::AngularZ,
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
        JointKind::Fixed | JointKind::Spherical => about,
    };
    match (3 + about.index() - wanted.index()) % 3 {
        0 => UnitQuaternion::identity(),
        1 => on,
        _ => on.inverse(),
    }
}
