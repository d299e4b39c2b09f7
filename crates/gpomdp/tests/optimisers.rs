//! The contract of `Optimiser`, for every entry of the list.
#![allow(clippy::unwrap_used, missing_docs)]

use gpomdp::{
    AdamSettings, Error, LIMIT, MomentumSettings, Optimiser, OptimiserSettings, RpropSettings,
    Setting,
};
use proptest::{collection::vec, prelude::*};

const N: usize = 4;
const BAD: [f64; 5] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1.001e100, -1.001e100];

type Vector = [f64; N];

fn each(mut check: impl FnMut(&str, Box<dyn Optimiser>)) {
    for settings in OptimiserSettings::all() {
        check(settings.name(), settings.build(N).unwrap());
    }
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|x| x.to_bits()).collect()
}

fn gradients(n: usize) -> impl Strategy<Value = Vec<Vector>> {
    let element = prop_oneof![4 => -1.0..1.0, 1 => Just(0.0)];
    vec(prop::array::uniform4(element), 1..n)
}

/// f(theta) = -1/2 sum of c_i (theta_i - t_i)^2, a hill with its top at t.
#[test]
fn every_optimiser_climbs_a_hill_to_its_top() {
    let (curvature, top) = ([0.1, 0.3, 1.0, 1.0], [1.0, -2.0, 0.5, 0.0]);
    each(|name, mut optimiser| {
        let mut theta = [0.0, 0.0, 3.0, -1.0];
        for _ in 0..20_000 {
            let gradient = [0, 1, 2, 3].map(|i| curvature[i] * (top[i] - theta[i]));
            optimiser.update(&mut theta, &gradient).unwrap();
        }
        for (theta, top) in theta.iter().zip(top) {
            // Weight decay shifts the top by 1e-5/c of it, at most 2e-4; Adam's steps are 1e-3.
            assert!((theta - top).abs() < 1e-3, "{name}: {theta}, {top}");
        }
    });
}

#[test]
fn bad_input_is_refused_by_name_and_changes_nothing() {
    each(|name, mut optimiser| {
        let mut theta = [1.0, 2.0, 3.0, 4.0];
        optimiser.update(&mut theta, &[0.1, -0.1, 0.2, 0.0]).unwrap();
        let (theta, state) = (theta, optimiser.state());
        let mut refused = |parameters: &[f64], gradient: &[f64]| {
            let mut given = parameters.to_vec();
            let error = optimiser.update(&mut given, gradient).unwrap_err();
            assert_eq!(bits(&given), bits(parameters), "{name}: {error}");
            assert_eq!(optimiser.state(), state, "{name}: {error}");
            error
        };
        for (bad, index) in BAD.into_iter().flat_map(|bad| (0..N).map(move |i| (bad, i))) {
            let mut vector = [0.5; N];
            vector[index] = bad;
            for (wrong, error) in [
                ("parameters", refused(&vector, &[0.5; N])),
                ("gradient", refused(&theta, &vector)),
            ] {
                let named = matches!(error, Error::Element { what, index: found, value, .. }
                    if what == wrong && found == index && value.to_bits() == bad.to_bits());
                assert!(named, "{name}: {error}");
            }
        }
        for length in [0, N - 1, N + 1] {
            let short = vec![0.5; length];
            let errors =
                [("parameters", refused(&short, &theta)), ("gradient", refused(&theta, &short))];
            for (wrong, error) in errors {
                let named = matches!(error, Error::Length { what, expected: N, got, .. }
                    if what == wrong && got == length);
                assert!(named, "{name}: {error}");
            }
        }
    });
}

proptest! {
    #[test]
    fn a_restored_optimiser_continues_with_the_same_bits(
        first in gradients(30),
        second in gradients(30),
    ) {
        for settings in OptimiserSettings::all() {
            let mut one = settings.build(N).unwrap();
            let mut theta = [0.5; N];
            for gradient in &first {
                one.update(&mut theta, gradient).unwrap();
            }
            let mut other = settings.build(N).unwrap();
            other.update(&mut [1.0; N], &[1.0; N]).unwrap(); // to be overwritten
            other.restore(&one.state()).unwrap();
            prop_assert_eq!(bits(&other.state()), bits(&one.state()));
            let mut restored = theta;
            for gradient in &second {
                one.update(&mut theta, gradient).unwrap();
                other.update(&mut restored, gradient).unwrap();
            }
            prop_assert_eq!(bits(&restored), bits(&theta), "{}", settings.name());
            prop_assert_eq!(bits(&other.state()), bits(&one.state()));
        }
    }

    /// What a mask takes out of a policy stays out.
    #[test]
    fn a_zero_without_gradient_stays_zero(gradients in gradients(50), masked in 0..N) {
        for settings in OptimiserSettings::all() {
            let mut optimiser = settings.build(N).unwrap();
            let mut theta = [0.0; N];
            for gradient in &gradients {
                let mut gradient = *gradient;
                gradient[masked] = 0.0;
                optimiser.update(&mut theta, &gradient).unwrap();
            }
            prop_assert_eq!(theta[masked], 0.0, "{}", settings.name());
        }
    }

    /// No element knows the others.
    #[test]
    fn elements_do_not_mix(gradients in gradients(50)) {
        for settings in OptimiserSettings::all() {
            let mut together = settings.build(N).unwrap();
            let mut alone: Vec<_> = (0..N).map(|_| settings.build(1).unwrap()).collect();
            let (mut theta, mut single) = ([0.5; N], [0.5; N]);
            for gradient in &gradients {
                together.update(&mut theta, gradient).unwrap();
                for (i, alone) in alone.iter_mut().enumerate() {
                    alone.update(&mut single[i..=i], &gradient[i..=i]).unwrap();
                }
            }
            prop_assert_eq!(bits(&theta), bits(&single), "{}", settings.name());
        }
    }
}

/// The most extreme settings that are accepted.
fn extremes() -> [OptimiserSettings; 3] {
    let almost_1 = 1.0 - f64::EPSILON / 2.0;
    [
        OptimiserSettings::Momentum(MomentumSettings {
            rate: LIMIT,
            decay: 1.0,
            momentum: almost_1,
        }),
        OptimiserSettings::Adam(AdamSettings {
            rate: LIMIT,
            mean_factor: almost_1,
            square_factor: 0.0,
            epsilon: 1e-50,
        }),
        OptimiserSettings::Rprop(RpropSettings {
            first: 1.0,
            smallest: 1e-300,
            largest: LIMIT,
            grow: LIMIT,
            shrink: 1e-300,
        }),
    ]
}

#[test]
fn the_largest_numbers_do_not_overflow() {
    for settings in OptimiserSettings::all().into_iter().chain(extremes()) {
        let mut optimiser = settings.build(N).unwrap();
        for step in 0..1000 {
            let signs = [1.0, -1.0, if step % 2 == 0 { 1.0 } else { -1.0 }, 1.0];
            let mut theta = signs.map(|sign| -sign * LIMIT);
            // Every other time nothing, which leaves Adam a mean without a mean square.
            let gradient = signs.map(|sign| if step % 4 < 2 { sign * LIMIT } else { 0.0 });
            optimiser.update(&mut theta, &gradient).unwrap();
            assert!(theta.iter().all(|x| x.is_finite()), "{settings:?}: {theta:?}");
        }
        let state = optimiser.state();
        optimiser.restore(&state).unwrap();
        // Parameters that ran away are met by the next step.
        let mut away = [2.0 * LIMIT; N];
        assert!(optimiser.update(&mut away, &[0.0; N]).is_err(), "{settings:?}");
    }
}

#[test]
fn senseless_states_are_refused_and_change_nothing() {
    each(|name, mut optimiser| {
        optimiser.update(&mut [0.5; N], &[0.1, -0.1, 0.2, 0.3]).unwrap();
        let good = optimiser.state();
        for index in 0..good.len() {
            for bad in [f64::NAN, f64::INFINITY, f64::MAX, -f64::MAX] {
                let mut state = good.clone();
                state[index] = bad;
                assert!(optimiser.restore(&state).is_err(), "{name}: {index}, {bad}");
                assert_eq!(optimiser.state(), good, "{name}");
            }
        }
        for length in [0, good.len() - 1, good.len() + 1] {
            assert!(optimiser.restore(&vec![0.5; length]).is_err(), "{name}: {length}");
            assert_eq!(optimiser.state(), good, "{name}");
        }
    });
    // What is special about each: where in the state, and what can't be there.
    let special = [
        (OptimiserSettings::Momentum(MomentumSettings::default()), vec![(0, 1e218)]),
        (OptimiserSettings::Adam(AdamSettings::default()), vec![(0, 1.5), (1, -0.5), (9, -1.0)]),
        (OptimiserSettings::Rprop(RpropSettings::default()), vec![(0, 0.0), (3, 51.0), (4, 0.5)]),
    ];
    for (settings, wrong) in special {
        let mut optimiser = settings.build(N).unwrap();
        let good = optimiser.state();
        for (index, bad) in wrong {
            let mut state = good.clone();
            state[index] = bad;
            assert!(optimiser.restore(&state).is_err(), "{}: {index}, {bad}", settings.name());
            assert_eq!(optimiser.state(), good);
        }
    }
}

#[test]
fn every_setting_is_declared_with_what_it_means() {
    for optimiser in OptimiserSettings::all() {
        let fields: toml::Table = toml::from_str(&toml::to_string(&optimiser).unwrap()).unwrap();
        let fields = fields[optimiser.name()].as_table().unwrap().keys();
        let declared = optimiser.settings().iter();
        assert!(declared.clone().map(|setting| setting.name).eq(fields), "{optimiser:?}");
        for Setting { name, about, expected } in declared {
            assert!(!about.is_empty() && !expected.is_empty(), "{name}");
        }
        assert!(optimiser.about().ends_with('.'), "{optimiser:?}");
    }
}

/// For each setting of each optimiser, values just outside its range.
#[test]
fn settings_out_of_range_are_refused_by_name() {
    let bad: [(&str, &str, &[f64]); 12] = [
        ("momentum", "rate", &[0.0, -1.0, 1e101]),
        ("momentum", "decay", &[-1e-9, 1.1]),
        ("momentum", "momentum", &[-0.1, 1.0]),
        ("adam", "rate", &[0.0, -1.0, 1e101]),
        ("adam", "mean_factor", &[-0.1, 1.0]),
        ("adam", "square_factor", &[-0.1, 1.0]),
        ("adam", "epsilon", &[0.0, -1e-8, 1e101]),
        ("rprop", "first", &[1e-7, 51.0]),
        ("rprop", "smallest", &[0.0, -1.0]),
        ("rprop", "largest", &[1e-7, 1e101]),
        ("rprop", "grow", &[0.9, 1e101]),
        ("rprop", "shrink", &[0.0, 1.1]),
    ];
    for (name, setting, values) in bad {
        for value in values.iter().chain(&[f64::NAN, f64::INFINITY]) {
            let value = if value.is_nan() { "nan".into() } else { format!("{value:?}") };
            let text = format!("{name} = {{ {setting} = {value} }}");
            let settings: OptimiserSettings = toml::from_str(&text).unwrap();
            let error = settings.build(N).unwrap_err();
            let named = matches!(error, Error::Number { what, .. } if what == setting);
            assert!(named, "{text}: {error}");
        }
    }
}

#[test]
fn sizes_from_none_to_more_than_fits() {
    for settings in OptimiserSettings::all() {
        let mut none = settings.build(0).unwrap();
        none.update(&mut [], &[]).unwrap();
        let state = none.state();
        none.restore(&state).unwrap();
        assert_eq!((none.n_parameters(), settings.build(7).unwrap().n_parameters()), (0, 7));
        let error = settings.build(usize::MAX).unwrap_err();
        assert!(matches!(error, Error::Memory { .. }), "{error}");
    }
}

#[test]
fn an_update_allocates_nothing() {
    each(|name, mut optimiser| {
        let (mut theta, gradient) = ([0.5; N], [0.1; N]);
        let counted = allocation_counter::measure(|| {
            for _ in 0..10 {
                optimiser.update(&mut theta, &gradient).unwrap();
            }
        });
        assert_eq!(counted.count_total, 0, "{name}: {counted:?}");
    });
}

#[test]
fn settings_come_from_a_file_with_defaults_and_without_typing_errors() {
    #[derive(serde::Deserialize, Debug)]
    struct File {
        optimiser: OptimiserSettings,
    }
    let read = |text: &str| toml::from_str::<File>(text).map(|file| file.optimiser);
    for settings in OptimiserSettings::all() {
        let name = settings.name();
        assert_eq!(read(&format!("[optimiser.{name}]")).unwrap(), settings);
        let text = toml::to_string(&settings).unwrap();
        assert_eq!(toml::from_str::<OptimiserSettings>(&text).unwrap(), settings);
        let error = read(&format!("optimiser.{name} = {{ raet = 1.0 }}")).unwrap_err();
        assert!(error.to_string().contains("raet"), "{error}");
    }
    let expected = MomentumSettings { rate: 3.0, ..Default::default() };
    let read_back = read("optimiser.momentum = { rate = 3.0 }").unwrap();
    assert_eq!(read_back, OptimiserSettings::Momentum(expected));
    assert!(read("optimiser.adma = {}").is_err());
}
