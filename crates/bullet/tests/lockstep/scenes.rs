//! Random scenes: small robots of every kind of joint, among things that they hit.

use super::*;

/// A small robot: a tree of bodies, each joined to one before it.
#[derive(Clone, Debug)]
struct Scene {
    parts: Vec<Part>,
    settings: WorldSettings,
    self_collision: bool,
    restitution: f64,
    paddle: bool,
    anchored: bool,
    seed: u64,
}

#[derive(Clone, Debug)]
struct Part {
    shape: Shape,
    mass: f64,
    parent: usize,
    kind: JointKind,
    turn: [f64; 3],
    friction: f64,
}

fn axis() -> impl Strategy<Value = AxisSettings> {
    let range = prop_oneof![
        Just(AxisSettings::free()),
        Just(AxisSettings::locked()),
        (0.0..0.6, 0.0..0.6).prop_map(|(a, b): (f64, f64)| AxisSettings::limited(-a, b)),
    ];
    let motor = (-4.0..4.0, 0.0..30.0)
        .prop_map(|(target_velocity, max_force)| Motor { target_velocity, max_force });
    let stop = |bounce: fn(f64) -> f64| {
        let setting = || option::of(prop_oneof![Just(0.0), Just(1.0), 0.0..1.0]);
        (setting(), option::of(select(vec![0.0, 0.0, 1e-4])), setting())
            .prop_map(move |(erp, cfm, back)| Stop { erp, cfm, bounce: back.map(bounce) })
    };
    (range, option::of(motor), stop(std::convert::identity))
        .prop_map(|(range, motor, stop)| AxisSettings { motor, stop, ..range })
}

/// Bullet's slider throws nothing back along its axis.
fn along() -> impl Strategy<Value = AxisSettings> {
    axis().prop_map(|axis| AxisSettings { stop: Stop { bounce: None, ..axis.stop }, ..axis })
}

fn sprung() -> impl Strategy<Value = AxisSettings> {
    let spring = (0.0..50.0, 0.0..1.0, -0.3..0.3)
        .prop_map(|(stiffness, damping, equilibrium)| Spring { stiffness, damping, equilibrium });
    (axis(), option::of(spring)).prop_map(|(axis, spring)| AxisSettings { spring, ..axis })
}

/// Those whose rows are made in lanes.
fn kind_in_lanes() -> impl Strategy<Value = JointKind> {
    prop_oneof![
        Just(JointKind::Fixed),
        (along(), axis(), along()).prop_map(|(linear, angular, held)| JointKind::Slider {
            linear,
            angular,
            held: held.stop
        }),
        [sprung(), sprung(), sprung(), sprung(), sprung(), sprung()]
            .prop_map(|axes| JointKind::SixDofSpring(Box::new(axes))),
    ]
}

fn any_kind() -> impl Strategy<Value = JointKind> {
    prop_oneof![
        1 => Just(JointKind::PointToPoint),
        1 => axis().prop_map(JointKind::Hinge),
        3 => kind_in_lanes(),
    ]
}

fn part(kind: impl Strategy<Value = JointKind>) -> impl Strategy<Value = Part> {
    let shape = prop_oneof![
        (0.05..0.2).prop_map(|radius| Shape::Sphere { radius }),
        (0.05..0.15, 0.1..0.4).prop_map(|(radius, length)| Shape::Capsule {
            radius,
            length,
            along: Lengthwise::Z
        }),
        (0.05..0.2, 0.05..0.2, 0.05..0.2)
            .prop_map(|(x, y, z)| Shape::Box { half_extents: Vector3::new(x, y, z) }),
    ];
    let turn = [-1.0..1.0, -1.0..1.0, -1.0..1.0];
    (shape, 0.1..5.0, any::<prop::sample::Index>(), kind, turn, select(vec![0.0, 0.5, 1.0]))
        .prop_map(|(shape, mass, parent, kind, turn, friction)| Part {
            shape,
            mass,
            parent: parent.index(1000),
            kind,
            turn,
            friction,
        })
}

fn scene(kind: impl Strategy<Value = JointKind>) -> impl Strategy<Value = Scene> {
    let mode = vec(any::<bool>(), 4).prop_map(|on| {
        let switches = [
            SolverMode::TWO_FRICTION_DIRECTIONS,
            SolverMode::INTERLEAVED_FRICTION,
            SolverMode::FIXED_FRICTION_DIRECTIONS,
        ];
        let cold = SolverMode::default() - SolverMode::WARM_STARTING;
        let start = if on[3] { cold } else { SolverMode::default() };
        switches.into_iter().zip(on).fold(start, |mode, (it, on)| if on { mode | it } else { mode })
    });
    let settings = (mode, 1_u32..60, select(vec![0.0, 0.0, 1e-4]), any::<bool>(), any::<bool>())
        .prop_map(|(solver_mode, iterations, cfm, split_impulse, sleeping)| WorldSettings {
            solver_mode,
            iterations,
            cfm,
            split_impulse,
            sleeping,
            ..WorldSettings::default()
        });
    let yes_or_no = any::<[bool; 3]>();
    (vec(part(kind), 2..8), settings, yes_or_no, select(vec![0.0, 0.5]), any::<u64>()).prop_map(
        |(parts, settings, [self_collision, paddle, anchored], restitution, seed)| Scene {
            parts,
            settings,
            self_collision,
            restitution,
            paddle,
            anchored,
            seed,
        },
    )
}

impl Scene {
    fn build(&self, number: usize) -> World {
        let mut world = World::new(&self.settings).unwrap();
        let floor = ground(&mut world);
        if self.paddle {
            let shape =
                world.add_shape(&Shape::Box { half_extents: Vector3::new(0.1, 1.0, 0.2) }).unwrap();
            world.add_body(&Body::kinematic(shape, paddle(0))).unwrap();
        }
        let mut placed: Vec<(BodyId, Isometry3<f64>)> = Vec::new();
        for (i, part) in self.parts.iter().enumerate() {
            let pose = Isometry3::from_parts(
                Translation3::new(0.3 * i as f64, 0.1 * (i % 3) as f64, 0.6 + 0.1 * i as f64),
                UnitQuaternion::from_euler_angles(part.turn[0], part.turn[1], part.turn[2]),
            );
            let shape = world.add_shape(&part.shape).unwrap();
            let filter = if self.self_collision {
                CollisionFilter::moving()
            } else {
                CollisionFilter { group: 64, mask: !64 }
            };
            let body = Body {
                friction: part.friction,
                restitution: self.restitution,
                filter,
                ..Body::dynamic(shape, part.mass, pose)
            };
            let id = world.add_body(&body).unwrap();
            let (parent, parent_pose) = match placed.len() {
                0 if self.anchored => (floor, Isometry3::identity()),
                0 => {
                    placed.push((id, pose));
                    continue;
                }
                n => placed[part.parent % n],
            };
            let frame = pose * Isometry3::translation(-0.15, 0.0, 0.0);
            let ends = ((parent, &parent_pose), (id, &pose));
            world.add_joint(&Joint::at(&frame, part.kind.clone(), ends.0, ends.1)).unwrap();
            placed.push((id, pose));
        }
        let spin = Vector3::new(number as f64, (self.seed % 7) as f64, -1.0);
        world.set_velocity(placed[0].0, &(0.3 * spin), &spin).unwrap();
        world
    }

    /// In the order of the joints.
    fn motors(&self) -> Vec<(JointId, Axis)> {
        let joined = self.parts.iter().skip(usize::from(!self.anchored));
        let driven = |(slot, part): (u32, &Part)| {
            let axes = match &part.kind {
                JointKind::Hinge(axis) => vec![(Axis::AngularZ, axis.motor)],
                JointKind::Slider { linear, angular, .. } => {
                    vec![(Axis::LinearX, linear.motor), (Axis::AngularX, angular.motor)]
                }
                JointKind::SixDofSpring(axes) => {
                    Axis::ALL.into_iter().zip(axes.iter().map(|axis| axis.motor)).collect()
                }
                _ => Vec::new(),
            };
            axes.into_iter()
                .filter(|(_, motor)| motor.is_some())
                .map(move |(axis, _)| (JointId { slot }, axis))
        };
        (0..).zip(joined).flat_map(driven).collect()
    }

    fn act(&self, number: usize, n: usize, world: &mut World) {
        if n % 7 == 3 {
            let phase = (n + 3 * number) as f64;
            let commands: Vec<MotorCommand> = self
                .motors()
                .into_iter()
                .map(|(joint, axis)| MotorCommand {
                    joint,
                    axis,
                    target_velocity: 3.0 * phase.sin(),
                    max_force: 10.0 * phase.cos().abs(),
                })
                .collect();
            world.set_motors(&commands).unwrap();
        }
        if self.paddle {
            world.set_pose(BodyId { slot: 1 }, &paddle(n + number)).unwrap();
        }
        if (n + number) % 17 == 5 {
            let last = BodyId { slot: 1 + u32::from(self.paddle) };
            let up = Vector3::new(1.0, number as f64 - 1.0, 6.0);
            world.push(last, Push::Impulse, &up, None).unwrap();
        }
    }
}

fn paddle(step: usize) -> Isometry3<f64> {
    let phase = (step % 100) as f64 / 50.0;
    let x = if phase < 1.0 { 2.0 * phase } else { 4.0 - 2.0 * phase };
    Isometry3::translation(x - 0.6, 0.0, 0.2)
}

/// In lanes as alone: several worlds, and one, which has a sweep of its own.
fn compare_scene(scene: &Scene) -> Result<(), TestCaseError> {
    // Wild robots may tear themselves apart, which another test is about.
    let survives = |i| {
        let mut world = scene.build(i);
        (0..60).all(|n| {
            scene.act(i, n, &mut world);
            world.step().is_ok()
        })
    };
    prop_assume!((0..3).all(survives));
    for (what, worlds) in [("random", 3), ("random, one", 1)] {
        compare(what, (worlds, 60), |i| scene.build(i), |i, n, world| scene.act(i, n, world));
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 75, ..ProptestConfig::default() })]

    #[test]
    fn random_robots_and_scenes(scene in scene(any_kind())) {
        compare_scene(&scene)?;
    }

    /// Most of these live in lanes from step to step.
    #[test]
    fn random_robots_in_lanes(scene in scene(kind_in_lanes())) {
        let scene = Scene { self_collision: false, paddle: false, anchored: false, ..scene };
        compare_scene(&scene)?;
    }
}
