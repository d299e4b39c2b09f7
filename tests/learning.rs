//! It learns: a block with an arm of two hinges (tests/models/crawler.toml) crawls in the end.
//!
//! Uniformly random actions make 0.0000 m per control step, and so does any pose held; the gait
//! tests/models/gaits/crawler.toml, 0.0101. With the settings of tests/experiments/learns.toml a
//! push at times, some 0.0008, is what the paper's optimiser finds; Adam finds the whole cycle with
//! about half of the seeds.

use std::path::Path;

use crate::common::*;
use figures::statistics::paired_t;

/// Mean R_Loc of each seed's first and last quarter of updates, in m per control step.
fn quarters(more: &[&str]) -> Vec<[f64; 2]> {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    let words = ["train", "tests/experiments/learns.toml", "--out", text(&run)];
    itarl(&[&words, more].concat()).ends(DONE);
    (1..=8).map(|seed| quarters_of(&run.join(format!("cells/base/seed={seed}")))).collect()
}

fn quarters_of(cell: &Path) -> [f64; 2] {
    let advance_m = column(cell, "R_Loc");
    let quarter = advance_m.len() / 4;
    let ends = [&advance_m[..quarter], &advance_m[advance_m.len() - quarter..]];
    ends.map(|values| values.iter().sum::<f64>() / quarter as f64)
}

/// Student's t of the last quarters' being above the first ones, paired by seed.
fn t_of(quarters: &[[f64; 2]]) -> f64 {
    let gains: Vec<_> = quarters.iter().map(|[first, last]| last - first).collect();
    paired_t(&gains).unwrap().0
}

/// One-sided, p < .01, 7 degrees of freedom. Measured: 6.6, with other seeds (11 to 18) 6.0; with a rate
/// of 1e-12, which learns nothing, -0.2.
const CRITICAL_T: f64 = 2.998;

#[test]
fn the_papers_optimiser_gets_better() {
    let learned = quarters(&[]);
    let t = t_of(&learned);
    assert!(t > CRITICAL_T, "t = {t:.2}: {learned:.5?}");

    // And it's the learning that does it.
    let frozen = quarters(&["--set", "learning.rate=1e-12"]);
    let t = t_of(&frozen);
    assert!(t < CRITICAL_T, "t = {t:.2}: {frozen:.5?}");
}

/// To crawl, a policy must answer each of four postures rightly.
#[test]
fn the_whole_cycle_can_be_found() {
    let adam = ["learning.optimiser=\"adam\"", "learning.adam.rate=0.1", "learning.updates=300"];
    let sets: Vec<_> = adam.iter().flat_map(|it| ["--set", it]).collect();
    let learned = quarters(&sets);
    // Ten times what is found without the cycle, eight tenths of the gait. Measured: .0097 to .0100 with
    // 4 of the 8 seeds, and 5 of 8 others; the rest stay at .0008.
    let n = learned.iter().filter(|[_, last]| *last > 0.008).count();
    assert!(n >= 1, "{learned:.5?}");
}
