//! Where the mass of some bodies is.

use nalgebra::{Point3, Vector3};

/// The centre of gravity of bodies, each with its mass in kg and its centre of mass in m.
pub fn centre_of_gravity_m(bodies: impl IntoIterator<Item = (f64, Vector3<f64>)>) -> Point3<f64> {
    let (mut mass, mut moment) = (0.0, Vector3::zeros());
    for (mass_kg, position_m) in bodies {
        mass += mass_kg;
        moment += position_m * mass_kg;
    }
    (moment / mass).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_nearer_to_what_is_heavier() {
        let bodies = [(3.0, Vector3::new(1.0, 0.0, 2.0)), (1.0, Vector3::new(5.0, -4.0, 2.0))];
        assert_eq!(centre_of_gravity_m(bodies), Point3::new(2.0, -1.0, 2.0));
    }
}
