//! A reading and its values allocate nothing, in a new window or an old one, in tables or hash
//! tables.
#![allow(clippy::unwrap_used, missing_docs)]

mod common;

use common::Random;
use infotheory::{Binning, Estimator, Window, WindowSettings, each_sensor};

#[test]
fn a_step_allocates_nothing() {
    let settings = WindowSettings { pairs: 100, lag: 2, past: 2 };
    let mut groups = each_sensor(4);
    groups.push(vec![0, 1, 2, 3]);
    let radices = [2, 4, 1 << 20, u64::MAX];
    let mut window = Window::new(settings, &radices, &groups).unwrap();
    let mut random = Random::new(1);
    let binning = Binning::new(2).unwrap();
    let counted = allocation_counter::measure(|| {
        let mut bits = [false; 4];
        for _ in 0..20_000 {
            binning.encode(&[0.1, -0.7], &mut bits).unwrap();
            // All but always new states: the hash tables turn over all the time.
            window.push(&radices.map(|radix| random.below(radix))).unwrap();
            let sum = window.share_of_maximum(Estimator::PlugIn)
                + window.mean_mutual_information(Estimator::MillerMadow).nats();
            assert!(sum.is_finite());
        }
        window.clear();
    });
    assert_eq!(counted.count_total, 0, "{counted:?}");
}
