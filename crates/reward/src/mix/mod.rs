//! Mixes: what makes one reward of the extrinsic and the intrinsic part.

mod geometric;
mod linear;
mod schedule;

pub use geometric::GeometricSettings;
pub use linear::LinearSettings;
pub use schedule::Xi;

use super::kinds::kinds;

/// A way to mix.
pub trait Mix {
    /// Share of the extrinsic part, over time.
    fn xi(&self) -> &Xi;

    /// The mix of an extrinsic part and an intrinsic one that isn't negative.
    fn mix(&self, xi: f64, extrinsic: f64, intrinsic: f64) -> f64;

    /// What power of its parts' scale the mix has: times c for both is times c^degree for the mix.
    fn degree(&self) -> f64;

    /// 1 % of the mix's nominal maximum, which both parts have at 0.1: 0.01 * 0.1^degree.
    fn one_percent(&self) -> f64 {
        // A quotient, which is 0.0001 and 0.001 to the bit for the usual degrees.
        1.0 / libm::pow(10.0, 2.0 + self.degree())
    }
}

kinds! {
    /// The mix, with its settings: the list of all there are.
    MixSettings, dyn Mix, "reward.mix" ("how both parts make one number"):
    /// A product of powers: sign(e) (|e|^xi i^(1-xi))^power, with 0^0 = 1 and sign(0) = 0.
    "geometric" => Geometric(GeometricSettings),
    /// A weighted sum: xi e + (1-xi) i.
    "linear" => Linear(LinearSettings),
}
