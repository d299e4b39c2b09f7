//! What is looked at in a rollout: the task's own value, the information, and their mix at each xi. All
//! are made of the same control steps.

use config::Document;
use reward::{RewardSettings, Terms, mix::MixSettings};

/// The functions whose landscapes are measured.
#[derive(Clone, Debug)]
pub struct Functions {
    mix: MixSettings,
    scale: f64,
    /// From the penalty as it was paid to that of this mix.
    penalty: f64,
    xis: Vec<f64>,
}

impl Functions {
    /// With the cell's own mix at these xi, or another one: TOML as in the table `reward.mix` of an
    /// experiment file. A penalty is then the same share of that mix's nominal maximum.
    ///
    /// # Errors
    /// What isn't such a table.
    pub fn new(reward: &RewardSettings, mix: Option<&str>, xis: &[f64]) -> anyhow::Result<Self> {
        let own = &reward.mix;
        let mix = match mix {
            Some(text) => Document::parse("--mix", text)?.read(MixSettings::read)?,
            None => own.clone(),
        };
        Ok(Self {
            penalty: mix.get().one_percent() / own.get().one_percent(),
            scale: reward.scale,
            xis: xis.to_vec(),
            mix,
        })
    }

    /// How many there are.
    #[must_use]
    pub fn n(&self) -> usize {
        2 + self.xis.len()
    }

    /// The names of [`Functions::of`]: `R_Loc` and so on, `R_MI` and so on, `xi=0.75`.
    #[must_use]
    pub fn names(&self, [task, information]: [&str; 2]) -> Vec<String> {
        let mixes = self.xis.iter().map(|xi| format!("xi={xi}"));
        [task.to_owned(), information.to_owned()].into_iter().chain(mixes).collect()
    }

    /// The name of the mix with the largest share of the task, which others are compared with.
    #[must_use]
    pub fn reference(&self) -> String {
        format!("xi={}", self.xis.iter().copied().fold(0.0, f64::max))
    }

    /// Which of them is the information.
    pub const INFORMATION: usize = 1;

    /// Each function of a control step.
    #[must_use]
    pub fn of(&self, terms: &Terms) -> Vec<f64> {
        let mixes = self.xis.iter().map(|&xi| self.reward(xi, terms));
        [terms.extrinsic_raw, terms.intrinsic_nats].into_iter().chain(mixes).collect()
    }

    /// What training at this xi would have paid for a control step.
    fn reward(&self, xi: f64, terms: &Terms) -> f64 {
        let Terms { extrinsic, intrinsic, .. } = *terms;
        self.scale * self.mix.get().mix(xi, extrinsic, intrinsic) - self.penalty * terms.penalty
    }

    /// The mean of each over a rollout, summed as `itarl rollout` does.
    #[must_use]
    pub fn means(&self, rollout: &[Terms]) -> Vec<f64> {
        let n = rollout.len() as f64;
        let mut means = vec![0.0; self.n()];
        for terms in rollout {
            means.iter_mut().zip(self.of(terms)).for_each(|(mean, value)| *mean += value / n);
        }
        means
    }
}

#[cfg(test)]
mod tests {
    use reward::{Reward, RobotLayout, RobotState, Transition};

    use super::*;

    /// Some control steps as a reward with these settings pays them.
    fn paid(settings: &RewardSettings) -> Vec<Terms> {
        let layout = RobotLayout { n_positions: 2, n_bins: 4, ..RobotLayout::default() };
        let mut reward = Reward::new(settings, &layout, 1).unwrap();
        reward.begin(&[0, 3]).unwrap();
        let mut before = RobotState::default();
        let steps = (1..60_u64).map(|i| {
            let mut after = before.clone();
            after.centre_of_gravity_m.x += 0.01 * (i as f64).sin();
            after.penalised_contacts = (i % 3) as usize;
            let bins = [i * i % 4, i / 2 % 4];
            let step = Transition { bins: &bins, ..Transition::between(&before, &after) };
            let terms = reward.evaluate(&step, 0).unwrap();
            before = after;
            terms
        });
        steps.collect()
    }

    /// Whatever the kind of mix, at any xi: from the steps of a cell that was paid at another one.
    #[test]
    fn the_mix_at_xi_is_what_training_would_have_paid() {
        let xis = [0.0, 0.25, 0.5, 0.75, 1.0];
        for kind in MixSettings::all() {
            let of = |xi: f64| {
                let text = format!("scale = 10\nmix.kind = '{}'\nmix.xi = {xi:?}", kind.kind());
                Document::parse("f", &text).unwrap().read(RewardSettings::read).unwrap()
            };
            let functions = Functions::new(&of(0.75), None, &xis).unwrap();
            let found: Vec<_> = paid(&of(0.75)).iter().map(|terms| functions.of(terms)).collect();
            for (i, xi) in xis.into_iter().enumerate() {
                for (found, paid) in found.iter().zip(paid(&of(xi))) {
                    assert_eq!(
                        found[2 + i].to_bits(),
                        paid.reward.to_bits(),
                        "{} {xi}",
                        kind.kind()
                    );
                    assert_eq!(found[..2], [paid.extrinsic_raw, paid.intrinsic_nats]);
                }
            }
        }
    }

    /// By hand: e = 0.04, i = 0.09; the penalty is 1 % of 0.1 squared for the squared mix, and 1 % of 0.1
    /// for the sum, as a training with that mix would have it.
    #[test]
    fn another_mix_of_the_same_steps() {
        let reward = RewardSettings { scale: 10.0, ..RewardSettings::default() };
        let terms = Terms { extrinsic: 0.04, intrinsic: 0.09, penalty: 0.001, ..Terms::default() };
        let of = |mix| Functions::new(&reward, mix, &[0.5, 1.0]).unwrap().of(&terms)[2..].to_vec();
        let is_near = |found: Vec<f64>, expected: [f64; 2]| {
            // A few roundings.
            let near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15);
            assert!(near, "{found:?}, not {expected:?}");
        };
        is_near(of(None), [0.036 - 0.001, 0.016 - 0.001]);
        is_near(of(Some("power = 1")), [0.6 - 0.01, 0.4 - 0.01]);
        is_near(of(Some("kind = 'linear'")), [0.65 - 0.01, 0.4 - 0.01]);
        let error = Functions::new(&reward, Some("kind = 'cubic'"), &[]).unwrap_err().to_string();
        assert!(error.contains("--mix:1:8"), "{error}");
    }
}
