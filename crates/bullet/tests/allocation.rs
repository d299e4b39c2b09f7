//! Commanding, stepping and reading allocate nothing on the Rust side, once the buffers are there.
//! (Bullet's own heap isn't counted: it doesn't go through Rust's allocator.)
#![allow(clippy::unwrap_used, missing_docs)]

mod common;

use bullet::WorldSettings;
use common::{Playground, Readings};

#[test]
fn a_step_allocates_nothing() {
    let mut playground = Playground::new(&WorldSettings { iterations: 5, ..Default::default() });
    // A world that doesn't has none to read, which is an error, with a text.
    playground.world.measure_motors(true);
    let mut readings = Readings::default();
    // Buffers as long as they get, and longer where that's up to the contacts.
    playground.run(300);
    readings.read(&playground.world);
    readings.contacts.reserve(1000);
    let mut bytes = Vec::new();
    playground.world.snapshot(&mut bytes).unwrap();
    bytes.reserve(1_000_000);

    let commands = playground.motor_commands();
    let counted = allocation_counter::measure(|| {
        for _ in 0..50 {
            playground.world.set_motors(&commands).unwrap();
            playground.world.step().unwrap();
            readings.read(&playground.world);
        }
        playground.world.snapshot(&mut bytes).unwrap();
    });
    assert!(!readings.contacts.is_empty());
    assert_eq!(counted.count_total, 0, "{counted:?}");
}
