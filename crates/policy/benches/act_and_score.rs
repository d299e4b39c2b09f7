//! What an act with its score costs, kind by kind, at Svenja's size: 30 inputs, 24 outputs, six legs.

#![allow(clippy::unwrap_used, missing_docs)]

#[allow(unreachable_pub, dead_code)]
#[path = "../tests/common/mod.rs"]
mod common;

use std::hint::black_box;

use criterion::Criterion;
use policy::{Connectivity, CrbmSettings, Inputs, KindSettings, MachineSettings, ModularSettings};

fn main() {
    let machine = MachineSettings { hidden_units: 8, gibbs_updates: 10, samples: 60 };
    let legs = KindSettings::Crbm(CrbmSettings {
        machine: machine.clone(),
        connectivity: Connectivity::PerGroup,
        inputs: Inputs::Neighbours,
    });
    let neighbours = KindSettings::Modular(ModularSettings { machine, inputs: Inputs::Neighbours });
    let defaults = KindSettings::all().into_iter().map(|kind| (kind.name().to_owned(), kind));
    let variants = [
        ("crbm, 8 hidden units for each leg, inputs of neighbours".to_owned(), legs),
        ("modular, inputs of neighbours".to_owned(), neighbours),
    ];
    let mut criterion = Criterion::default().sample_size(20).configure_from_args();
    for (name, kind) in defaults.chain(variants) {
        // Weights as after some learning, so that bits neither freeze nor are all coins.
        let mut policy = common::build(&kind, &common::svenja(), 0.5, 1);
        let x = common::inputs(&*policy, 0);
        let mut y = vec![false; policy.n_outputs()];
        let mut score = vec![0.0; policy.parameters().len()];
        criterion.bench_function(&name, |bencher| {
            bencher.iter(|| {
                policy.act_and_score(black_box(&x), &mut y, &mut score).unwrap();
                black_box((&y, &score));
            });
        });
    }
    criterion.final_summary();
}
