//! The same calls give the same bits, whatever else happens in the program.
#![allow(clippy::unwrap_used, missing_docs)]

mod common;

use std::thread;

use bullet::WorldSettings;
use common::{Playground, assert_same, trajectory};

const STEPS: u32 = 250;

fn settings() -> WorldSettings {
    WorldSettings { iterations: 50, ..WorldSettings::default() }
}

fn alone() -> Vec<Vec<u64>> {
    trajectory(&mut Playground::new(&settings()), STEPS)
}

#[test]
fn a_world_repeats_itself() {
    assert_same(&alone(), &alone(), "run again");
}

#[test]
fn worlds_in_turns_do_not_notice_each_other() {
    let expected = alone();
    let mut one = Playground::new(&settings());
    let mut other = Playground::new(&settings());
    other.run(7); // not in step
    for (n, expected) in expected.iter().enumerate() {
        other.step();
        let got = trajectory(&mut one, 1);
        assert_same(&got, std::slice::from_ref(expected), &format!("step {n}"));
    }
}

#[test]
fn worlds_in_many_threads_do_not_notice_each_other() {
    let expected = alone();
    for threads in [2, 8] {
        let runs: Vec<_> = (0..threads).map(|_| thread::spawn(alone)).collect();
        for run in runs {
            assert_same(&run.join().unwrap(), &expected, &format!("one of {threads} threads"));
        }
    }
}

#[test]
fn a_world_can_move_between_threads() {
    let expected = alone();
    let mut world = Playground::new(&settings());
    let mut got = Vec::new();
    while got.len() < expected.len() {
        let part;
        (world, part) = thread::spawn(move || {
            let part = trajectory(&mut world, 10);
            (world, part)
        })
        .join()
        .unwrap();
        got.extend(part);
    }
    assert_same(&got, &expected, "moved every 10 steps");
}

/// Other addresses, in another order, for everything that Bullet allocates: what depends on them
/// shows here.
#[test]
fn the_heap_leaves_no_trace() {
    let expected = alone();
    for noise in 1..=6_usize {
        let mut blocks = Vec::new();
        let mut draw = 977 * noise;
        let mut make_noise = || {
            blocks.extend((0..2000).map(|i| vec![0xA5_u8; 16 * (i % 40) + 8]));
            for _ in 0..1500 {
                draw = draw * 75 % 65_537;
                blocks.swap_remove(draw % blocks.len());
            }
        };
        make_noise();
        let mut world = Playground::new(&settings());
        let mut got = Vec::new();
        for _ in 0..STEPS / 10 {
            make_noise();
            got.extend(trajectory(&mut world, 10));
        }
        assert_same(&got, &expected, &format!("with heap noise {noise}"));
    }
}
