//! Files in other formats, told by how they begin: one line says more than a complaint a line.

/// Robots in XML, by their root element.
const ROOTS: [(&str, &str); 3] =
    [("robot", "a robot in URDF"), ("mujoco", "a model in MJCF"), ("sdf", "a model in SDF")];

/// What a text is that can't be TOML, with the byte where that is seen.
pub(crate) fn foreign(text: &str) -> Option<(usize, String)> {
    let start = skip_comments(text);
    let text = &text[start..];
    let what = match text.chars().next()? {
        '<' => xml(text),
        '{' => "JSON".into(),
        // A table's header is on one line and has a name.
        '[' if text[1..].starts_with(['\n', '\r', '{']) => "JSON".into(),
        _ if is_yaml(text) => "YAML".into(),
        _ => return None,
    };
    Some((start, what))
}

/// The first byte that is neither in a comment nor a space.
fn skip_comments(text: &str) -> usize {
    let mut rest = text.trim_start();
    while rest.starts_with('#') {
        rest = rest.find('\n').map_or("", |end| &rest[end..]).trim_start();
    }
    text.len() - rest.len()
}

fn xml(text: &str) -> String {
    let mut elements = text.split('<').skip(1);
    // Comments, too: what they have in them is no name or, at worst, another one's.
    let root = elements.find(|element| !element.starts_with(['?', '!'])).unwrap_or_default();
    let name = root.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default();
    let known = ROOTS.iter().find(|(root, _)| *root == name);
    known.map_or("XML".into(), |(_, what)| format!("XML, {what}"))
}

/// A mark, or a key with a colon, on the first line.
fn is_yaml(text: &str) -> bool {
    let line = text.lines().next().unwrap_or_default().trim_end();
    let is_name = |c: char| c.is_alphanumeric() || "_- ".contains(c);
    let has_key = line.split_once(':').is_some_and(|(key, value)| {
        !key.is_empty() && key.chars().all(is_name) && (value.is_empty() || value.starts_with(' '))
    });
    line == "---" || line.starts_with("%YAML") || has_key
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_told_by_their_beginning() {
        let urdf = "<?xml version=\"1.0\"?>\n<!-- an arm -->\n<robot name=\"arm\">\n</robot>\n";
        for (text, expected) in [
            (urdf, "XML, a robot in URDF"),
            ("\n<mujoco>", "XML, a model in MJCF"),
            ("<sdf version='1.6'>", "XML, a model in SDF"),
            ("<html>", "XML"),
            ("<", "XML"),
            ("{ \"name\": 1 }", "JSON"),
            ("[\n  1\n]", "JSON"),
            ("[{}]", "JSON"),
            ("--- \nname: worm", "YAML"),
            ("%YAML 1.2", "YAML"),
            ("# a worm\n\nname: worm", "YAML"),
        ] {
            assert_eq!(foreign(text).unwrap().1, expected, "{text}");
        }
    }

    /// Mistakes in TOML are none of these.
    #[test]
    fn toml_is_not_foreign() {
        for text in
            ["", "#", "# {", "[a]", "[[a]]", "a = {", "a = 'x: y'", "a", "'a: b' = 1", "a:b"]
        {
            assert_eq!(foreign(text), None, "{text}");
        }
    }
}
