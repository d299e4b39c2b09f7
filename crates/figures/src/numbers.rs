//! Numbers and words as people read them.

/// With a comma between thousands: `4,500,000`.
#[must_use]
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let groups = digits.as_bytes().rchunks(3).rev().map(String::from_utf8_lossy);
    groups.collect::<Vec<_>>().join(",")
}

/// With a capital letter first, as a sentence begins.
#[must_use]
pub fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// With three significant digits, and none behind the point that say nothing: `0.0512`, `123457`,
/// `1.50e-7`.
#[must_use]
pub fn three_digits(number: f64) -> String {
    match number.abs() {
        0.0 => "0".to_owned(),
        size if !(1e-5..1e6).contains(&size) => format!("{number:.2e}"),
        size => {
            let before = (size.log10().floor() as i32).max(-5);
            format!("{number:.*}", usize::try_from(2 - before).unwrap_or(0))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_grouped_and_sentences_begin_large() {
        assert_eq!(["turning", "R_Loc", ""].map(capitalised), ["Turning", "R_Loc", ""]);
        let numbers = [0.0, 0.005_123_4, -1.2345, 123_456.7, 1.5e-7].map(three_digits);
        assert_eq!(numbers, ["0", "0.00512", "-1.23", "123457", "1.50e-7"]);
        assert_eq!([0, 999, 1000, 4_500_000].map(grouped), ["0", "999", "1,000", "4,500,000"]);
    }
}
