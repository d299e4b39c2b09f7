//! Stopped anywhere and gone on with, a cell has the same bits; what isn't its checkpoint is refused.

use proptest::prelude::*;
use runs::{Checkpoint, Extent, Header};

use super::*;

/// A checkpoint of a session, as a file would have it.
fn saved(session: &mut Session) -> Checkpoint {
    let (updates, control_steps) = (session.updates(), session.control_steps());
    let header = Header { identity: 0, updates, control_steps, metrics: Extent::empty() };
    Checkpoint { header, sections: session.save().unwrap() }
}

/// The same cell, begun anew and brought to a checkpoint.
fn restored(worlds: usize, checkpoint: &Checkpoint) -> Result<Session, Error> {
    let mut session = build(worlds);
    session.restore(checkpoint)?;
    Ok(session)
}

/// Three updates, left and gone on with after these control steps.
fn interrupted(worlds: usize, stops: &[usize]) -> (Vec<Row>, Checkpoint) {
    let mut session = settled(worlds);
    let mut rows = Vec::new();
    for step in 1..=3 * T {
        advance(&mut session);
        if session.is_to_learn() {
            rows.push(session.learn().unwrap());
        }
        if stops.contains(&step) {
            session = restored(worlds, &saved(&mut session)).unwrap();
        }
    }
    (rows, saved(&mut session))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn stopped_at_any_control_step_it_goes_on_with_the_same_bits(
        stops in proptest::collection::vec(1..3 * T, 1..6),
        worlds in prop_oneof![Just(1), Just(3), Just(EVOLVING)],
    ) {
        // As text, in which what isn't known, NaN, is the same.
        let [found, expected] = [&stops[..], &[]].map(|it| format!("{:?}", interrupted(worlds, it)));
        prop_assert_eq!(found, expected);
    }
}

#[test]
fn a_checkpoint_has_a_tally_within_an_update_and_there_alone() {
    let (mut session, _) = session();
    let sections = |session: &mut Session| saved(session).sections.into_keys().collect::<Vec<_>>();
    let between = [
        "chains",
        "estimator",
        "inputs",
        "optimiser",
        "parameters",
        "recording",
        "reward",
        "world",
    ];
    assert_eq!(sections(&mut session), between);
    advance(&mut session);
    assert!(sections(&mut session).iter().any(|name| name == "tally"));
    while !session.is_to_learn() {
        advance(&mut session);
    }
    session.learn().unwrap();
    assert_eq!(sections(&mut session), between);
}

#[test]
fn a_checkpoint_whose_numbers_do_not_fit_each_other_is_refused() {
    let (mut session, _) = session();
    for _ in 0..T / 2 {
        advance(&mut session);
    }
    let whole = saved(&mut session);
    let refused = |change: &dyn Fn(&mut Checkpoint), message: &str| {
        let mut checkpoint = whole.clone();
        change(&mut checkpoint);
        let error = restored(1, &checkpoint).err().unwrap().to_string();
        assert!(error.contains(message), "{error}");
    };
    refused(&|it| it.header.control_steps += 1, "'estimator' doesn't fit: 30 control steps");
    refused(&|it| it.header.control_steps += T as u64, "'estimator' doesn't fit");
    refused(&|it| it.header.updates += 1, "has 30 with 1 updates of 60");
    for updates in [u64::MAX, u64::MAX / T as u64, 6_735_281_601_315_911_789] {
        refused(&|it| it.header.updates = updates, "'estimator' doesn't fit");
    }
    refused(&|it| drop(it.sections.remove("tally")), "'tally' doesn't fit: it's missing");
}
