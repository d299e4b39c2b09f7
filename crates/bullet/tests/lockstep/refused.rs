//! Worlds that can't be stepped together.

use super::*;

#[test]
fn worlds_that_do_not_match_are_refused() {
    let with = |settings: &WorldSettings, change: &dyn Fn(&mut World, BodyId, BodyId)| {
        let mut world = World::new(settings).unwrap();
        ground(&mut world);
        let (a, b) = (ball(&mut world, 0.1, 1.0, 1.0), ball(&mut world, 0.1, 1.0, 2.0));
        change(&mut world, a, b);
        world
    };
    let settings = WorldSettings::default();
    let join = |kind: JointKind| {
        move |world: &mut World, a: BodyId, b: BodyId| {
            let pose = Isometry3::identity();
            let joint = Joint::at(&pose, kind.clone(), (a, &pose), (b, &pose));
            world.add_joint(&joint).unwrap();
        }
    };
    let motor = Some(Motor { target_velocity: 1.0, max_force: 1.0 });
    let hinge = join(JointKind::Hinge(AxisSettings::limited(-1.0, 1.0)));
    let driven = join(JointKind::Hinge(AxisSettings { motor, ..AxisSettings::limited(-1.0, 1.0) }));
    let fixed = join(JointKind::Fixed);
    let another = |world: &mut World, _, _| {
        ball(world, 0.1, 1.0, 3.0);
    };
    let static_one = |world: &mut World, a, _| {
        world.remove_body(a).unwrap();
    };
    let fewer = WorldSettings { iterations: 50, ..Default::default() };
    let cold = WorldSettings {
        solver_mode: SolverMode::default() - SolverMode::WARM_STARTING,
        ..Default::default()
    };
    let plain = |_: &mut World, _, _| ();
    let cases: [(World, World, &str, &str); 6] = [
        (with(&settings, &plain), with(&fewer, &plain), "200 iterations", "50 iterations"),
        (with(&settings, &plain), with(&cold, &plain), "260 as solver mode", "256 as solver mode"),
        (with(&settings, &plain), with(&settings, &another), "3 bodies", "4 bodies"),
        (with(&settings, &plain), with(&settings, &static_one), "body 1 dynamic", "body 1 removed"),
        (with(&settings, &hinge), with(&settings, &fixed), "joint 0 hinge", "joint 0 fixed"),
        (
            with(&settings, &hinge),
            with(&settings, &driven),
            "joint 0 with axes r",
            "joint 0 with axes R",
        ),
    ];
    let mut lockstep = Lockstep::new().unwrap();
    for (mut one, mut other, first, second) in cases {
        let error = lockstep.step(&mut [&mut one, &mut other], &mut Vec::new()).unwrap_err();
        assert_eq!(
            error.to_string(),
            format!(
                "Lockstep::step: worlds[1] must be built like worlds[0], {first}, got {second}"
            )
        );
        assert_eq!((one.steps(), other.steps()), (0, 0), "none is stepped");
    }
}

#[test]
fn unknown_instructions_are_refused() {
    let error = "mmx".parse::<Instructions>().unwrap_err();
    assert_eq!(
        error.to_string(),
        "Lockstep::new: ITARL_INSTRUCTIONS must be plain, avx2 or avx512, got \"mmx\""
    );
    for instructions in Instructions::ALL {
        assert_eq!(instructions.name().parse::<Instructions>().unwrap(), instructions);
        assert_eq!(Lockstep::with(instructions).is_ok(), instructions.are_available());
    }
}
