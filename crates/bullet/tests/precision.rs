//! Headers of one precision don't link with libraries of the other.
//!
//! `btScalar` is part of the names that the linker sees, so a build that mixes up the two can't
//! come into being. The shim relies on it: its own check (`cpp/state.h`) sees headers alone.

mod reference;

const SINGLE: usize = 4;
const DOUBLE: usize = 8;

#[test]
fn headers_link_with_libraries_of_their_own_precision() {
    for precision in [SINGLE, DOUBLE] {
        assert_eq!(reference::compile("precision.cc", precision, precision).err(), None);
    }
}

#[test]
fn headers_do_not_link_with_libraries_of_the_other_precision() {
    for (headers, libraries) in [(SINGLE, DOUBLE), (DOUBLE, SINGLE)] {
        let said = reference::compile("precision.cc", headers, libraries).err();
        let said = said.unwrap_or_else(|| "linked".into());
        assert!(
            said.contains("undefined reference to `btCapsuleShape::btCapsuleShape"),
            "{headers}-byte headers, {libraries}-byte libraries: {said}"
        );
    }
}
