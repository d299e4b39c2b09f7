//! Logarithms of counts as integers, so that sums of them are exact.
//!
//! The `libm` crate's `log`, the same on every machine, gives ln n as a double. For n >= 2 it's a
//! multiple of 2^-53, and ln 1 = 0. So ln n in units of 2^-53 is an integer, and sums of
//! n ln n are integers too, the same in whatever order they are taken, and after however many
//! additions and subtractions. They round once, at the end.

/// ln n in units of 2^-53, for n >= 1; 0 for n = 0. Below 2^59, since n < 2^64.
pub(crate) fn ln_fixed(n: u64) -> i64 {
    if n == 0 {
        return 0;
    }
    // The power of two only moves the exponent, and what is left is an integer.
    (libm::log(n as f64) * TWO_53) as i64
}

/// n ln n in units of 2^-53.
pub(crate) fn n_ln_n(n: u64) -> i128 {
    i128::from(n) * i128::from(ln_fixed(n))
}

/// A sum in units of 2^-53, over n, in nats. Rounds twice: to a double, and in the division.
pub(crate) fn nats(sum: i128, n: u64) -> f64 {
    sum as f64 / TWO_53 / n as f64
}

const TWO_53: f64 = 9_007_199_254_740_992.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_lost_in_the_integers() {
        for n in (2..10_000).chain((14..64).map(|k| (1 << k) - 1)) {
            assert_eq!(ln_fixed(n) as f64 / TWO_53, libm::log(n as f64), "{n}");
        }
        assert_eq!((ln_fixed(0), ln_fixed(1), n_ln_n(0)), (0, 0, 0));
    }

    #[test]
    fn the_greatest_counts_do_not_overflow() {
        assert!(ln_fixed(u64::MAX) < 1 << 59);
        assert!(n_ln_n(u64::MAX) < 1 << 123);
    }
}
