//! Robots, and all kinds with their variants.

use policy::{
    Coding, Connectivity, CrbmSettings, Group, Inputs, KindSettings, MachineSettings,
    ModularSettings, Policy, PolicySettings, Start, Structure,
};

/// Three legs in a row with a sensor and two targets each, and a sensor that belongs to none, a bit
/// each: 4 inputs, 6 outputs.
pub fn small() -> Structure {
    let leg = |name: &str, leg: usize, neighbours: &[usize]| Group {
        name: name.into(),
        inputs: vec![leg],
        // Not in a row: 0 and 3, 1 and 4, 2 and 5.
        actuators: vec![leg, leg + 3],
        neighbours: neighbours.into(),
    };
    Structure {
        bits_per_reading: 4,
        readings: 1,
        actuators: (0..6).map(|actuator| format!("actuator {actuator}")).collect(),
        bits_per_actuator: 1,
        groups: vec![leg("front", 0, &[1]), leg("middle", 1, &[0, 2]), leg("rear", 2, &[1])],
    }
}

/// Svenja: six legs of four positions, a contact and four targets, 30 inputs and 24 outputs.
pub fn svenja() -> Structure {
    let names =
        ["front left", "front right", "centre left", "centre right", "rear left", "rear right"];
    let hips: Vec<[f64; 3]> =
        (0..6).map(|leg| [(leg % 2) as f64, -(leg as f64 / 2.0).floor(), 0.0]).collect();
    let group = |((leg, name), neighbours): ((usize, &&str), Vec<usize>)| Group {
        name: (*name).into(),
        inputs: (4 * leg..4 * leg + 4).chain([24 + leg]).collect(),
        actuators: (4 * leg..4 * leg + 4).collect(),
        neighbours,
    };
    Structure {
        bits_per_reading: 30,
        readings: 1,
        actuators: (0..24).map(|axis| format!("axis {axis}")).collect(),
        bits_per_actuator: 1,
        groups: names.iter().enumerate().zip(policy::beside(&hips)).map(group).collect(),
    }
}

/// Every kind of the list, and the variants of some, with `hidden_units` in all machines.
pub fn variants(hidden_units: usize) -> Vec<KindSettings> {
    let machine = MachineSettings { hidden_units, gibbs_updates: 10, samples: 20 };
    let crbm = |connectivity, inputs| {
        KindSettings::Crbm(CrbmSettings { machine: machine.clone(), connectivity, inputs })
    };
    let modular =
        |inputs| KindSettings::Modular(ModularSettings { machine: machine.clone(), inputs });
    let mut all = KindSettings::all();
    all.extend([
        crbm(Connectivity::Full, Inputs::All),
        crbm(Connectivity::PerActuator, Inputs::OwnGroup),
        crbm(Connectivity::PerGroup, Inputs::OwnGroup),
        crbm(Connectivity::PerGroup, Inputs::Neighbours),
        modular(Inputs::OwnGroup),
        modular(Inputs::Neighbours),
        modular(Inputs::All),
    ]);
    all
}

/// With parameters of a standard deviation of `scale`.
pub fn build(kind: &KindSettings, robot: &Structure, scale: f64, seed: u64) -> Box<dyn Policy> {
    let (memory, coding, start) = (0, Coding::Binary, Start::Random(scale));
    let settings = PolicySettings { kind: kind.clone(), memory, coding, start };
    settings.build(robot, seed).unwrap()
}

/// Inputs that differ from step to step.
pub fn inputs(policy: &dyn Policy, step: usize) -> Vec<bool> {
    (0..policy.n_inputs()).map(|k| (k * 7 + step * 5).is_multiple_of(3)).collect()
}

/// Outputs and the bits of the scores over some steps.
pub fn run(policy: &mut dyn Policy, steps: std::ops::Range<usize>) -> Vec<(Vec<bool>, Vec<u64>)> {
    steps
        .map(|step| {
            let mut y = vec![false; policy.n_outputs()];
            let mut score = vec![f64::NAN; policy.parameters().len()];
            let x = inputs(policy, step);
            policy.act_and_score(&x, &mut y, &mut score).unwrap();
            (y, score.into_iter().map(f64::to_bits).collect())
        })
        .collect()
}
