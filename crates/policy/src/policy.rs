//! What the training loop asks of a policy, whatever its kind.

use std::fmt;

use crate::{Error, Link, error::check_length};

/// Draws bits given bits, with probabilities that depend on parameters.
///
/// A policy has its own parameters and random numbers; what it draws and scores depends on these and
/// on the inputs, and on nothing else. Neither acting nor changing the parameters allocates.
///
/// To add a kind: a file in `src/kinds/` and a line in the list in `src/kinds/mod.rs`; CONTRIBUTING.md
/// has an example. The contract that `tests/contract.rs` runs on every entry of the list then holds for
/// it too.
pub trait Policy: fmt::Debug + Send {
    /// Bits that it sees.
    fn n_inputs(&self) -> usize;

    /// Bits that it draws.
    fn n_outputs(&self) -> usize;

    /// `[n_parameters]`
    fn parameters(&self) -> &[f64];

    /// Changes all parameters, `[n_parameters]`.
    ///
    /// # Errors
    /// If their number is wrong, or one is NaN or beyond [`MAX_PARAMETER`](crbm::MAX_PARAMETER) in
    /// magnitude; the policy is as before.
    fn set_parameters(&mut self, parameters: &[f64]) -> Result<(), Error>;

    /// Draws an output y, `[n_outputs]`, given the inputs x, `[n_inputs]`, and the score at (x, y),
    /// `[n_parameters]`: the gradient of log p(y|x) by the parameters, or an estimate of it from
    /// samples.
    ///
    /// # Errors
    /// If a slice's length is wrong; nothing is drawn then.
    fn act_and_score(
        &mut self,
        inputs: &[bool],
        outputs: &mut [bool],
        score: &mut [f64],
    ) -> Result<(), Error>;

    /// Draws an output alone: the one that [`act_and_score`](Self::act_and_score) would.
    ///
    /// # Errors
    /// If a slice's length is wrong; nothing is drawn then.
    fn act(&mut self, inputs: &[bool], outputs: &mut [bool]) -> Result<(), Error>;

    /// How uncertain the bits of the output were that was drawn last: the mean of their entropies given the
    /// inputs, 0 to log 2 nats; an estimate where a kind says so. Nothing is drawn for it.
    ///
    /// # Errors
    /// If a slice's length is wrong.
    fn entropy_nats(&mut self, outputs: &[bool]) -> Result<f64, Error>;

    /// Which weights there are, and whose biases go with them: how a policy's parameters are those of
    /// [centred units](crate::Coding::Centred). Each weight comes once.
    fn links(&self) -> Vec<Link>;

    /// Takes random numbers from the start of a named stream from now on.
    fn draw_from(&mut self, seed: u64, stream: &str);

    /// Where the random numbers are, for [`set_random_state`](Self::set_random_state). Its length
    /// depends on settings and robot only.
    fn random_state(&self) -> Vec<u32>;

    /// Goes on with the random numbers of a policy of the same settings and robot, with the same bits.
    ///
    /// # Errors
    /// If the length is another, or no policy can be in that state; the policy is as before.
    fn set_random_state(&mut self, state: &[u32]) -> Result<(), Error>;

    /// The bytes of a safetensors file with the parameters, the same ones for the same parameters.
    ///
    /// # Errors
    /// What the format can't hold.
    fn to_safetensors(&self) -> Result<Vec<u8>, Error>;

    /// The parameters, `[n_parameters]`, in the bytes of a file that a policy of the same kind, sizes
    /// and connections made. The policy stays as it is.
    ///
    /// # Errors
    /// [`Error::OtherLayout`] if it's of another one, with what differs; a file that is damaged.
    fn read_safetensors(&self, bytes: &[u8]) -> Result<Vec<f64>, Error>;
}

/// The checks of lengths that acting begins with; with a score that is wished, its too.
pub(crate) fn check_act(
    policy: &dyn Policy,
    inputs: &[bool],
    outputs: &[bool],
    score: Option<&[f64]>,
) -> Result<(), Error> {
    let place = if score.is_some() { "Policy::act_and_score" } else { "Policy::act" };
    check_length(place, "inputs", policy.n_inputs(), inputs.len())?;
    check_length(place, "outputs", policy.n_outputs(), outputs.len())?;
    score.map_or(Ok(()), |score| {
        check_length(place, "score", policy.parameters().len(), score.len())
    })
}
