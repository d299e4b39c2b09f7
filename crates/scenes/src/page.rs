//! Self-contained pages: style, scripts and data are within, nothing is asked for from outside.
//!
//! Texts are escaped by `maud`. Scripts are classic ones in order, since modules don't load from
//! `file://`; a content security policy makes browsers refuse whatever would leave the page.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::{Error, viewer::Packed};

/// Remade by `make three`.
const THREE: &str = include_str!("../assets/three/three.min.js");
const STYLE: &str = include_str!("../assets/viewer/viewer.css");
const SCRIPTS: [&str; 4] = [
    include_str!("../assets/viewer/clip.js"),
    include_str!("../assets/viewer/stage.js"),
    include_str!("../assets/viewer/strip.js"),
    include_str!("../assets/viewer/viewer.js"),
];

const POLICY: &str =
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:";

/// A page with this body; the viewer's scripts are in it if it has something to show.
///
/// # Errors
/// As [`Packed::json`].
pub fn page(title: &str, body: &Markup, packed: &Packed) -> Result<String, Error> {
    let json = packed.json()?;
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="viewport" content="width=device-width, initial-scale=1";
                link rel="icon" href="data:,";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                (body)
                @if !packed.is_empty() {
                    script type="application/json" id="clips" { (PreEscaped(json)) }
                    script { (PreEscaped(THREE)) }
                    @for script in SCRIPTS { script { (PreEscaped(script)) } }
                }
            }
        }
    };
    Ok(page.into_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_inline_ends_its_element() {
        for script in SCRIPTS.iter().chain([&THREE]) {
            let script = script.to_ascii_lowercase();
            assert!(!script.contains("</script") && !script.contains("<!--"));
        }
        assert!(!STYLE.contains("</"));
    }
}
