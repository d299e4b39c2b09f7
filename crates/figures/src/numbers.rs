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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_grouped_and_sentences_begin_large() {
        assert_eq!(["turning", "R_Loc", ""].map(capitalised), ["Turning", "R_Loc", ""]);
        assert_eq!([0, 999, 1000, 4_500_000].map(grouped), ["0", "999", "1,000", "4,500,000"]);
    }
}
