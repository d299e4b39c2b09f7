//! Permutation tests: how often would a measure be as large if there were no dependence?
//!
//! X is shuffled among the samples that share the same z, which keeps p(x, z) and p(y, z) and
//! breaks any other tie of X and Y; without a condition it's shuffled among all. If X and Y are
//! independent given Z and the samples exchangeable, all shuffles are equally likely, so
//!
//! ```text
//! p = (1 + number of shuffles with at least the observed value) / (1 + number of shuffles)
//! ```
//!
//! is a valid p-value: P(p <= a) <= a for every a (B. Phipson and G. Smyth, *Permutation p-values
//! should never be zero*, 2010). For series whose samples depend on their neighbours it's an
//! approximation, too small if X itself is predictable from its past beyond z.
//!
//! Shuffles are Fisher and Yates's with ChaCha of 8 rounds. Its key is the seed and the name of
//! this stream, so the same seed elsewhere gives other numbers.

use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng, SeedableRng},
};

use crate::{
    column::Column,
    error::{Error, check_length, refused},
    information::{Estimator, Information, signed_entropies},
    mutual::Triple,
    transfer::{History, embed},
};

/// A permutation test.
///
/// ```
/// use infotheory::{Estimator, PermutationTest};
/// let test = PermutationTest { shuffles: 999, seed: 1, estimator: Estimator::PlugIn };
/// let found = test.mutual_information(b"aabbaabbccabca", b"xxyyxxyyzzxyzx")?;
/// assert!((found.p_value - 0.001).abs() < 1e-12);
/// # Ok::<(), infotheory::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PermutationTest {
    /// Number of shuffles, at least 1. The smallest p-value is 1 / (1 + shuffles).
    pub shuffles: u32,
    /// The same seed gives the same shuffles.
    pub seed: u64,
    /// What is estimated, from the data and from each shuffle.
    pub estimator: Estimator,
}

/// What a permutation test found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Significance {
    /// The measure of the data.
    pub observed: Information,
    /// Its mean over the shuffles: what is there by chance.
    pub shuffled_mean: Information,
    /// The standard deviation of the measure over the shuffles.
    pub shuffled_deviation: Information,
    /// How likely so much is by chance, 1 / (1 + shuffles) to 1.
    pub p_value: f64,
}

impl PermutationTest {
    /// Tests whether [`mutual_information`](crate::mutual_information) is more than chance gives.
    pub fn mutual_information<X: Copy + Ord, Y: Copy + Ord>(
        &self,
        x: &[X],
        y: &[Y],
    ) -> Result<Significance, Error> {
        const CALL: &str = "PermutationTest::mutual_information";
        check_length(CALL, "y", x.len(), y.len())?;
        let (x, y) = (Column::new(CALL, "x", x)?, Column::new(CALL, "y", y)?);
        let z = Column::constant(x.n_rows());
        self.run(CALL, &Triple { x, y, z })
    }

    /// Tests whether [`conditional_mutual_information`](crate::conditional_mutual_information) is more than chance gives.
    pub fn conditional_mutual_information<X: Copy + Ord, Y: Copy + Ord, Z: Copy + Ord>(
        &self,
        x: &[X],
        y: &[Y],
        z: &[Z],
    ) -> Result<Significance, Error> {
        const CALL: &str = "PermutationTest::conditional_mutual_information";
        self.run(CALL, &Triple::new(CALL, x, y, z)?)
    }

    /// Tests [`transfer_entropy`](crate::transfer_entropy): the source's pasts are shuffled among
    /// the moments at which the target had the same past.
    pub fn transfer_entropy<S: Copy + Ord, T: Copy + Ord>(
        &self,
        source: &[S],
        target: &[T],
        history: History,
    ) -> Result<Significance, Error> {
        const CALL: &str = "PermutationTest::transfer_entropy";
        self.run(CALL, &embed(CALL, source, target, history)?)
    }

    fn run(&self, call: &'static str, triple: &Triple) -> Result<Significance, Error> {
        if self.shuffles == 0 {
            return Err(refused(call, "shuffles", "at least 1", 0));
        }
        let mut shuffled = Shuffled::new(self.seed, triple);
        let observed = triple.information(self.estimator);
        // Tables with the same information can differ in the last bits. They count as equal.
        let threshold = observed.nats() - 1e-12;
        let (mut as_large, mut sum, mut squares) = (0_u32, 0.0, 0.0);
        for _ in 0..self.shuffles {
            shuffled.shuffle();
            let nats = shuffled.information(self.estimator).nats();
            as_large += u32::from(nats >= threshold);
            // From the observed value, so that the squares don't cancel.
            let difference = nats - observed.nats();
            sum += difference;
            squares += difference * difference;
        }
        let n = f64::from(self.shuffles);
        let mean = sum / n;
        Ok(Significance {
            observed,
            shuffled_mean: Information::from_nats(observed.nats() + mean),
            shuffled_deviation: Information::from_nats((squares / n - mean * mean).max(0.0).sqrt()),
            p_value: (1.0 + f64::from(as_large)) / (1.0 + n),
        })
    }
}

/// I(X; Y|Z) with X shuffled among equal z. Only H(X, Y, Z) changes.
struct Shuffled {
    random: ChaCha8Rng,
    /// [n_rows], sorted by z: ranks of x, and of the pair (y, z).
    x: Vec<u32>,
    yz: Vec<u32>,
    /// Ends of the runs of equal z.
    ends: Vec<usize>,
    columns: [Column; 3],
}

impl Shuffled {
    fn new(seed: u64, triple: &Triple) -> Self {
        let yz = triple.y.join(&triple.z);
        let z = triple.z.ranks();
        let mut rows: Vec<usize> = (0..z.len()).collect();
        rows.sort_by_key(|&row| z[row]);
        let ends =
            (1..=z.len()).filter(|&i| i == z.len() || z[rows[i]] != z[rows[i - 1]]).collect();
        Self {
            random: generator(seed),
            x: rows.iter().map(|&row| triple.x.ranks()[row]).collect(),
            yz: rows.iter().map(|&row| yz.ranks()[row]).collect(),
            ends,
            columns: [triple.x.join(&triple.z), yz, triple.z.clone()],
        }
    }

    fn shuffle(&mut self) {
        let mut start = 0;
        for &end in &self.ends {
            let run = &mut self.x[start..end];
            for i in (1..run.len()).rev() {
                // There are less than 2^32 rows.
                run.swap(i, below(&mut self.random, i as u32 + 1) as usize);
            }
            start = end;
        }
    }

    fn information(&self, estimator: Estimator) -> Information {
        let [xz, yz, z] = &self.columns;
        let xyz = Column::of_pairs(&self.x, &self.yz);
        let terms = [(1, xz), (1, yz), (-1, &xyz), (-1, z)];
        signed_entropies(self.x.len(), &terms, estimator)
    }
}

/// The stream that belongs to a seed and to the name of this use.
fn generator(seed: u64) -> ChaCha8Rng {
    let mut key = [0; 32];
    key[..8].copy_from_slice(&seed.to_le_bytes());
    key[8..].copy_from_slice(b"infotheory's permutation");
    ChaCha8Rng::from_seed(key)
}

/// A number below `bound` > 0, each equally likely: D. Lemire, *Fast random integer generation in
/// an interval* (2019).
fn below(random: &mut ChaCha8Rng, bound: u32) -> u32 {
    let surplus = bound.wrapping_neg() % bound;
    loop {
        let product = u64::from(random.next_u32()) * u64::from(bound);
        if product as u32 >= surplus {
            return (product >> 32) as u32;
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// 24,000 shuffles of 4 different symbols: each of the 24 orders 1,000 times, up to
    /// chi-square with 23 degrees of freedom, which exceeds 58.6 in 6 of 10^5 cases.
    #[test]
    fn every_order_is_equally_likely() {
        let symbols = [0, 1, 2, 3];
        let triple = Triple::new("test", &symbols, &symbols, &[0; 4]).unwrap();
        let mut shuffled = Shuffled::new(1, &triple);
        let mut counts: BTreeMap<Vec<u32>, u32> = BTreeMap::new();
        for _ in 0..24_000 {
            // From the same start: a walk evens out what single steps don't reach.
            shuffled.x.copy_from_slice(&[0, 1, 2, 3]);
            shuffled.shuffle();
            *counts.entry(shuffled.x.clone()).or_default() += 1;
        }
        assert_eq!(counts.len(), 24);
        let square = |&count: &u32| (f64::from(count) - 1000.0).powi(2) / 1000.0;
        let chi_square: f64 = counts.values().map(square).sum();
        assert!(chi_square < 58.6, "{chi_square}");
    }

    #[test]
    fn symbols_stay_with_their_condition() {
        let (x, z) = ([0, 1, 2, 3, 4, 5], [7, 3, 7, 3, 3, 1]);
        let triple = Triple::new("test", &x, &x, &z).unwrap();
        let mut shuffled = Shuffled::new(2, &triple);
        for _ in 0..100 {
            shuffled.shuffle();
            // Sorted by z: one row of 1, three of 3, two of 7.
            assert_eq!(shuffled.x[0], 5);
            assert!(shuffled.x[1..4].iter().all(|x| [1, 3, 4].contains(x)));
            assert!(shuffled.x[4..].iter().all(|x| [0, 2].contains(x)));
        }
    }

    #[test]
    fn numbers_below_a_bound_reach_all_of_them_alike() {
        let mut random = generator(3);
        // Two thirds of 2^32: without rejection, even numbers would come twice as often as odd ones.
        let bound = 2_863_311_531;
        let even = (0..30_000).filter(|_| below(&mut random, bound).is_multiple_of(2)).count();
        // 15,000 +- 87; six of those are exceeded in less than 10^-8 of seeds.
        assert!(even.abs_diff(15_000) < 520, "{even}");
        assert_eq!(below(&mut random, 1), 0);
    }
}
