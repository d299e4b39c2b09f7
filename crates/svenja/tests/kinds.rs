//! What each kind of joint, servo and shape does in a world, against closed forms.
#![cfg(feature = "bullet")]
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

use std::f64::consts::PI;

use bullet::{Push, World, WorldSettings};
use nalgebra::{Isometry3, Vector3};
use svenja::{Morphology, Readings, Robot, Shape, add_ground};

const DT: f64 = 0.01;

/// A base of 1000 kg, which hardly moves, and what hangs on it.
fn model(rest: &str) -> Morphology {
    let text = format!(
        "name = 'm'\nheading.body = 'base'\nfeet = ['base']\n{rest}\n\
         [[body]]\nname = 'base'\nmass_kg = 1000.0\nposition_m = [0.0, 0.0, 1.0]\n\
         shape = {{ kind = 'box', half_extents_m = [0.5, 0.5, 1.0] }}\n"
    );
    parse(&text)
}

fn parse(text: &str) -> Morphology {
    Morphology::parse("m.toml", text).unwrap_or_else(|problems| panic!("{problems}"))
}

/// A wheel of 1 kg m² about z, in front of the base, on a hinge whose axis is given.
fn wheel(servo: &str, axis: &str) -> Morphology {
    let kinds = ["hinge", "slider-hinge", "spherical", "general"];
    let kind = kinds.iter().find(|kind| servo.contains(&format!("# {kind}"))).unwrap_or(&"hinge");
    let axis = axis.replace("AXIS", "about = 'z'");
    model(&format!(
        "servo.motor = {{ {} }}\n\
         [[body]]\nname = 'wheel'\nmass_kg = 1.0\nposition_m = [0.0, 2.0, 1.0]\n\
         inertia_kg_m2 = [0.6, 0.6, 1.0]\n\
         [[joint]]\nname = 'turn'\nkind = '{kind}'\nparent = 'base'\nchild = 'wheel'\n\
         anchor_m = [0.0, 2.0, 0.0]\naxes = [{{ {axis} }}]\n",
        servo.split('#').next().unwrap_or_default()
    ))
}

struct Stage {
    world: World,
    robot: Robot,
    readings: Readings,
}

impl Stage {
    fn new(morphology: &Morphology, gravity: f64) -> Self {
        let gravity = Vector3::new(0.0, 0.0, -gravity);
        let mut world =
            World::new(&WorldSettings { gravity, time_step: DT, ..Default::default() }).unwrap();
        if gravity.z != 0.0 {
            add_ground(&mut world).unwrap();
        }
        let robot = Robot::spawn(morphology, &mut world).unwrap();
        Self { world, robot, readings: Readings::default() }
    }

    fn run(&mut self, commands: &[f64], steps: usize) {
        self.robot.actuate(commands).unwrap();
        self.robot.step(&mut self.world, steps).unwrap();
        self.sense();
    }

    fn sense(&mut self) {
        self.robot.sense(&self.world, &mut self.readings).unwrap();
    }

    fn spin(&self, part: usize) -> f64 {
        self.robot.velocities(part).1.z
    }
}

fn near(what: &str, found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() < tolerance, "{what}: {found}, not {expected}");
}

/// The base of 1000 kg has 167 kg m² and turns back by 0.6 % of what the wheel does.
const BASE: f64 = 0.01;
const KINDS: [&str; 4] = ["# hinge", "# slider-hinge", "# spherical", "# general"];

#[test]
fn a_servo_of_speed_turns_at_its_share_for_ever() {
    for kind in KINDS {
        let servo =
            format!("kind = 'speed', speed_limit_rad_s = 4.0, torque_limit_nm = 50.0 {kind}");
        let morphology = wheel(&servo, "AXIS, servo = 'motor'");
        let mut stage = Stage::new(&morphology, 0.0);
        let mut before = 0.0;
        for step in 1..=400 {
            stage.run(&[0.5], 1);
            if step < 20 {
                continue;
            }
            near(kind, stage.spin(0), 2.0, 2.0 * BASE);
            // The reading grows, and begins again at -1 after half a turn.
            let reading = stage.readings.values[0];
            assert!((-1.0..=1.0).contains(&reading) && !stage.readings.clipped[0]);
            let grown = reading - before;
            let grown = if grown < -1.0 { grown + 2.0 } else { grown };
            if step > 20 {
                near(kind, grown, 2.0 * DT / PI, 2e-4);
            }
            before = reading;
        }
        // Reversed, it's the other way.
        let morphology = wheel(&servo, "AXIS, servo = 'motor', reversed = true");
        let mut stage = Stage::new(&morphology, 0.0);
        stage.run(&[0.5], 50);
        near(kind, stage.spin(0), -2.0, 2.0 * BASE);
        assert!(stage.readings.values[0] > 0.0);
    }
}

#[test]
fn a_servo_of_torque_accelerates_up_to_its_speed_limit() {
    for kind in KINDS {
        let servo =
            format!("kind = 'torque', speed_limit_rad_s = 3.0, torque_limit_nm = 8.0 {kind}");
        let mut stage = Stage::new(&wheel(&servo, "AXIS, servo = 'motor'"), 0.0);
        stage.run(&[-0.5], 50);
        near(kind, stage.spin(0), -4.0 * 50.0 * DT, 2.0 * BASE);
        stage.run(&[0.0], 50);
        near("nothing drives it", stage.spin(0), -2.0, 2.0 * BASE);
        stage.run(&[1.0], 200);
        near("its limit", stage.spin(0), 3.0, 3.0 * BASE);
    }
}

#[test]
fn an_endless_axis_goes_to_its_target_by_the_short_way() {
    for kind in KINDS {
        let servo = format!("speed_limit_rad_s = 2.0, torque_limit_nm = 80.0 {kind}");
        let mut stage = Stage::new(&wheel(&servo, "AXIS, servo = 'motor'"), 0.0);
        stage.run(&[0.9], 400);
        near(kind, stage.readings.values[0], 0.9, 0.01);
        // From 162 to -162 degrees are 36, which take 0.4 s; the other way takes 2.8 s.
        stage.run(&[-0.9], 60);
        near(kind, stage.readings.values[0], -0.9, 0.01);
        stage.run(&[1.0], 60);
        near(kind, stage.readings.values[0].abs(), 1.0, 0.01);
    }
}

/// Bullet's own steps of a damped wheel: each takes d dt of the speed. Friction takes f dt.
#[test]
fn damping_and_friction_slow_a_wheel_down_and_friction_stops_it() {
    for kind in KINDS {
        let run = |axis: &str, steps: usize| {
            let unused = format!("speed_limit_rad_s = 1.0, torque_limit_nm = 1.0 {kind}");
            let mut stage = Stage::new(&wheel(&unused, axis), 0.0);
            let wheel = stage.robot.body_id(0);
            stage
                .world
                .set_velocity(wheel, &Vector3::zeros(), &Vector3::new(0.0, 0.0, 2.0))
                .unwrap();
            stage.run(&[], steps);
            stage.spin(0)
        };
        near(kind, run("AXIS", 100), 2.0, 1e-4);
        let expected = 2.0 * (1.0_f64 - 0.8 * DT).powi(100);
        near(kind, run("AXIS, damping_nms_rad = 0.8", 100), expected, 2.0 * BASE);
        near(kind, run("AXIS, friction_nm = 0.5", 100), 1.5, 2.0 * BASE);
        near(kind, run("AXIS, friction_nm = 0.5", 450), 0.0, 2.0 * BASE);
        // Damping that would stop it a hundred times over in a step.
        near(kind, run("AXIS, damping_nms_rad = 1e4", 3), 0.0, 2.0 * BASE);
    }
}

#[test]
fn a_servo_works_against_what_resists() {
    let servo = "kind = 'torque', speed_limit_rad_s = 100.0, torque_limit_nm = 8.0";
    let axis = "AXIS, servo = 'motor', friction_nm = 1.0, damping_nms_rad = 2.0";
    let mut stage = Stage::new(&wheel(servo, axis), 0.0);
    stage.run(&[0.1], 100);
    near("held by friction", stage.spin(0), 0.0, 1e-6);
    stage.run(&[1.0], 600);
    near("(8 - 1) / 2", stage.spin(0), 3.5, 0.05);
}

/// A weight of 2 kg on a vertical slider.
fn lift(axis: &str) -> Morphology {
    model(&format!(
        "servo.lift = {{ speed_limit_m_s = 0.5, force_limit_n = 100.0 }}\n\
         [[body]]\nname = 'weight'\nmass_kg = 2.0\nposition_m = [0.0, 2.0, 2.0]\n\
         inertia_kg_m2 = [0.1, 0.1, 0.1]\n\
         [[joint]]\nname = 'lift'\nkind = 'slider'\nparent = 'base'\nchild = 'weight'\n\
         anchor_m = [0.0, 2.0, 1.0]\naxes = [{{ along = 'z', {axis} }}]\n"
    ))
}

#[test]
fn a_slider_slides_in_metres() {
    let mut stage = Stage::new(&lift("range_m = [-0.2, 0.6], servo = 'lift'"), 9.81);
    stage.run(&[-1.0], 1);
    let start = stage.robot.pose(0).translation.z;
    near("the middle is 0.2 m, 0 is half-way from it", stage.readings.values[0], -0.5, 0.05);
    stage.run(&[1.0], 100);
    near("half a metre in a second", stage.robot.pose(0).translation.z - start, 0.5, 0.03);
    stage.run(&[1.0], 100);
    // The base gives in a little, which holds its weight 2 m away.
    near("to the end", stage.robot.pose(0).translation.z, 2.6, 0.02);
    near("to the end", stage.readings.values[0], 1.0, 0.05);
    assert!(stage.robot.pose(0).rotation.angle() < 0.01, "and turns in no direction");
}

#[test]
fn a_slider_hangs_on_its_spring_and_stops_at_its_ends() {
    let spring = "spring = { stiffness_n_m = 200.0, damping_ns_m = 30.0 }";
    let mut stage = Stage::new(&lift(&format!("range_m = [-0.5, 0.5], {spring}")), 9.81);
    stage.run(&[], 400);
    near("m g / k", stage.robot.pose(0).translation.z, 2.0 - 2.0 * 9.81 / 200.0, 0.005);
    let mut stage = Stage::new(&lift("range_m = [-0.3, 0.0], stop_margin_m = 0.1"), 9.81);
    stage.run(&[], 400);
    near("beyond its range", stage.robot.pose(0).translation.z, 1.6, 0.005);
    assert_eq!((stage.readings.values[0], stage.readings.clipped[0]), (-1.0, true));
    let mut stage = Stage::new(&lift("range_m = [-0.3, 0.0], friction_n = 25.0"), 9.81);
    stage.run(&[], 400);
    near("held by friction", stage.robot.pose(0).translation.z, 2.0, 0.005);
}

#[test]
fn the_world_holds_the_root_where_start_puts_it() {
    let text = |kind: &str, axes: &str| {
        format!(
            "name = 'm'\nheading.body = 'arm'\nself_collision = true\n\
             start = {{ position_m = [1.0, 2.0, 3.0], rotation_deg = [0.0, 0.0, 90.0] }}\n\
             [[body]]\nname = 'arm'\nmass_kg = 1.0\nposition_m = [0.5, 0.0, 0.0]\n\
             shape = {{ kind = 'box', half_extents_m = [0.5, 0.05, 0.05] }}\n\
             [[joint]]\nname = 'base'\nkind = '{kind}'\nparent = 'world'\nchild = 'arm'\n\
             anchor_m = [0.0, 0.0, 0.0]\n{axes}"
        )
    };
    let fixed = parse(&text("fixed", ""));
    assert_eq!(fixed.degrees_of_freedom(), 0);
    let mut stage = Stage::new(&fixed, 9.81);
    stage.run(&[], 200);
    let held = stage.robot.pose(0);
    let expected = fixed.start() * Isometry3::translation(0.5, 0.0, 0.0);
    assert!((held.to_matrix() - expected.to_matrix()).norm() < 1e-3, "{held}");

    // A pendulum swings to the other side; a rod's period is 2π √(2l/3g) at small angles.
    let hinge = parse(&text("hinge", "axes = [{ about = 'y' }]"));
    assert_eq!(hinge.degrees_of_freedom(), 1);
    let mut stage = Stage::new(&hinge, 9.81);
    let mut lowest = f64::INFINITY;
    for _ in 0..200 {
        stage.run(&[], 1);
        let pose = stage.robot.pose(0);
        lowest = lowest.min(pose.translation.z);
        near("its anchor", (pose * nalgebra::Point3::new(-0.5, 0.0, 0.0)).z, 3.0, 0.01);
    }
    near("half its length below", lowest, 2.5, 0.02);
}

#[test]
fn what_has_no_shape_touches_nothing_and_what_is_kept_apart_not_each_other() {
    let text = |no_collision: &str, shape: &str| {
        format!(
            "name = 'm'\nheading.body = 'a'\nself_collision = true\n{no_collision}\n\
             [[body]]\nname = 'a'\nmass_kg = 1.0\nposition_m = [0.0, 0.0, 0.1]\n\
             shape = {{ kind = 'box', half_extents_m = [0.3, 0.3, 0.1] }}\n\
             [[body]]\nname = 'link'\nmass_kg = 0.1\nposition_m = [0.0, 0.0, 0.5]\n\
             inertia_kg_m2 = [0.01, 0.01, 0.01]\n\
             [[body]]\nname = 'b'\nmass_kg = 1.0\nposition_m = [0.0, 0.0, 0.8]\n\
             inertia_kg_m2 = [0.01, 0.01, 0.01]\n{shape}\n\
             [[joint]]\nname = 'j'\nkind = 'slider'\nparent = 'a'\nchild = 'link'\n\
             anchor_m = [0.0, 0.0, 0.4]\naxes = [{{ along = 'z', range_m = [-1.0, 1.0], damping_ns_m = 5.0 }}]\n\
             [[joint]]\nname = 'k'\nkind = 'fixed'\nparent = 'link'\nchild = 'b'\n\
             anchor_m = [0.0, 0.0, 0.3]\n"
        )
    };
    let box_ = "shape = { kind = 'box', half_extents_m = [0.1, 0.1, 0.1] }";
    let fallen = |text: &str| {
        let mut stage = Stage::new(&parse(text), 9.81);
        stage.run(&[], 500);
        (stage.robot.pose(2).translation.z, stage.robot.touches(2))
    };
    let (height, touches) = fallen(&text("", box_));
    near("on the other", height, 0.3, 0.01);
    assert!(!touches, "parts of the robot don't count");
    let (height, touches) = fallen(&text("no_collision = [['b', 'a']]", box_));
    near("on the ground", height, 0.1, 0.03);
    assert!(touches);
    // To the end of the slider.
    let (height, touches) = fallen(&text("", ""));
    near("below it", height, -0.2, 0.01);
    assert!(!touches);
}

/// A box that lies off the centre of mass falls over to the side of the mass.
#[test]
fn shapes_lie_where_they_are_put() {
    let text = |shapes: &str| {
        format!(
            "name = 'm'\nheading.body = 'a'\nmirror = {{ from = 'left', to = 'right' }}\n\
             [[body]]\nname = 'a'\nmass_kg = 1.0\nposition_m = [0.0, 0.0, 0.5]\n{shapes}\n\
             [[mesh]]\nfile = 'wedge.stl'\n\
             points = [[0, 0, 0], [100, 0, 0], [0, 100, 0], [0, 0, 100]]\n"
        )
    };
    let height = |shapes: &str| {
        let mut stage = Stage::new(&parse(&text(shapes)), 9.81);
        stage.run(&[], 300);
        stage.robot.pose(0)
    };
    let ball = height("shape = { kind = 'sphere', radius_m = 0.1, position_m = [0.0, 0.0, 0.2] }");
    // Its mass is at its side, and goes down: 0.2 m below the middle of the ball is in the ground.
    near("a ball on its weight", ball.translation.z, -0.1, 0.02);
    let turned = "half_extents_m = [0.1, 0.2, 0.3], rotation_deg = [90.0, 0.0, 0.0]";
    let lies = height(&format!("shape = {{ kind = 'box', {turned} }}"));
    near("turned by a quarter", lies.translation.z, 0.2, 0.005);
    let given = "inertia_kg_m2 = [0.04, 0.04, 0.02]";
    let lies = height(&format!("{given}\nshape = {{ kind = 'box', {turned} }}"));
    near("whatever the inertia", lies.translation.z, 0.2, 0.005);
    let two = "shapes = [{ kind = 'sphere', radius_m = 0.1, position_m = [-0.4, 0.0, 0.0] }, \
               { kind = 'sphere', radius_m = 0.1, position_m = [0.4, 0.0, 0.0] }, \
               { kind = 'ellipsoid', radii_m = [0.1, 0.3, 0.05] }]";
    near("on two balls", height(two).translation.z, 0.1, 0.005);
    let hull = "inertia_kg_m2 = [0.001, 0.001, 0.001]\n\
                shape = { kind = 'hull', file = 'wedge.stl', scale = [0.002, 0.002, 0.001], \
                position_m = [-0.05, -0.05, -0.02] }";
    near("a wedge on its largest side", height(hull).translation.z, 0.02, 0.005);
}

#[test]
fn mirror_images_of_shapes_are_mirrored() {
    let morphology = parse(
        "name = 'm'\nheading.body = 'trunk'\nmirror = { from = 'left', to = 'right' }\n\
         no_collision = [['left', 'right']]\n\
         [[body]]\nname = 'trunk'\nmass_kg = 1.0\nshape = { kind = 'sphere', radius_m = 0.1 }\n\
         [[body]]\nname = 'left'\nmass_kg = 1.0\nposition_m = [-0.5, 0.2, 0.0]\n\
         rotation_deg = [10.0, 20.0, 30.0]\ninertia_kg_m2 = [0.1, 0.2, 0.25]\n\
         shapes = [{ kind = 'box', half_extents_m = [0.1, 0.2, 0.3], position_m = [-0.1, 0.0, 0.2], \
         rotation_deg = [40.0, 0.0, -70.0] }, { kind = 'hull', file = 'wedge.stl', scale = 0.1 }]\n\
         [[mesh]]\nfile = 'wedge.stl'\npoints = [[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]]\n\
         [[joint]]\nname = 'left'\nkind = 'fixed'\nparent = 'trunk'\nchild = 'left'\n\
         anchor_m = [0.0, 0.0, 0.0]\n",
    );
    let [_, left, right] = morphology.bodies() else { panic!("three bodies") };
    assert_eq!(left.inertia_kg_m2, right.inertia_kg_m2);
    for (a, b) in left.colliders.iter().zip(&right.colliders) {
        // Each corner's image is a corner of the image.
        let corners = |body: &svenja::Body, collider: &svenja::Collider| -> Vec<_> {
            let (points, _) = collider.shape.outline_m();
            points.iter().map(|point| body.pose * (collider.pose * point)).collect()
        };
        let images = corners(right, b);
        for corner in corners(left, a) {
            let image = nalgebra::Point3::new(-corner.x, corner.y, corner.z);
            let away = images.iter().map(|it| (it - image).norm()).fold(f64::INFINITY, f64::min);
            assert!(away < 1e-14, "{image} isn't in {images:?}");
        }
        let volume = |shape: &Shape| shape.volume_m3();
        near("volume", volume(&a.shape), volume(&b.shape), 1e-15);
    }
    assert_eq!(morphology.no_collision(), [[1, 2]]);
}

#[test]
fn moments_that_nothing_has_are_warned_of() {
    let warnings = |moments: &str| {
        let text = format!(
            "name = 'm'\nheading.body = 'a'\n[[body]]\nname = 'a'\nmass_kg = 1.0\n\
             inertia_kg_m2 = {moments}\n"
        );
        parse(&text).warnings().to_vec()
    };
    assert_eq!(warnings("[1.0, 2.0, 3.0]"), []);
    let [warning] = &warnings("[1.0, 2.0, 3.5]")[..] else { panic!("none") };
    let expected = "m.toml:6:17: body 'a': inertia_kg_m2: no solid has a moment of 3.5 beside two that \
                    are 3 together";
    assert_eq!(warning.to_string(), expected);
}

/// A push against what a servo of torque leaves free.
#[test]
fn an_axis_without_a_command_is_free_or_held_as_its_servo_is() {
    for (kind, expected) in [("torque", 1.0), ("speed", 0.0), ("position", 0.0)] {
        let servo = format!("kind = '{kind}', speed_limit_rad_s = 4.0, torque_limit_nm = 500.0");
        let mut stage = Stage::new(&wheel(&servo, "AXIS, servo = 'motor'"), 0.0);
        let wheel = stage.robot.body_id(0);
        stage.world.push(wheel, Push::AngularImpulse, &Vector3::z(), None).unwrap();
        stage.robot.step(&mut stage.world, 5).unwrap();
        stage.sense();
        near(kind, stage.spin(0), expected, 0.05);
    }
}
