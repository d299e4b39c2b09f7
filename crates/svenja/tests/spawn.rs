//! Whatever model is accepted can be built: what Bullet can't do is refused in the file, with its
//! place.
//!
//! `PROPTEST_CASES` sets the number of random models.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

use std::{cell::Cell, fmt::Write};

use bullet::{World, WorldSettings};
use proptest::{
    prelude::*,
    sample::select,
    test_runner::{RngSeed, TestRunner},
};
use svenja::{Morphology, Robot, add_ground};

/// A number between bounds: often one of them, and of any size.
fn between(low: f64, high: f64) -> BoxedStrategy<f64> {
    let (small, large) = (low.max(high * 1e-12), high);
    let any_size = (small.ln()..=large.ln()).prop_map(move |it| it.exp().clamp(low, high));
    prop_oneof![2 => Just(low), 2 => Just(high), 3 => any_size, 3 => low..=high].boxed()
}

/// Three of them, of either sign.
fn point(most: f64) -> impl Strategy<Value = String> {
    let number = (between(0.0, most), any::<bool>());
    [number.clone(), number.clone(), number].prop_map(|numbers| {
        let signed = numbers.map(|(size, down)| if down { -size } else { size });
        format!("{signed:?}")
    })
}

fn shape() -> impl Strategy<Value = String> {
    let size = || between(1e-4, 1e3);
    let rod = (select(&["capsule", "cylinder"][..]), size(), point(1e3), point(1e3));
    prop_oneof![
        [size(), size(), size()].prop_map(|it| format!("kind = 'box', half_extents_m = {it:?}")),
        size().prop_map(|it| format!("kind = 'sphere', radius_m = {it:?}")),
        rod.prop_map(|(kind, radius, from, to)| {
            format!("kind = '{kind}', radius_m = {radius:?}, from_m = {from}, to_m = {to}")
        }),
    ]
}

fn body() -> impl Strategy<Value = String> {
    let numbers = (between(1e-6, 1e6), between(0.0, 10.0));
    (numbers, point(1e3), point(360.0), shape()).prop_map(
        |((mass, friction), position, rotation, shape)| {
            format!(
                "mass_kg = {mass:?}\nfriction = {friction:?}\nposition_m = {position}\n\
                 rotation_deg = {rotation}\nshape = {{ {shape} }}\n"
            )
        },
    )
}

/// In degrees and with one decimal, whose sum in radians may be a rounding beyond the whole.
fn range_and_margin() -> impl Strategy<Value = String> {
    let farthest = prop_oneof![2 => Just(900_i32), 2 => Just(1800), 1 => 1..=1800];
    (farthest, 0.0..=1.0_f64, 0.0..=1.0_f64, any::<bool>()).prop_map(
        |(farthest, part, other, down)| {
            let reach = (f64::from(farthest) * part).ceil().max(1.0);
            let margin = (f64::from(farthest) - reach) / 10.0;
            let (reach, other) = (reach / 10.0, (reach * other).floor() / 10.0);
            let range = if down { [-reach, other] } else { [-other, reach] };
            format!("range_deg = {range:?}, stop_margin_deg = {margin:?}")
        },
    )
}

/// What stands between the braces of an axis.
fn axis(about: &'static str) -> impl Strategy<Value = String> {
    (range_and_margin(), select(&["", ", servo = 'motor'"][..]))
        .prop_map(move |(range, servo)| format!("about = '{about}', {range}{servo}"))
}

fn sprung(axis: impl Strategy<Value = String>) -> impl Strategy<Value = String> {
    let spring = (between(0.0, 1e9), between(0.0, 1e9)).prop_map(|(stiffness, damping)| {
        format!(", spring = {{ stiffness_nm_rad = {stiffness:?}, damping_nms_rad = {damping:?} }}")
    });
    (axis, proptest::option::of(spring))
        .prop_map(|(axis, spring)| format!("{{ {axis}{} }}", spring.unwrap_or_default()))
}

fn joint() -> impl Strategy<Value = String> {
    let one = || select(&["x", "y", "z"][..]).prop_flat_map(axis);
    let several = proptest::sample::subsequence(vec!["x", "y", "z"], 1..=3)
        .prop_flat_map(|turns| turns.into_iter().map(|it| sprung(axis(it))).collect::<Vec<_>>())
        .prop_map(|axes| format!("kind = 'spherical'\naxes = [{}]", axes.join(", ")));
    let kind = prop_oneof![
        1 => Just("kind = 'fixed'".to_owned()),
        1 => one().prop_map(|axis| format!("kind = 'hinge'\naxes = [{{ {axis} }}]")),
        1 => one().prop_map(|axis| format!("kind = 'slider-hinge'\naxes = [{{ {axis} }}]")),
        3 => several,
    ];
    let stop = [between(0.0, 1.0), between(0.0, 1.0), between(0.0, 1.0)];
    (kind, point(1e3), point(360.0), stop).prop_map(|(kind, anchor, frame, [erp, cfm, bounce])| {
        format!(
            "{kind}\nanchor_m = {anchor}\nframe_deg = {frame}\n\
             stop = {{ erp = {erp:?}, cfm = {cfm:?}, bounce = {bounce:?} }}\n"
        )
    })
}

/// A tree of up to five bodies, each on one of those before it.
fn model() -> impl Strategy<Value = String> {
    let hanging = (body(), joint(), any::<proptest::sample::Index>());
    let rest = proptest::collection::vec(hanging, 0..5);
    let whole = (point(1e3), point(360.0), any::<bool>(), [between(1e-9, 1e9), between(1e-9, 1e9)]);
    (whole, body(), rest).prop_map(|(whole, root, rest)| {
        let (position, rotation, collides, [speed, torque]) = whole;
        let mut text = format!(
            "name = 'random'\nself_collision = {collides}\nheading.body = 'b0'\n\
             start = {{ position_m = {position}, rotation_deg = {rotation} }}\n\
             servo.motor = {{ speed_limit_rad_s = {speed:?}, torque_limit_nm = {torque:?} }}\n\
             [[body]]\nname = 'b0'\n{root}"
        );
        for (i, (body, joint, parent)) in rest.iter().enumerate() {
            let (child, parent) = (i + 1, parent.index(i + 1));
            let joint = format!("parent = 'b{parent}'\nchild = 'b{child}'\n{joint}");
            write!(text, "[[body]]\nname = 'b{child}'\n{body}[[joint]]\nname = 'j{i}'\n{joint}")
                .unwrap();
        }
        text
    })
}

#[test]
fn what_is_accepted_can_be_built() {
    let (built, refused) = (Cell::new(0), Cell::new(0));
    let one = |text: String| {
        let Ok(model) = Morphology::parse("random.toml", &text) else {
            refused.set(refused.get() + 1);
            return Ok(());
        };
        let mut world = World::new(&WorldSettings::default()).unwrap();
        add_ground(&mut world).unwrap();
        if let Err(error) = Robot::spawn(&model, &mut world) {
            return Err(TestCaseError::fail(format!("{error}\n{text}")));
        }
        built.set(built.get() + 1);
        Ok(())
    };
    let mut config = ProptestConfig { failure_persistence: None, ..ProptestConfig::default() };
    if std::env::var("PROPTEST_CASES").is_err() {
        // The same in every run of the suite.
        config = ProptestConfig { cases: 1000, rng_seed: RngSeed::Fixed(1), ..config };
    }
    TestRunner::new(config).run(&model(), one).unwrap();
    let (built, refused) = (built.get(), refused.get());
    assert!(built > refused / 4 && refused > built / 20, "{built} built, {refused} refused");
}
