//! The calls, and how they are drawn.

use super::*;

/// Where the bounds of the checks lie, and beyond them in either precision.
const NASTY: [f64; 28] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    -0.0,
    0.0,
    -1.0,
    1.0,
    1e300,
    -1e300,
    1e-300,
    f64::MAX,
    f64::MIN_POSITIVE,
    5e-324,
    f32::MAX as f64,
    f32::MIN_POSITIVE as f64,
    1e-45,
    1e18,
    -1e18,
    1.1e18,
    1e12,
    1e-12,
    1e6,
    -1e6,
    1.1e6,
    1e-6,
    0.9e-6,
    1e5,
    std::f64::consts::PI,
];

/// Printed one call a line.
#[derive(Clone)]
pub(super) struct Calls(pub(super) Vec<Call>);

impl std::fmt::Debug for Calls {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.iter().try_for_each(|call| write!(formatter, "\n  {call:?}"))
    }
}

#[derive(Clone, Debug)]
pub(super) enum Call {
    AddShape(Shape),
    RemoveShape(ShapeId),
    AddBody(Body),
    RemoveBody(BodyId),
    KeepApart(BodyId, BodyId),
    AddJoint(Box<Joint>),
    RemoveJoint(JointId),
    SetPose(BodyId, Isometry3<f64>),
    SetVelocity(BodyId, Vector3<f64>, Vector3<f64>),
    Push(BodyId, Push, Vector3<f64>, Option<Point3<f64>>),
    SetMotors(Vec<MotorCommand>),
    Step(u32),
    MassProperties(BodyId),
    Keep,
    Restore(Bytes),
}

/// What to restore; `kept` counts the snapshots kept so far, from the last.
#[derive(Clone, Debug)]
pub(super) enum Bytes {
    Kept { kept: usize },
    OfAnEmptyWorld,
    Random(Vec<u8>),
    Cut { kept: usize, share: f64 },
    Flipped { kept: usize, share: f64, bit: u8 },
    Forged { kept: usize, changes: Vec<Change> },
}

/// What a forger does to the state in a snapshot; `share` says where, from 0 to 1.
#[derive(Clone, Debug)]
pub(super) enum Change {
    Byte { share: f64, byte: u8 },
    Word { share: f64, word: u32 },
    Number { share: f64, number: f64 },
    Cut { share: f64 },
    Append(Vec<u8>),
}

pub(super) fn number(sane: std::ops::Range<f64>) -> impl Strategy<Value = f64> + Clone {
    prop_oneof![40 => sane, 1 => select(&NASTY[..])]
}

pub(super) fn vector(sane: std::ops::Range<f64>) -> impl Strategy<Value = Vector3<f64>> + Clone {
    [number(sane.clone()), number(sane.clone()), number(sane)].prop_map(Vector3::from)
}

pub(super) fn rotation() -> impl Strategy<Value = UnitQuaternion<f64>> {
    let turn = -3.0..3.0;
    prop_oneof![
        20 => [turn.clone(), turn.clone(), turn]
            .prop_map(|[x, y, z]| UnitQuaternion::from_euler_angles(x, y, z)),
        1 => [number(-1.0..1.0), number(-1.0..1.0), number(-1.0..1.0), number(-1.0..1.0)]
            .prop_map(|[w, i, j, k]| UnitQuaternion::new_unchecked(Quaternion::new(w, i, j, k))),
    ]
}

pub(super) fn pose() -> impl Strategy<Value = Isometry3<f64>> {
    (vector(-1.0..1.0), rotation())
        .prop_map(|(position, rotation)| Isometry3::from_parts(position.into(), rotation))
}

pub(super) fn shape_id() -> impl Strategy<Value = ShapeId> + Clone {
    prop_oneof![20 => 0..14_u32, 1 => Just(u32::MAX)].prop_map(|slot| ShapeId { slot })
}

pub(super) fn body_id() -> impl Strategy<Value = BodyId> + Clone {
    prop_oneof![20 => 0..12_u32, 1 => Just(u32::MAX)].prop_map(|slot| BodyId { slot })
}

pub(super) fn joint_id() -> impl Strategy<Value = JointId> + Clone {
    prop_oneof![20 => 0..8_u32, 1 => Just(u32::MAX)].prop_map(|slot| JointId { slot })
}

pub(super) fn shape() -> impl Strategy<Value = Shape> {
    let size = || number(0.05..0.5);
    let along = || select(&[Lengthwise::X, Lengthwise::Y, Lengthwise::Z][..]);
    let points = |count| vec(vector(-0.5..0.5).prop_map(Point3::from), count);
    prop_oneof![
        (vector(-1.0..1.0), any::<bool>(), number(-1.0..1.0)).prop_map(|(normal, unit, offset)| {
            let normal =
                if unit { Unit::new_normalize(normal) } else { Unit::new_unchecked(normal) };
            Shape::Plane { normal, offset }
        }),
        [size(), size(), size()].prop_map(|half| Shape::Box { half_extents: half.into() }),
        size().prop_map(|radius| Shape::Sphere { radius }),
        [size(), size(), size()].prop_map(|radii| Shape::Ellipsoid { radii: radii.into() }),
        (size(), size(), along()).prop_map(|(radius, length, along)| Shape::Capsule {
            radius,
            length,
            along
        }),
        (size(), size(), along()).prop_map(|(radius, length, along)| Shape::Cylinder {
            radius,
            length,
            along
        }),
        (points(0..9), number(0.0..0.05))
            .prop_map(|(points, margin)| Shape::Hull { points, margin }),
        vec((shape_id(), pose()), 0..4).prop_map(|children| Shape::Compound { children }),
        (points(2..9), vec([0..9_u32, 0..9, 0..9], 0..9))
            .prop_map(|(vertices, triangles)| Shape::Mesh { vertices, triangles }),
    ]
}

pub(super) fn body() -> impl Strategy<Value = Body> {
    let filter = prop_oneof![
        4 => Just(CollisionFilter::moving()),
        1 => Just(CollisionFilter::still()),
        1 => (any::<i32>(), any::<i32>()).prop_map(|(group, mask)| CollisionFilter { group, mask }),
    ];
    let motion = select(&[Motion::Static, Motion::Dynamic, Motion::Dynamic, Motion::Kinematic][..]);
    let share = || number(0.0..1.0);
    (
        (shape_id(), motion, pose(), number(0.1..10.0)),
        option::weighted(0.3, vector(1e-3..1.0)),
        (share(), share(), share(), share(), share(), share(), filter),
    )
        .prop_map(|((shape, motion, pose, mass), inertia, surface)| {
            let (friction, rolling_friction, spinning_friction, ..) = surface;
            let (.., restitution, linear_damping, angular_damping, filter) = surface;
            Body {
                motion,
                inertia,
                friction,
                rolling_friction,
                spinning_friction,
                restitution,
                linear_damping,
                angular_damping,
                filter,
                ..Body::dynamic(shape, mass, pose)
            }
        })
}

pub(super) fn axis_settings(springs: bool) -> impl Strategy<Value = AxisSettings> {
    let range = prop_oneof![
        Just(Range::Locked),
        Just(Range::Free),
        [number(-1.0..0.2), number(-0.2..1.0)]
            .prop_map(|[lower, upper]| Range::Limited { lower, upper }),
    ];
    let motor = [number(-10.0..10.0), number(0.0..100.0)]
        .prop_map(|[target_velocity, max_force]| Motor { target_velocity, max_force });
    let spring = [number(0.0..100.0), number(0.0..10.0), number(-1.0..1.0)]
        .prop_map(|[stiffness, damping, equilibrium]| Spring { stiffness, damping, equilibrium });
    let spring = option::weighted(if springs { 0.3 } else { 0.01 }, spring);
    (range, stop(), option::weighted(0.5, motor), spring)
        .prop_map(|(range, stop, motor, spring)| AxisSettings { range, stop, motor, spring })
}

pub(super) fn stop() -> impl Strategy<Value = Stop> {
    let maybe = || option::weighted(0.3, number(0.0..1.0));
    (maybe(), maybe(), maybe()).prop_map(|(erp, cfm, bounce)| Stop { erp, cfm, bounce })
}

pub(super) fn joint() -> impl Strategy<Value = Joint> {
    let six = || axis_settings(true).boxed();
    let kind = prop_oneof![
        Just(JointKind::Fixed),
        Just(JointKind::PointToPoint),
        axis_settings(false).prop_map(JointKind::Hinge),
        (axis_settings(false), axis_settings(false), stop())
            .prop_map(|(linear, angular, held)| JointKind::Slider { linear, angular, held }),
        [six(), six(), six(), six(), six(), six()]
            .prop_map(|axes| JointKind::SixDofSpring(Box::new(axes))),
    ];
    (kind, body_id(), body_id(), pose(), pose(), any::<bool>()).prop_map(
        |(kind, parent, child, frame_in_parent, frame_in_child, collide_connected)| Joint {
            kind,
            parent,
            child,
            frame_in_parent,
            frame_in_child,
            collide_connected,
        },
    )
}

pub(super) fn bytes() -> impl Strategy<Value = Bytes> {
    let share = || 0.0..1.0_f64;
    let change = prop_oneof![
        4 => (share(), any::<u8>()).prop_map(|(share, byte)| Change::Byte { share, byte }),
        4 => (share(), prop_oneof![0..8_u32, any::<u32>()])
            .prop_map(|(share, word)| Change::Word { share, word }),
        4 => (share(), select(&NASTY[..]))
            .prop_map(|(share, number)| Change::Number { share, number }),
        1 => share().prop_map(|share| Change::Cut { share }),
        1 => vec(any::<u8>(), 1..40).prop_map(Change::Append),
    ];
    let kept = || 0..4_usize;
    prop_oneof![
        6 => kept().prop_map(|kept| Bytes::Kept { kept }),
        1 => Just(Bytes::OfAnEmptyWorld),
        1 => vec(any::<u8>(), 0..100).prop_map(Bytes::Random),
        1 => (kept(), share()).prop_map(|(kept, share)| Bytes::Cut { kept, share }),
        1 => (kept(), share(), 0..8_u8)
            .prop_map(|(kept, share, bit)| Bytes::Flipped { kept, share, bit }),
        8 => (kept(), vec(change, 0..4))
            .prop_map(|(kept, changes)| Bytes::Forged { kept, changes }),
    ]
}

pub(super) fn call() -> impl Strategy<Value = Call> {
    let push = select(&[Push::Force, Push::Torque, Push::Impulse, Push::AngularImpulse][..]);
    let point = option::of(vector(-1.0..1.0).prop_map(Point3::from));
    let command = (joint_id(), select(&Axis::ALL[..]), number(-10.0..10.0), number(0.0..100.0))
        .prop_map(|(joint, axis, target_velocity, max_force)| MotorCommand {
            joint,
            axis,
            target_velocity,
            max_force,
        });
    prop_oneof![
        3 => shape().prop_map(Call::AddShape),
        2 => shape_id().prop_map(Call::RemoveShape),
        4 => body().prop_map(Call::AddBody),
        2 => body_id().prop_map(Call::RemoveBody),
        2 => (body_id(), body_id()).prop_map(|(a, b)| Call::KeepApart(a, b)),
        4 => joint().prop_map(|joint| Call::AddJoint(Box::new(joint))),
        2 => joint_id().prop_map(Call::RemoveJoint),
        2 => (body_id(), pose()).prop_map(|(id, pose)| Call::SetPose(id, pose)),
        3 => (body_id(), vector(-5.0..5.0), vector(-5.0..5.0))
            .prop_map(|(id, linear, angular)| Call::SetVelocity(id, linear, angular)),
        3 => (body_id(), push, vector(-5.0..5.0), point)
            .prop_map(|(id, kind, vector, point)| Call::Push(id, kind, vector, point)),
        2 => vec(command, 0..3).prop_map(Call::SetMotors),
        8 => (1..5_u32).prop_map(Call::Step),
        1 => body_id().prop_map(Call::MassProperties),
        3 => Just(Call::Keep),
        4 => bytes().prop_map(Call::Restore),
    ]
}

pub(super) fn settings() -> impl Strategy<Value = WorldSettings> {
    use SolverMode as Mode;
    let modes = [
        Mode::default(),
        Mode::default() - Mode::WARM_STARTING,
        Mode::default() | Mode::TWO_FRICTION_DIRECTIONS,
        Mode::default() | Mode::TWO_FRICTION_DIRECTIONS | Mode::CACHED_FRICTION_DIRECTIONS,
        Mode::default() | Mode::FIXED_FRICTION_DIRECTIONS | Mode::TWO_FRICTION_DIRECTIONS,
        Mode::default() | Mode::INTERLEAVED_FRICTION,
        Mode::default() | Mode::RANDOM_ORDER | Mode::INTERLEAVED_FRICTION,
    ];
    let share = || number(0.0..1.0);
    (
        (vector(-10.0..10.0), number(1e-3..0.1), 1..10_u32, select(modes.to_vec())),
        (share(), share(), share(), number(-0.1..0.0), any::<bool>(), any::<bool>()),
    )
        .prop_map(|((gravity, time_step, iterations, solver_mode), rest)| {
            let (joint_erp, contact_erp, cfm, split_impulse_threshold, split_impulse, sleeping) =
                rest;
            WorldSettings {
                gravity,
                time_step,
                iterations,
                solver_mode,
                joint_erp,
                contact_erp,
                cfm,
                split_impulse,
                split_impulse_threshold,
                sleeping,
            }
        })
}
