//! A box falls flat onto the ground: height, velocity, and what carries it.
//!
//! ```text
//! cargo run -p bullet --example falling_box
//! ```
//!
//! While it falls, the velocity grows by g dt a step and nothing carries it. The step in which it
//! lands takes all of its momentum, many times the impulse of its weight. Bullet lets it sink in
//! by up to one step's travel and then pushes it out, by a fifth of the depth a step, so that for
//! a while the ground carries less than the weight; in the end the four corners together carry
//! m g dt, the impulse that gravity gives the box in a step.

use bullet::{Body, Shape, World, WorldSettings};
use nalgebra::{Isometry3, Vector3};

fn main() -> Result<(), bullet::Error> {
    let settings = WorldSettings::default();
    let mass = 2.0;
    let half_extents = Vector3::new(0.2, 0.15, 0.1);

    let mut world = World::new(&settings)?;
    // A slab, and not the half space of `Shape::ground`: with that one, Bullet finds a single
    // contact point a step, and what lands flat tips over it.
    let slab = world.add_shape(&Shape::Box { half_extents: Vector3::new(1.0, 1.0, 0.1) })?;
    let shape = world.add_shape(&Shape::Box { half_extents })?;
    world.add_body(&Body::fixed(slab, Isometry3::translation(0.0, 0.0, -0.1)))?;
    let start = Isometry3::translation(0.0, 0.0, half_extents.z + 0.5);
    let body = world.add_body(&Body::dynamic(shape, mass, start))?;

    let weight = mass * settings.gravity.norm() * settings.time_step;
    println!("A box of {mass} kg, dropped from 0.5 m. In a step of {} s", settings.time_step);
    println!("gravity gives it m g dt = {weight:.4} N s.\n");
    println!("  time   height  velocity  contacts  impulse  impulse");
    println!("     s        m       m/s                N s  / m g dt");

    let (mut bodies, mut contacts) = (Vec::new(), Vec::new());
    for step in 1..=60_u32 {
        world.step()?;
        world.read_bodies(&mut bodies)?;
        world.read_contacts(&mut contacts)?;
        let impulse = contacts.iter().fold(0.0, |sum, contact| sum + contact.impulse);
        let landing = (29..=36).contains(&step);
        if landing || step % 5 == 0 {
            let state = &bodies[body.index()];
            println!(
                "{:6.2}  {:7.4}  {:8.4}  {:8}  {:7.4}  {:7.3}",
                f64::from(step) * settings.time_step,
                state.position[2] - half_extents.z,
                state.linear_velocity[2],
                contacts.len(),
                impulse,
                impulse / weight,
            );
        }
    }
    Ok(())
}
