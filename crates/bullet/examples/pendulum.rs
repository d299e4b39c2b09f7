//! A pendulum with a servo in its hinge follows a target, as far as its torque goes.
//!
//! ```text
//! cargo run -p bullet --example pendulum
//! ```
//!
//! The chart shows the angle (`*`) and its target (`|`) over time, 0 hanging down. The target
//! steps to 30°, to -60° and to 90°. The servo sets the motor's velocity in every step, in
//! proportion to what is left of the way, and may use 0.9 m g l: enough for the first two, where
//! it needs m g l sin(30°) and m g l sin(60°), and too little to hold the arm level, so it hangs
//! where sin(angle) = 0.9, at 64°: the arm swings up to level, can't stay, and goes on swinging
//! about that angle.

use std::f64::consts::{FRAC_PI_2, PI};

use bullet::{
    Axis, AxisSettings, Body, Joint, JointKind, Motor, MotorCommand, Shape, World, WorldSettings,
};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

/// Columns of the chart, from -90° to 120°.
const WIDTH: usize = 71;
const STEPS_PER_LINE: u32 = 10;

fn main() -> Result<(), bullet::Error> {
    let settings = WorldSettings::default();
    let (mass, length) = (1.0, 0.5);
    let load = mass * settings.gravity.norm() * length;
    let max_force = 0.9 * load;

    let mut world = World::new(&settings)?;
    let small = world.add_shape(&Shape::Sphere { radius: 0.02 })?;
    let rod = world.add_shape(&Shape::Box { half_extents: Vector3::new(0.02, 0.02, length) })?;
    let pivot = Isometry3::translation(0.0, 0.0, 2.0);
    let hanging = Isometry3::translation(0.0, 0.0, 2.0 - length);
    let post = world.add_body(&Body::fixed(small, pivot))?;
    let arm = world.add_body(&Body::dynamic(rod, mass, hanging))?;

    // A hinge turns about its frame's z axis; here that's the world's y axis.
    let frame = pivot * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), -FRAC_PI_2);
    let motor = Some(Motor { target_velocity: 0.0, max_force });
    let hinge = JointKind::Hinge(AxisSettings { motor, ..AxisSettings::free() });
    let joint = world.add_joint(&Joint::at(&frame, hinge, (post, &pivot), (arm, &hanging)))?;

    println!(
        "A rod of {mass} kg, {} m long, and a servo of at most {max_force:.2} N m",
        2.0 * length
    );
    println!("where m g l = {load:.2} N m.\n");
    println!("time  target   angle  velocity");
    println!("   s     deg     deg     deg/s  {}", ruler());

    let mut joints = Vec::new();
    for step in 0..600_u32 {
        world.read_joints(&mut joints)?;
        let state = &joints[joint.index()];
        let angle = state.position_of(Axis::AngularZ);
        let target = match step / 150 {
            0 => PI / 6.0,
            1 => -PI / 3.0,
            _ => FRAC_PI_2,
        };
        if step % STEPS_PER_LINE == 0 {
            println!(
                "{:4.1}  {:6.1}  {:6.1}  {:8.1}  {}",
                f64::from(step) * settings.time_step,
                target.to_degrees(),
                angle.to_degrees(),
                state.velocity_of(Axis::AngularZ).to_degrees(),
                strip(angle, target),
            );
        }
        let target_velocity = (10.0 * (target - angle)).clamp(-4.0, 4.0);
        let command = MotorCommand { joint, axis: Axis::AngularZ, target_velocity, max_force };
        world.set_motors(&[command])?;
        world.step()?;
    }
    Ok(())
}

/// The column of an angle in the chart.
fn column(angle: f64) -> usize {
    let column = (angle.to_degrees() + 90.0) / 3.0;
    column.round().clamp(0.0, (WIDTH - 1) as f64) as usize
}

fn ruler() -> String {
    let mut line = String::new();
    for degrees in (-90..=120).step_by(30) {
        line.push_str(&format!("{degrees:<10}"));
    }
    line.trim_end().to_owned()
}

/// One line of the chart.
fn strip(angle: f64, target: f64) -> String {
    let mut line = [' '; WIDTH];
    line[column(0.0)] = '.';
    line[column(target)] = '|';
    line[column(angle)] = '*';
    let line: String = line.iter().collect();
    line.trim_end().to_owned()
}
