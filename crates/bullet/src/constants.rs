//! What bindgen reads from Bullet's headers when the crate is built.

pub(crate) use read::*;

#[allow(non_upper_case_globals, non_camel_case_types, unreachable_pub, dead_code, clippy::all)]
mod read {
    include!(concat!(env!("OUT_DIR"), "/constants.rs"));
}
