//! The gradient of the average reward from one run: GPOMDP.
//!
//! For k = 1..T, with the score grad log p(a_k|s_k) of the action just taken and the reward r_k
//! that followed it,
//!
//! ```text
//!     z     <- beta z + grad log p(a_k|s_k)             the trace
//!     Delta <- Delta + (r_k z - Delta) / k              the gradient: the running mean of r z
//!     rbar  <- rbar + r_k                               R = rbar / T, the average reward
//! ```
//!
//! from z = 0, Delta = 0, rbar = 0. Source: J. Baxter and P. L. Bartlett, Infinite-Horizon
//! Policy-Gradient Estimation, Journal of Artificial Intelligence Research 15 (2001), 319-350,
//! algorithm 1 (GPOMDP), with the reward counted from the one after the first action.

use serde::{Deserialize, Serialize};

use crate::{Error, baseline::RunningAverage, check, check::LIMIT};

/// A trace of accepted scores is below this: at most 2^53 times [`LIMIT`].
const TRACE_LIMIT: f64 = 1e116;
/// And a mean of rewards times traces below this.
const GRADIENT_LIMIT: f64 = 1e217;
/// Numbers of a state before the slices: steps, sum of rewards.
const HEAD: usize = 2;

/// The settings of an [`Estimator`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EstimatorSettings {
    /// beta, the discount of the trace, 0 to 1; 0.75.
    ///
    /// It trades bias (small beta) for variance (large beta); the [crate's page](crate) has a
    /// table. 1 is for short runs only: the trace then grows until [`Estimator::restart`].
    pub discount: f64,
    /// f, the factor per step of the reward baseline, 0 to 1; none by default. 0.998, a memory of
    /// 500 steps, is a good start.
    ///
    /// The baseline b is a running average of the rewards before this one, with weights 1, f, f^2,
    /// ... from the newest to the oldest. Delta then collects (r - b) z in place of r z, which
    /// takes out the variance that a constant part of the reward makes. The very first reward has
    /// nothing to be compared with, and adds nothing to Delta.
    ///
    /// Past rewards depend on the actions that are still in the trace, so b isn't quite free: in
    /// the long run it shrinks the expected estimate by exactly (1 - beta)/(1 - f beta), the
    /// direction unchanged. That is 0.994 for beta = 0.75, f = 0.998, but 0.84 for beta = 0.99.
    pub baseline_factor: Option<f64>,
}

impl Default for EstimatorSettings {
    fn default() -> Self {
        Self { discount: 0.75, baseline_factor: None }
    }
}

/// Collects scores and rewards step by step, and has the gradient estimate at any time.
///
/// It works for any policy that can tell its score, the gradient of log p(action|sensors) with
/// respect to its parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimator {
    discount: f64,
    baseline: Option<RunningAverage>,
    steps: u64,
    reward_sum: f64,
    /// z, [n_parameters]
    trace: Vec<f64>,
    /// Delta, [n_parameters]
    gradient: Vec<f64>,
}

impl Estimator {
    /// An estimator for a policy with this many parameters, before its first step. With none at
    /// all it still averages rewards.
    ///
    /// # Errors
    /// A setting that is out of range; more parameters than there is memory for.
    pub fn new(n_parameters: usize, settings: &EstimatorSettings) -> Result<Self, Error> {
        let place = "Estimator::new";
        let discount = settings.discount;
        let right = (0.0..=1.0).contains(&discount);
        check::number(right, place, "discount", "within 0 to 1", discount)?;
        Ok(Self {
            discount,
            baseline: settings.baseline_factor.map(RunningAverage::new).transpose()?,
            steps: 0,
            reward_sum: 0.0,
            trace: check::filled(place, n_parameters, 0.0)?,
            gradient: check::filled(place, n_parameters, 0.0)?,
        })
    }

    /// Takes in one step: the score of the action, `[n_parameters]`, and the reward that followed.
    ///
    /// # Errors
    /// A score of another length; a reward, or an element of the score, that is NaN, infinite or
    /// beyond [`LIMIT`]. The estimator is then as before.
    pub fn accumulate(&mut self, score: &[f64], reward: f64) -> Result<(), Error> {
        let place = "Estimator::accumulate";
        check::slice(place, "score", score, self.trace.len(), LIMIT)?;
        let right = reward.abs() <= LIMIT;
        check::number(right, place, "reward", "within -1e100 to 1e100", reward)?;

        self.steps += 1;
        self.reward_sum += reward;
        let r = self.minus_baseline(reward);
        let beta = self.discount;
        // One division a step, and not one a parameter, which would take longer than all the rest.
        let share = 1.0 / self.steps as f64;
        let sums = self.trace.iter_mut().zip(&mut self.gradient);
        for ((z, delta), &score) in sums.zip(score) {
            *z = beta * *z + score;
            *delta += (r * *z - *delta) * share;
        }
        Ok(())
    }

    /// r - b, with b of the rewards before this one; then b hears of this one.
    fn minus_baseline(&mut self, reward: f64) -> f64 {
        let Some(baseline) = &mut self.baseline else { return reward };
        let r = baseline.get().map_or(0.0, |b| reward - b);
        baseline.add(reward);
        r
    }

    /// Delta, the estimate of the average reward's gradient from the steps since the last restart,
    /// `[n_parameters]`; zeros before the first.
    #[must_use]
    pub fn gradient(&self) -> &[f64] {
        &self.gradient
    }

    /// R, the average of the rewards (the baseline not subtracted) since the last restart; 0
    /// before the first.
    #[must_use]
    pub fn average_reward(&self) -> f64 {
        if self.steps == 0 { 0.0 } else { self.reward_sum / self.steps as f64 }
    }

    /// z, the discounted sum of the scores since the last restart, `[n_parameters]`.
    #[must_use]
    pub fn trace(&self) -> &[f64] {
        &self.trace
    }

    /// Steps since the last restart.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// b, what will be subtracted from the next reward: none without a baseline, and before its
    /// first reward.
    #[must_use]
    pub fn baseline(&self) -> Option<f64> {
        self.baseline.as_ref().and_then(RunningAverage::get)
    }

    /// Begins a new estimate: z, Delta, rbar and the number of steps are 0 again. The baseline
    /// runs on.
    pub fn restart(&mut self) {
        self.steps = 0;
        self.reward_sum = 0.0;
        self.trace.fill(0.0);
        self.gradient.fill(0.0);
    }

    /// All that changes, for [`Estimator::restore`]: steps, rbar, z, Delta and, with a baseline,
    /// its weight and value. `[2 + 2 n_parameters + (0 or 2)]`
    #[must_use]
    pub fn state(&self) -> Vec<f64> {
        let mut state = vec![self.steps as f64, self.reward_sum];
        state.extend(&self.trace);
        state.extend(&self.gradient);
        if let Some(baseline) = &self.baseline {
            baseline.save(&mut state);
        }
        state
    }

    /// Goes back to a [`Estimator::state`] of an estimator with the same settings and number of
    /// parameters, and continues from it with the same bits.
    ///
    /// # Errors
    /// A state of another length, or with numbers that no run leads to. The estimator is then as
    /// before.
    pub fn restore(&mut self, state: &[f64]) -> Result<(), Error> {
        let place = "Estimator::restore";
        let n = self.trace.len();
        let slices_end = HEAD + 2 * n;
        let tail = if self.baseline.is_some() { RunningAverage::STATE_LEN } else { 0 };
        check::slice(place, "state", state, slices_end + tail, GRADIENT_LIMIT)?;
        let (steps, reward_sum) = (state[0], state[1]);
        let right = (0.0..=check::LARGEST_COUNT).contains(&steps) && steps.trunc() == steps;
        check::number(right, place, "steps", "a whole number, 0 to 2^53", steps)?;
        let right = reward_sum.abs() <= TRACE_LIMIT;
        check::number(right, place, "sum of rewards", "within -1e116 to 1e116", reward_sum)?;
        let (trace, gradient) = state[HEAD..slices_end].split_at(n);
        check::slice(place, "trace", trace, n, TRACE_LIMIT)?;
        if let (Some(baseline), &[weight, average]) = (&mut self.baseline, &state[slices_end..]) {
            *baseline = baseline.restored(place, [weight, average])?;
        }
        self.steps = steps as u64;
        self.reward_sum = reward_sum;
        self.trace.copy_from_slice(trace);
        self.gradient.copy_from_slice(gradient);
        Ok(())
    }
}
