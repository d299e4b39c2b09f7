//! Checks of what comes in, and the bound that keeps arithmetic finite.

use crate::Error;

/// Largest magnitude of a reward, and of an element of a score, a gradient or a parameter vector.
///
/// NaN and infinity are beyond it, of course. A bound well inside the range of `f64` does more:
/// products of two such numbers, and sums of as many of them as can be counted, are finite, so
/// nothing in this crate can overflow after its input was accepted.
pub const LIMIT: f64 = 1e100;

/// Largest count that `f64` holds exactly with all smaller ones, 2^53.
pub(crate) const LARGEST_COUNT: f64 = 9_007_199_254_740_992.0;

/// Refuses a slice of another length, or with an element beyond `limit`.
///
/// The first pass has no exits, so that it compiles to vector comparisons; only a slice that
/// fails is searched for the element.
pub(crate) fn slice(
    place: &'static str,
    what: &'static str,
    values: &[f64],
    expected: usize,
    limit: f64,
) -> Result<(), Error> {
    if values.len() != expected {
        return Err(Error::Length { place, what, expected, got: values.len() });
    }
    let inside = |value: f64| value.abs() <= limit; // false for NaN
    if values.iter().fold(true, |all, &value| all & inside(value)) {
        return Ok(());
    }
    match values.iter().position(|&value| !inside(value)) {
        Some(index) => Err(Error::Element { place, what, index, limit, value: values[index] }),
        None => Ok(()),
    }
}

/// Refuses a number for which `right` is false.
pub(crate) fn number(
    right: bool,
    place: &'static str,
    what: &'static str,
    expected: &'static str,
    value: f64,
) -> Result<(), Error> {
    if right { Ok(()) } else { Err(Error::Number { place, what, expected, value }) }
}

/// `n_parameters` times `value`, or an error where `vec!` would end the program.
pub(crate) fn filled(
    place: &'static str,
    n_parameters: usize,
    value: f64,
) -> Result<Vec<f64>, Error> {
    let mut values = Vec::new();
    match values.try_reserve_exact(n_parameters) {
        Ok(()) => values.resize(n_parameters, value),
        Err(_) => return Err(Error::Memory { place, n_parameters }),
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_first_bad_element_is_named_wherever_it_is() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1.1e100, -1.1e100] {
            for index in 0..13 {
                let mut values = [1.0; 14];
                values[index] = bad;
                values[13] = f64::NAN;
                let error = slice("f", "x", &values, 14, LIMIT).unwrap_err();
                assert!(
                    matches!(error, Error::Element { index: found, value, .. }
                        if found == index && value.to_bits() == bad.to_bits()),
                    "{error}"
                );
            }
        }
        assert_eq!(slice("f", "x", &[LIMIT, -LIMIT, 0.0], 3, LIMIT), Ok(()));
    }

    #[test]
    fn errors_say_place_expectation_and_value() {
        let message = |result: Result<(), Error>| result.unwrap_err().to_string();
        assert_eq!(message(slice("f", "x", &[1.0], 2, LIMIT)), "f: x must have 2 elements, got 1");
        assert_eq!(
            message(slice("f", "x", &[1.0, f64::NAN], 2, LIMIT)),
            "f: x[1] must be within -1e100 to 1e100, got NaN"
        );
        assert_eq!(message(number(false, "f", "x", "> 0", -2.0)), "f: x must be > 0, got -2.0");
        assert_eq!(
            message(filled("f", usize::MAX, 0.0).map(drop)),
            "f: 18446744073709551615 parameters take 147573952589676 MB, and there is no memory \
             for them"
        );
    }
}
