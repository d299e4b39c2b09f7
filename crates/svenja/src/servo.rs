//! The servo law of YARS, the simulator of the original experiments.
//!
//! ```text
//! difference = target - angle
//! v = sign(difference) * min(3 degrees, |difference|) / 3 degrees * speed limit
//! ```
//!
//! v is the motor's target velocity, and the torque limit its maximum torque. (K. Zahedi, A. von
//! Twickel, F. Pasemann: YARS, a physical 3D simulator for evolving controllers for real robots,
//! SIMPAR 2008. Its dead zones, of 0.01 rad and less, are left out: they have no visible effect.)

/// Nearer to its target than this, in rad, a servo slows down.
const SLOWING_RAD: f64 = 3.0 * std::f64::consts::PI / 180.0;

/// The velocity to aim at, in rad/s, from target and angle in rad and the speed limit in rad/s.
#[must_use]
pub fn servo_velocity(target_rad: f64, angle_rad: f64, speed_limit_rad_s: f64) -> f64 {
    let difference = target_rad - angle_rad;
    (difference / SLOWING_RAD).clamp(-1.0, 1.0) * speed_limit_rad_s
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn far_away_at_full_speed_and_near_in_proportion() {
        let v = |difference_deg: f64| servo_velocity(difference_deg.to_radians(), 0.0, 0.5);
        assert_eq!(v(10.0), 0.5);
        assert_eq!(v(-10.0), -0.5);
        assert_eq!(v(0.0), 0.0);
        // Rounding of the angle.
        assert!((v(1.5) - 0.25).abs() < 1e-15);
        assert!((v(-0.3) + 0.05).abs() < 1e-15);
        assert_eq!(servo_velocity(0.2, 0.2, 0.5), 0.0);
    }
}
