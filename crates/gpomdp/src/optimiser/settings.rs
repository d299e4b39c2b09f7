//! One declaration a setting: what makes of it a field, its default, its check and its description.

/// A number that an optimiser is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Setting {
    /// The name of its field, and its key in files.
    pub name: &'static str,
    /// What it means, in words that go on from "the": "learning rate".
    pub about: &'static str,
    /// What it must be, in words that go on from "must be".
    pub expected: &'static str,
}

/// Makes of an optimiser's settings the struct, its defaults and its checks. A line is
///
/// ```text
/// name: "what it means", default, "what it must be", |settings| whether it is;
/// ```
macro_rules! settings {
    (
        $(#[$doc:meta])*
        $settings:ident {
            $($name:ident: $about:literal, $default:literal, $expected:literal, $fits:expr;)+
        }
    ) => {
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct $settings {
            $(
                #[doc = concat!("The ", $about, ": ", $expected, "; ", $default, " by default.")]
                pub $name: f64,
            )+
        }

        impl Default for $settings {
            fn default() -> Self {
                Self { $($name: $default),+ }
            }
        }

        impl $settings {
            pub(super) const ALL: &[super::Setting] = &[$(super::Setting {
                name: stringify!($name),
                about: $about,
                expected: $expected,
            }),+];

            /// Refuses the first one that is out of range.
            fn check(&self, place: &'static str) -> Result<(), crate::Error> {
                $({
                    let fits: fn(&Self) -> bool = $fits;
                    let name = stringify!($name);
                    crate::check::number(fits(self), place, name, $expected, self.$name)?;
                })+
                Ok(())
            }
        }
    };
}
pub(super) use settings;
