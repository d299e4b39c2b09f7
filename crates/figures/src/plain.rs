//! Texts as terminals and figures get them. Names and descriptions come from files that anybody may
//! have written; a terminal obeys what it finds in a text (other colours, another title, lines that
//! are overwritten), and an SVG with a control character in it is none.

use std::{borrow::Cow, fmt::Write};

/// The text with its control characters, line breaks and tabs excepted, as Rust writes them:
/// `\u{1b}`.
#[must_use]
pub fn plain(text: &str) -> Cow<'_, str> {
    if !text.contains(is_command) {
        return text.into();
    }
    let mut plain = String::with_capacity(text.len());
    for character in text.chars() {
        if is_command(character) {
            // Writing to a string can't fail.
            let _ = write!(plain, "{}", character.escape_default());
        } else {
            plain.push(character);
        }
    }
    plain.into()
}

/// Control characters, and those that turn the direction of writing around, so that a line reads
/// other than it is.
fn is_command(character: char) -> bool {
    let turns = matches!(character, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns || (character.is_control() && !matches!(character, '\n' | '\t'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_shown_and_not_obeyed() {
        assert_eq!(
            plain("Svenja: six legs,\n\tone body, ξ = 1\n"),
            "Svenja: six legs,\n\tone body, ξ = 1\n"
        );
        assert_eq!(plain("\u{1b}[31mred\u{7}\r\u{9b}2J"), "\\u{1b}[31mred\\u{7}\\r\\u{9b}2J");
        assert_eq!(plain("gait\u{202e}lmot."), "gait\\u{202e}lmot.");
        for character in (0..=0x2100).filter_map(char::from_u32) {
            let text = format!("a{character}b");
            let shown = plain(&text);
            assert!(!shown.contains(is_command), "{text:?}");
            assert_eq!(shown == text, !is_command(character), "{text:?}");
        }
    }
}
