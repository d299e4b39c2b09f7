//! Gibbs sampling of p(y, h | x), 16 chains at a time.
//!
//! ```text
//! y uniform at random; then, as often as told:
//!     h_j = 1 with probability sigmoid(c_j + (V x)_j + (W y)_j), all j
//!     y_i = 1 with probability sigmoid(b_i + (h' W)_i),          all i
//! ```
//! after the paper, section "The policy model". A unit is on if `u < 1 / (1 + 2^t)`, with u uniform
//! and `t = -log2(e) * activation`, which is decided as `u * (1 + 2^t) < 1`. All in `f32`: given
//! the sums of the tables, the probability differs from the sigmoid by less than 4e-7, and is
//! exactly 0 or 1 beyond activations of -18 and 18.

use crate::{
    rng::{States, Words},
    simd::{Kernel, LANES, Lanes},
    tables::{GROUP, Tables},
};

/// Lane groups that are updated together: hides the latencies of one behind the others'.
pub(crate) const TOGETHER: usize = 2;

/// The bits of chains: `[lane groups][unit groups]`, each word three units' bits of one chain.
#[derive(Clone, Debug)]
pub(crate) struct Bits {
    n_units: usize,
    words: Vec<Words>,
}

impl Bits {
    pub(crate) fn new(n_units: usize, n_lane_groups: usize) -> Self {
        let words = vec![Words([0; LANES]); n_units.div_ceil(GROUP) * n_lane_groups];
        Self { n_units, words }
    }

    /// What [`Bits::new`] allocates.
    pub(crate) fn bytes(n_units: usize, n_lane_groups: usize) -> usize {
        size_of::<Words>() * n_units.div_ceil(GROUP) * n_lane_groups
    }

    /// Three units' bits of a chain, and of all groups of three in turn.
    #[inline(always)]
    pub(crate) fn of_chain(&self, chain: usize) -> impl Iterator<Item = u32> + '_ {
        let n_groups = self.n_units.div_ceil(GROUP);
        let first = chain / LANES * n_groups;
        self.words[first..first + n_groups].iter().map(move |word| word.0[chain % LANES])
    }

    /// One chain's bits, `[n_units]`.
    pub(crate) fn unpack(&self, chain: usize, to: &mut [bool]) {
        for (word, to) in self.of_chain(chain).zip(to.chunks_mut(GROUP)) {
            for (bit, to) in to.iter_mut().enumerate() {
                *to = word >> bit & 1 == 1;
            }
        }
    }
}

/// The two conditionals, given x, in the sampler's unit.
#[derive(Clone, Debug)]
pub(crate) struct Conditionals {
    pub(crate) hidden: Tables,
    /// `[n_hidden]`: c + V x.
    pub(crate) hidden_biases: Vec<f32>,
    pub(crate) outputs: Tables,
    /// `[n_outputs]`: b.
    pub(crate) output_biases: Vec<f32>,
}

/// The chains' start and all their updates.
pub(crate) struct Sample<'a> {
    pub(crate) given: &'a Conditionals,
    pub(crate) updates: usize,
    pub(crate) rng: &'a mut [States],
    /// What h was is of no use to anyone: workspace for as many lane groups as go together.
    pub(crate) hidden: &'a mut Bits,
    /// As many lane groups as in `rng`, or more.
    pub(crate) outputs: &'a mut Bits,
}

impl Kernel for Sample<'_> {
    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let n_groups = self.outputs.n_units.div_ceil(GROUP);
        let (blocks, rest) = self.rng.as_chunks_mut::<TOGETHER>();
        let (of_blocks, of_rest) =
            self.outputs.words.split_at_mut(blocks.len() * TOGETHER * n_groups);
        let block = Block { lanes, given: self.given, updates: self.updates };
        for (rng, outputs) in blocks.iter_mut().zip(of_blocks.chunks_mut(TOGETHER * n_groups)) {
            block.sample(rng, &mut self.hidden.words, outputs);
        }
        for (rng, outputs) in rest.iter_mut().zip(of_rest.chunks_mut(n_groups)) {
            block.sample(std::array::from_mut(rng), &mut self.hidden.words, outputs);
        }
    }
}

/// What is the same for all chains.
struct Block<'a, L> {
    lanes: L,
    given: &'a Conditionals,
    updates: usize,
}

impl<L: Lanes> Block<'_, L> {
    /// `N` lane groups; within them, bits are `[unit groups]` of each in turn.
    #[inline(always)]
    fn sample<const N: usize>(
        &self,
        rng: &mut [States; N],
        hidden: &mut [Words],
        outputs: &mut [Words],
    ) {
        self.start(rng, outputs);
        for _ in 0..self.updates {
            let given = self.given;
            self.update(&given.hidden, &given.hidden_biases, (&*outputs, &mut *hidden), rng);
            self.update(&given.outputs, &given.output_biases, (&*hidden, &mut *outputs), rng);
        }
    }

    /// Bits uniform at random: a generator's word makes ten groups of three.
    #[inline(always)]
    fn start<const N: usize>(&self, rng: &mut [States; N], to: &mut [Words]) {
        let lanes = self.lanes;
        let n_groups = to.len() / N;
        let n_last = self.given.output_biases.len() - (n_groups - 1) * GROUP;
        for (rng, to) in rng.iter_mut().zip(to.chunks_mut(n_groups)) {
            let mut word = lanes.words(0);
            for (group, to) in to.iter_mut().enumerate() {
                word = if group % 10 == 0 { next(lanes, rng) } else { lanes.right::<3>(word) };
                let n_units = if group + 1 == n_groups { n_last } else { GROUP };
                lanes.store(lanes.and(word, lanes.words((1 << n_units) - 1)), &mut to.0);
            }
        }
    }

    /// All units of one layer, given the other's bits.
    #[inline(always)]
    fn update<const N: usize>(
        &self,
        tables: &Tables,
        biases: &[f32],
        (from, to): (&[Words], &mut [Words]),
        rng: &mut [States; N],
    ) {
        let lanes = self.lanes;
        let (n_from, n_to) = (from.len() / N, biases.len().div_ceil(GROUP));
        for (group, biases) in biases.chunks(GROUP).enumerate() {
            let mut bits = [lanes.words(0); N];
            for (place, bias) in biases.iter().enumerate() {
                let mut sums = [lanes.floats(*bias); N];
                let (groups, tables) = tables.terms(group * GROUP + place);
                for (from_group, table) in groups.iter().zip(tables) {
                    for (i, sum) in sums.iter_mut().enumerate() {
                        let index = lanes.load(&from[i * n_from + *from_group as usize].0);
                        *sum = lanes.add(*sum, lanes.lookup(table, index));
                    }
                }
                for (i, sum) in sums.into_iter().enumerate() {
                    let bit = is_on(lanes, sum, next(lanes, &mut rng[i]), lanes.words(1 << place));
                    bits[i] = lanes.or(bits[i], bit);
                }
            }
            for (i, bits) in bits.into_iter().enumerate() {
                lanes.store(bits, &mut to[i * n_to + group].0);
            }
        }
    }
}

/// `then` with probability `1 / (1 + 2^t)`, else 0; `random` decides.
#[inline(always)]
fn is_on<L: Lanes>(lanes: L, t: L::Floats, random: L::Words, then: L::Words) -> L::Words {
    // Far enough that no u is between the probability there and 0 or 1.
    let t = lanes.max(lanes.min(t, lanes.floats(32.0)), lanes.floats(-32.0));
    let odds = lanes.add(lanes.floats(1.0), power_of_two(lanes, t));
    // 23 bits as the mantissa of a number from 2^23, then minus 2^23 - 1/2, which is exact: u is an
    // odd multiple of 2^-24, times 2^23.
    let mantissa = lanes.right::<9>(random);
    let float = lanes.as_floats(lanes.or(mantissa, lanes.words(0x4b00_0000)));
    let u = lanes.sub(float, lanes.floats(8_388_607.5));
    lanes.less(lanes.mul(u, odds), lanes.floats(8_388_608.0), then)
}

/// `2^t` for t in -32..=32, relative error below 2.5e-7: t is split into the nearest whole number,
/// which goes to the exponent, and a rest in -1/2..=1/2, whose power is a polynomial (interpolation
/// at Chebyshev points, relative error 1.02e-7 before rounding).
#[inline(always)]
fn power_of_two<L: Lanes>(lanes: L, t: L::Floats) -> L::Floats {
    // 1.5 * 2^23: adding it rounds to a whole number, which is then in the lowest bits.
    let shift = lanes.floats(12_582_912.0);
    let shifted = lanes.add(t, shift);
    let rest = lanes.sub(t, lanes.sub(shifted, shift));
    let mut power = lanes.floats(POWER[0]);
    for coefficient in &POWER[1..] {
        power = lanes.add(lanes.mul(power, rest), lanes.floats(*coefficient));
    }
    let exponent = lanes.left::<23>(lanes.as_words(shifted));
    lanes.as_floats(lanes.plus(lanes.as_words(power), exponent))
}

/// Of 2^f on -1/2..=1/2, highest power first.
const POWER: [f32; 6] = [
    1.339_086_3e-3,
    9.676_032e-3,
    5.550_357e-2,
    2.402_210_7e-1,
    std::f32::consts::LN_2,
    1.000_000_1,
];

/// A step of xoshiro128++ in each lane.
#[inline(always)]
fn next<L: Lanes>(lanes: L, state: &mut States) -> L::Words {
    let rotated_7 = |a| lanes.or(lanes.left::<7>(a), lanes.right::<25>(a));
    let rotated_11 = |a| lanes.or(lanes.left::<11>(a), lanes.right::<21>(a));
    let [s0, s1, s2, s3] = [0, 1, 2, 3].map(|word| lanes.load(&state[word].0));
    let result = lanes.plus(rotated_7(lanes.plus(s0, s3)), s0);
    let (s2, s3) = (lanes.xor(s2, s0), lanes.xor(s3, s1));
    let (new_1, new_0) = (lanes.xor(s1, s2), lanes.xor(s0, s3));
    let new_2 = lanes.xor(s2, lanes.left::<9>(s1));
    for (to, word) in state.iter_mut().zip([new_0, new_1, new_2, rotated_11(s3)]) {
        lanes.store(word, &mut to.0);
    }
    result
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::simd::{Instructions, Portable};

    /// Lane `i` has the state 1, 2, 3, 4 but for `i` more in the first word.
    fn states() -> States {
        [1, 2, 3, 4].map(|word| {
            Words(std::array::from_fn(|lane| word + if word == 1 { lane as u32 } else { 0 }))
        })
    }

    /// The first outputs of the authors' C program (prng.di.unimi.it/xoshiro128plusplus.c) from the
    /// state 1, 2, 3, 4, as the crate `rand_xoshiro` has them in its tests.
    #[test]
    fn the_generator_is_xoshiro128_plus_plus() {
        let mut states = states();
        let outputs = [(); 6].map(|()| next(Portable, &mut states)[0]);
        assert_eq!(outputs, [641, 1573767, 3222811527, 3517856514, 836907274, 4247214768]);
    }

    /// Counts, for one activation, the values of the 23 random bits with which a unit is on.
    fn probability(t: f32) -> f64 {
        // On below a bound, which is found by halving.
        let (mut below, mut from) = (0, 1 << 23);
        while below < from {
            let middle = (below + from) / 2;
            if is_on(Portable, [t; LANES], [middle << 9; LANES], [1; LANES])[0] == 1 {
                below = middle + 1
            } else {
                from = middle
            }
        }
        f64::from(below) / f64::from(1 << 23)
    }

    #[test]
    fn a_unit_is_on_with_the_sigmoids_probability() {
        let mut largest = 0.0f64;
        for i in -40_000..=40_000 {
            let activation = f64::from(i) / 1000.0;
            let t = crate::tables::negative_bits(activation);
            // Without the rounding of t, which is the tables' business.
            let exact = 1.0 / (1.0 + libm::exp2(f64::from(t)));
            largest = largest.max((probability(t) - exact).abs());
            if activation.abs() > 18.0 {
                assert_eq!(probability(t), if i > 0 { 1.0 } else { 0.0 }, "{activation}");
            }
        }
        assert!(largest < 4e-7, "{largest:e}");
        // A coin is fair to the last bit, and at the ends bounds are half a step from 0 and 1.
        assert_eq!(probability(0.0), 0.5);
        assert_eq!([probability(23.99), probability(24.01)], [1.0 / f64::from(1 << 23), 0.0]);
    }

    #[test]
    fn a_power_of_two_is_as_accurate_as_it_says() {
        for i in -320_000..=320_000 {
            let t = i as f32 / 10_000.0;
            let exact = libm::exp2(f64::from(t));
            let error = (f64::from(power_of_two(Portable, [t; LANES])[0]) - exact).abs() / exact;
            assert!(error < 2.5e-7, "{t}: {error:e}");
        }
    }

    /// Draws at many activations, moderate and huge, and keeps the bits.
    struct Decide<'a>(&'a mut Vec<[u32; LANES]>);

    impl Kernel for Decide<'_> {
        #[inline(always)]
        fn run<L: Lanes>(self, lanes: L) {
            let mut states = states();
            for i in -20..=20 {
                let t = lanes.floats(0.003 * (i * i * i) as f32);
                for t in [t, lanes.mul(t, lanes.floats(1e5))] {
                    let mut bits = [0; LANES];
                    let on = is_on(lanes, t, next(lanes, &mut states), lanes.words(4));
                    lanes.store(on, &mut bits);
                    self.0.push(bits);
                }
            }
        }
    }

    #[test]
    fn all_instructions_decide_alike() {
        let decide = |instructions: Instructions| {
            let mut bits = Vec::new();
            instructions.detect().unwrap().run(Decide(&mut bits));
            bits
        };
        let expected = decide(Instructions::Portable);
        assert!(expected.as_flattened().contains(&4) && expected.as_flattened().contains(&0));
        for instructions in Instructions::available() {
            assert_eq!(decide(instructions), expected, "{instructions:?}");
        }
    }
}
