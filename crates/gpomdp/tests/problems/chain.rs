//! The three-state chain of J. Baxter, P. L. Bartlett and L. Weaver (Experiments with
//! Infinite-Horizon, Policy-Gradient Estimation, Journal of Artificial Intelligence Research 15
//! (2001), 351-381), and all that can be said about it exactly.
//!
//! With P the transition matrix of a policy, pi its stationary distribution and r the rewards of
//! the states, a step that ends in j is paid r_j, and
//!
//! ```text
//!     eta        = pi' r                                        the average reward
//!     grad eta   = pi' grad(P) (I - P + 1 pi')^-1 r             its gradient
//!     grad_b eta = pi' grad(P) (I - beta P)^-1 r                what GPOMDP converges to
//!                = sum over s of beta^s pi' grad(P) P^s r
//! ```
//!
//! (J. Baxter and P. L. Bartlett, Infinite-Horizon Policy-Gradient Estimation, in the same volume,
//! 319-350.) A loop that starts in pi with z = 0 and
//! ends after T steps has only T - s pairs of an action and the reward s steps later, so its
//! expected estimate has the factor (1 - s/T) in the sum, which then ends at T - 1.

use nalgebra::{Matrix3, RowVector3, Vector3};

use super::{Draws, Problem};

pub const N_PARAMETERS: usize = 4;
pub type Theta = [f64; N_PARAMETERS];

/// Probability of the next state, `[action][state][next state]`.
const NEXT: [[[f64; 3]; 3]; 2] = [
    [[0.0, 0.8, 0.2], [0.8, 0.0, 0.2], [0.0, 0.8, 0.2]],
    [[0.0, 0.2, 0.8], [0.2, 0.0, 0.8], [0.0, 0.2, 0.8]],
];
/// Reward of the state that a step ends in.
const REWARD: [f64; 3] = [0.0, 0.0, 1.0];
/// phi, `[state][feature]`.
const FEATURES: [[f64; 2]; 3] =
    [[12.0 / 18.0, 6.0 / 18.0], [6.0 / 18.0, 12.0 / 18.0], [5.0 / 18.0, 5.0 / 18.0]];

/// p(action|state), a softmax of theta1 phi1 + theta2 phi2 and theta3 phi1 + theta4 phi2.
pub fn probabilities(theta: &[f64], state: usize) -> [f64; 2] {
    let [phi1, phi2] = FEATURES[state];
    let difference = (theta[0] - theta[2]) * phi1 + (theta[1] - theta[3]) * phi2;
    let first = 1.0 / (1.0 + libm::exp(-difference));
    [first, 1.0 / (1.0 + libm::exp(difference))]
}

/// grad log p(action|state): the features times ([action = a] - p(a)) for each action a.
pub fn score(theta: &[f64], state: usize, action: usize) -> Theta {
    let p = probabilities(theta, state);
    let [phi1, phi2] = FEATURES[state];
    let [first, second] = [0, 1].map(|a| if action == a { p[1 - a] } else { -p[a] });
    [first * phi1, first * phi2, second * phi1, second * phi2]
}

/// The chain as a world to act in.
pub struct Chain {
    pub state: usize,
}

impl Chain {
    /// With the start drawn from the stationary distribution of a policy.
    pub fn stationary(theta: &[f64], draws: &mut Draws) -> Self {
        Self { state: draws.index(Exact::at(theta).stationary.as_slice()) }
    }

    /// All that can happen in one step from a state: probability, action, next state.
    pub fn branches(theta: &[f64], state: usize) -> Vec<(f64, usize, usize)> {
        let p = probabilities(theta, state);
        let pairs = (0..2).flat_map(|action| (0..3).map(move |next| (action, next)));
        let weigh =
            |(action, next): (usize, usize)| (p[action] * NEXT[action][state][next], action, next);
        pairs.map(weigh).filter(|branch| branch.0 > 0.0).collect()
    }

    pub fn reward_in(state: usize) -> f64 {
        REWARD[state]
    }
}

impl Problem for Chain {
    fn n_parameters(&self) -> usize {
        N_PARAMETERS
    }

    fn step(&mut self, theta: &[f64], draws: &mut Draws, out: &mut [f64]) -> f64 {
        let action = draws.index(&probabilities(theta, self.state));
        out.copy_from_slice(&score(theta, self.state, action));
        self.state = draws.index(&NEXT[action][self.state]);
        REWARD[self.state]
    }

    fn average_reward(&self, theta: &[f64]) -> f64 {
        Exact::at(theta).average_reward()
    }

    /// Always the second action: every state then goes to C with probability 0.8.
    fn optimum(&self) -> f64 {
        0.8
    }
}

/// What is known about a policy without trying it.
pub struct Exact {
    pub stationary: Vector3<f64>,
    transition: Matrix3<f64>,
    /// The derivatives of the transition matrix.
    derivatives: [Matrix3<f64>; N_PARAMETERS],
}

impl Exact {
    pub fn at(theta: &[f64]) -> Self {
        let mut transition = Matrix3::zeros();
        let mut derivatives = [Matrix3::zeros(); N_PARAMETERS];
        for state in 0..3 {
            let p = probabilities(theta, state);
            for action in 0..2 {
                let row = RowVector3::from(NEXT[action][state]) * p[action];
                transition.set_row(state, &(transition.row(state) + row));
                for (derivative, score) in derivatives.iter_mut().zip(score(theta, state, action)) {
                    derivative.set_row(state, &(derivative.row(state) + row * score));
                }
            }
        }
        // pi' (I - P + 1 1') = 1', since pi' P = pi' and pi' 1 = 1.
        let all_ones = Matrix3::repeat(1.0);
        let stationary =
            solve((Matrix3::identity() - transition + all_ones).transpose(), Vector3::repeat(1.0));
        Self { stationary, transition, derivatives }
    }

    /// eta
    pub fn average_reward(&self) -> f64 {
        self.stationary.dot(&Vector3::from(REWARD))
    }

    /// grad eta
    pub fn gradient(&self) -> Theta {
        let to_stationary = Vector3::repeat(1.0) * self.stationary.transpose();
        let system = Matrix3::identity() - self.transition + to_stationary;
        self.along(solve(system, REWARD.into()))
    }

    /// grad_b eta, for a discount below 1.
    pub fn discounted_gradient(&self, discount: f64) -> Theta {
        let system = Matrix3::identity() - self.transition * discount;
        self.along(solve(system, REWARD.into()))
    }

    /// The expected estimate of a loop of this many steps.
    pub fn looped_gradient(&self, discount: f64, steps: u32) -> Theta {
        let mut values = Vector3::zeros();
        let mut term = Vector3::from(REWARD);
        for s in 0..steps {
            values += term * (1.0 - f64::from(s) / f64::from(steps));
            term = self.transition * term * discount;
        }
        self.along(values)
    }

    /// pi' grad(P) values
    fn along(&self, values: Vector3<f64>) -> Theta {
        self.derivatives.map(|derivative| self.stationary.dot(&(derivative * values)))
    }
}

/// x of `system` x = `right`; NaN if there is none, which no comparison in a test lets pass.
fn solve(system: Matrix3<f64>, right: Vector3<f64>) -> Vector3<f64> {
    system.lu().solve(&right).unwrap_or(Vector3::repeat(f64::NAN))
}
