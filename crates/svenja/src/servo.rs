//! What a servo does: the law of YARS, the simulator of the original experiments, and what resists it.
//!
//! # Position
//! ```text
//! difference = target - angle
//! v = sign(difference) * min(3 degrees, |difference|) / 3 degrees * speed limit
//! ```
//!
//! v is the motor's target velocity, and the torque limit its maximum torque. (K. Zahedi, A. von
//! Twickel, F. Pasemann: YARS, a physical 3D simulator for evolving controllers for real robots,
//! SIMPAR 2008. Its dead zones, of 0.01 rad and less, are left out: they have no visible effect.) What
//! would go farther in a step than the difference, as fast servos would within 3 degrees, never comes
//! to rest: so they slow down [earlier](LONGEST_STEP_S).
//!
//! # Speed, torque
//! A servo of speed has its command's share of the speed limit for v. One of torque drives at the
//! speed limit with the command's share of the torque limit: as long as it's slower, that torque is
//! what acts.
//!
//! # Resistance
//! Friction f and damping d act against the velocity w. Together with a motor that pulls with at most
//! L towards v, the axis has the torque
//!
//! ```text
//! T(w) = L sign(v - w) - f sign(w) - d w
//! ```
//!
//! which falls as w grows, and is 0 at one w*: at v if the motor can hold that, at (L - f)/d towards
//! it if it can't, at 0 if friction holds it. So one motor of Bullet's, that drives towards w* with at
//! most |T(w)|, does what both do, and never more than to w*, however strong the damping.

use crate::{Resistance, Servo, ServoKind};

/// Nearer to its target than this, in rad or m, a servo slows down.
const SLOWING_RAD: f64 = 3.0 * std::f64::consts::PI / 180.0;
const SLOWING_M: f64 = 0.01;

/// In s: a servo doesn't go past its target within this time.
const LONGEST_STEP_S: f64 = 0.01;

/// What a motor is told: to drive at a velocity, in rad/s or m/s, with a force of at most so much, in
/// N m or N.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ServoCommand {
    /// To be reached.
    pub velocity: f64,
    /// At least 0.
    pub max_force: f64,
}

/// The velocity to aim at, in rad/s, from the way to the target in rad and the speed limit in rad/s.
#[must_use]
pub fn servo_velocity(way_rad: f64, speed_limit_rad_s: f64) -> f64 {
    velocity(way_rad, speed_limit_rad_s, SLOWING_RAD)
}

fn velocity(way: f64, speed_limit: f64, slowing: f64) -> f64 {
    (way / slowing.max(speed_limit * LONGEST_STEP_S)).clamp(-1.0, 1.0) * speed_limit
}

/// What a servo does on an axis without resistance: `command` is -1 to 1, or, for a servo of position,
/// the way to the target in rad or m.
#[must_use]
pub fn servo_command(servo: &Servo, command: f64, is_linear: bool) -> ServoCommand {
    let Servo { kind, speed_limit, force_limit } = *servo;
    match kind {
        ServoKind::Position => {
            let slowing = if is_linear { SLOWING_M } else { SLOWING_RAD };
            let velocity = velocity(command, speed_limit, slowing);
            ServoCommand { velocity, max_force: force_limit }
        }
        ServoKind::Speed => {
            ServoCommand { velocity: command * speed_limit, max_force: force_limit }
        }
        ServoKind::Torque => ServoCommand {
            velocity: if command == 0.0 { 0.0 } else { speed_limit.copysign(command) },
            max_force: command.abs() * force_limit,
        },
    }
}

impl ServoCommand {
    /// What it comes to where the axis has a velocity and something resists it.
    #[must_use]
    pub fn against(self, resistance: &Resistance, velocity: f64) -> Self {
        let Resistance { friction, damping } = *resistance;
        let Self { velocity: wanted, max_force: most } = self;
        let spare = most - friction;
        let held = if spare - damping * wanted.abs() >= 0.0 {
            wanted
        } else if spare > 0.0 {
            (spare / damping).copysign(wanted)
        } else {
            0.0
        };
        // At rest friction is against where it's about to go.
        let moving = if velocity == 0.0 { held } else { velocity };
        let max_force = if moving != 0.0 {
            let short = if velocity == wanted { wanted } else { wanted - velocity };
            let pull = most.copysign(short);
            (pull - friction.copysign(moving) - damping * velocity).abs()
        } else if wanted == 0.0 {
            most + friction
        } else {
            friction - most
        };
        Self { velocity: held, max_force }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn far_away_at_full_speed_and_near_in_proportion() {
        let v = |difference_deg: f64| servo_velocity(difference_deg.to_radians(), 0.5);
        assert_eq!(v(10.0), 0.5);
        assert_eq!(v(-10.0), -0.5);
        assert_eq!(v(0.0), 0.0);
        // Rounding of the angle.
        assert!((v(1.5) - 0.25).abs() < 1e-15);
        assert!((v(-0.3) + 0.05).abs() < 1e-15);
        assert_eq!(servo_velocity(0.0, 0.5), 0.0);
    }

    /// 3 degrees in 0.01 s are 5.2 rad/s: slower ones are as they ever were.
    #[test]
    fn fast_ones_do_not_go_past_their_target() {
        for (speed, slowing) in [(0.5, SLOWING_RAD), (5.0, SLOWING_RAD), (30.0, 0.3), (1e4, 100.0)]
        {
            for way in [1e-6, 0.01, 0.04, 0.2, 3.0] {
                let v = servo_velocity(way, speed);
                assert_eq!(v, (way / slowing).min(1.0) * speed, "{speed} {way}");
                assert!(v * LONGEST_STEP_S <= way * (1.0 + 1e-15), "{speed} {way}");
            }
        }
    }

    const SERVO: Servo = Servo { kind: ServoKind::Speed, speed_limit: 4.0, force_limit: 10.0 };

    #[test]
    fn speed_and_torque_are_shares_of_their_limits() {
        let told = |kind, command| {
            let it = servo_command(&Servo { kind, ..SERVO }, command, false);
            (it.velocity, it.max_force)
        };
        assert_eq!(told(ServoKind::Speed, -0.5), (-2.0, 10.0));
        assert_eq!(told(ServoKind::Speed, 0.0), (0.0, 10.0));
        assert_eq!(told(ServoKind::Torque, -0.5), (-4.0, 5.0));
        assert_eq!(told(ServoKind::Torque, 1.0), (4.0, 10.0));
        assert_eq!(told(ServoKind::Torque, 0.0), (0.0, 0.0));
        let linear = |way| servo_command(&Servo { kind: ServoKind::Position, ..SERVO }, way, true);
        assert_eq!(linear(0.02).velocity, 2.0, "within what it does in 0.01 s");
    }

    #[test]
    fn nothing_that_resists_changes_nothing() {
        for velocity in [-5.0, 0.0, 1e-9, 2.0, 4.0] {
            for command in [-1.0, 0.0, 0.3] {
                let told = servo_command(&SERVO, command, false);
                assert_eq!(told.against(&Resistance::default(), velocity), told);
            }
        }
    }

    /// An axis of inertia 1, stepped as a motor does it: by at most its force, and not past its velocity.
    fn settle(told: ServoCommand, resistance: &Resistance, mut velocity: f64, seconds: f64) -> f64 {
        let step = 0.01;
        for _ in 0..(seconds / step) as usize {
            let ServoCommand { velocity: to, max_force } = told.against(resistance, velocity);
            velocity += (to - velocity).clamp(-max_force * step, max_force * step);
        }
        velocity
    }

    #[test]
    fn an_axis_comes_to_the_velocity_at_which_forces_balance() {
        let resistance = |friction, damping| Resistance { friction, damping };
        let told = |velocity, max_force| ServoCommand { velocity, max_force };
        let is = |told, resistance: &Resistance, from, expected: f64| {
            let found = settle(told, resistance, from, 60.0);
            assert!((found - expected).abs() < 1e-6, "{told:?} {resistance:?} {from}: {found}");
        };
        for from in [-7.0, -0.001, 0.0, 2.0, 30.0] {
            // The motor is strong enough; not quite; its friction alone is stronger.
            is(told(4.0, 10.0), &resistance(1.0, 0.5), from, 4.0);
            is(told(4.0, 10.0), &resistance(2.0, 4.0), from, 2.0);
            is(told(-4.0, 10.0), &resistance(2.0, 4.0), from, -2.0);
            is(told(4.0, 10.0), &resistance(11.0, 0.0), from, 0.0);
            is(told(0.0, 0.0), &resistance(0.5, 0.1), from, 0.0);
            // Damping that would change the velocity a thousand times over in a step.
            is(told(4.0, 10.0), &resistance(0.0, 1e5), from, 1e-4);
            is(told(0.0, 0.0), &resistance(0.0, 1e5), from, 0.0);
        }
    }

    /// exp(-d t) of damping, by Euler's steps; f t of friction.
    #[test]
    fn what_turns_freely_slows_down_as_it_should() {
        let free = ServoCommand::default();
        let damped = Resistance { friction: 0.0, damping: 0.5 };
        let expected = 3.0 * (1.0_f64 - 0.5 * 0.01).powi(200);
        assert!((settle(free, &damped, 3.0, 2.0) - expected).abs() < 1e-12);
        let rubbed = Resistance { friction: 0.7, damping: 0.0 };
        assert!((settle(free, &rubbed, -3.0, 2.0) + 3.0 - 1.4).abs() < 1e-12);
    }
}
