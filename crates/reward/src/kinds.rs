//! One list a family: what makes of it the enum of all kinds, how they're read and written.
//!
//! To add a kind: a file in the family's folder with its settings (`Default`, `Serialize`, `read`,
//! each key with what it is [about](config::Rule::about)), its code and its tests, and a line in the
//! family's list, with what it is above it; then `make docs`. The contract tests run on every line.
//! CONTRIBUTING.md has examples.

/// Makes the enum of a family's settings, which stand at a path in files; after it, what a kind is
/// there. The first kind is the default; each implements the trait.
macro_rules! kinds {
    (
        $(#[$doc:meta])*
        $family:ident, dyn $behaviour:ident, $path:literal ($what:literal):
        $($(#[doc = $about:literal])+ $word:literal => $kind:ident($settings:ty),)+
    ) => {
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize)]
        #[serde(tag = "kind")]
        pub enum $family {
            $($(#[doc = $about])+ #[serde(rename = $word)] $kind($settings),)+
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
                let kinds = [$(($word, concat!($($about),+).trim_ascii())),+];
                section.call($path);
                section.kind("kind", $what, &kinds, |section, word| {
                    section.call(format!("{} '{word}'", $path));
                    match word {
                        $($word => <$settings>::read(section).map(Self::$kind),)+
                        _ => None,
                    }
                })
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
