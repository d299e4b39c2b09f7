//! One list a family: what makes of it the enum of all kinds, how they're read and written.
//!
//! To add a kind: a file in the family's folder with its settings (`Default`, `Serialize`, `read`),
//! its code and its tests, and a line in the family's list. The contract tests run on every line.

/// Makes the enum of a family's settings. The first kind is the default; each implements the trait.
macro_rules! kinds {
    (
        $(#[$doc:meta])*
        $family:ident, dyn $behaviour:ident, $path:literal:
        $($(#[$about:meta])* $word:literal => $kind:ident($settings:ty),)+
    ) => {
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize)]
        #[serde(tag = "kind")]
        pub enum $family {
            $($(#[$about])* #[serde(rename = $word)] $kind($settings),)+
        }

        impl $family {
            /// Every kind with its default settings.
            #[must_use]
            pub fn all() -> Vec<Self> {
                vec![$(Self::$kind(<$settings>::default())),+]
            }

            /// The name in files.
            #[must_use]
            pub fn kind(&self) -> &'static str {
                match self { $(Self::$kind(_) => $word),+ }
            }

            /// What the kind does.
            #[must_use]
            pub fn get(&self) -> &dyn $behaviour {
                match self { $(Self::$kind(settings) => settings),+ }
            }

            /// Reads `kind` and what belongs to that kind.
            pub fn read(section: &mut config::Section<'_>) -> Option<Self> {
                type Reader<T> = fn(&mut config::Section<'_>) -> Option<T>;
                let readers: &[(&str, Reader<Self>)] =
                    &[$(($word, |section| <$settings>::read(section).map(Self::$kind))),+];
                let words: Vec<_> = readers.iter().map(|&(word, _)| (word, word)).collect();
                section.call($path);
                let rule = config::one_of(&words);
                let Some(word) = section.given_or("kind", rule, words[0].0) else {
                    section.accept_all();
                    return None;
                };
                section.call(format!("{} '{word}'", $path));
                let (_, reader) = readers.iter().find(|(known, _)| *known == word)?;
                reader(section)
            }
        }

        impl Default for $family {
            fn default() -> Self {
                Self::all().swap_remove(0)
            }
        }
    };
}
pub(super) use kinds;
