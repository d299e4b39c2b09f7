//! Reaching: how much nearer the centre of gravity came to a point, in the XY plane, in m for each
//! control step.
//!
//! ```text
//! r_t = |p - x_{t-1}| - |p - x_t|
//! ```
//!
//! The first point is drawn in the first control step. One that the robot has come near enough to is
//! reached, and the next is drawn: at a distance from where the robot then is, in a direction that is
//! uniform from the seed's stream `points`. So the sum of r over time is how far the robot was sent,
//! less what is left of the way. No sensor tells where the point is.

use std::f64::consts::TAU;

use config::{Rule, Section, within};
use nalgebra::{Point2, Vector2};
use rand_chacha::{ChaCha8Rng, rand_core::Rng};
use serde::Serialize;

use super::{Build, Extrinsic, model_scale};
use crate::{Error, RobotLayout, Transition};

/// Settings of reaching.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReachSettings {
    /// What a metre in a control step counts; by default what the model says for locomotion.
    #[serde(serialize_with = "model_scale::write")]
    pub scale: Option<f64>,
    /// From the robot to a new point, in m; 5.
    pub distance_m: f64,
    /// Nearer than this to a point it's reached, in m, less than `distance_m`; 0.5.
    pub radius_m: f64,
}

impl Default for ReachSettings {
    fn default() -> Self {
        Self { scale: None, distance_m: 5.0, radius_m: 0.5 }
    }
}

impl ReachSettings {
    pub(super) fn read(section: &mut Section<'_>) -> Option<Self> {
        let length = || within(1e-3, 1e5);
        let distance = length().about(
            "from where the robot is to a new point, in a direction drawn from the seed's stream \
             `points`, in m",
        );
        let radius = length()
            .about("nearer than this to a point it's reached, in m")
            .condition("below `distance_m`");
        let default = Self::default();
        let settings = Self {
            scale: model_scale::read(section),
            distance_m: section.or("distance_m", distance, default.distance_m),
            radius_m: section.or("radius_m", radius, default.radius_m),
        };
        if settings.radius_m >= settings.distance_m {
            let expected = format!("below distance_m, {}", settings.distance_m);
            section.refuse("radius_m", &expected, settings.radius_m);
        }
        Some(settings)
    }
}

impl Build for ReachSettings {
    fn build(&self, _: &RobotLayout, seed: u64) -> Result<Box<dyn Extrinsic>, Error> {
        Ok(Box::new(Reach {
            distance_m: self.distance_m,
            radius_m: self.radius_m,
            start: streams::named(seed, "points"),
            n_points: 0,
            point_m: Point2::origin(),
        }))
    }

    fn factor(&self, layout: &RobotLayout) -> f64 {
        model_scale::factor(self.scale, layout)
    }

    fn symbol(&self) -> &'static str {
        "R_Reach"
    }

    fn unit(&self) -> &'static str {
        "m"
    }
}

#[derive(Debug)]
struct Reach {
    distance_m: f64,
    radius_m: f64,
    start: ChaCha8Rng,
    /// Drawn so far: a point's direction depends on the seed and on its number alone.
    n_points: u64,
    /// The last of them.
    point_m: Point2<f64>,
}

impl Reach {
    fn draw(&mut self, from: Point2<f64>) {
        let mut rng = self.start.clone();
        rng.set_stream(self.n_points);
        // 53 bits, all that a double holds.
        let turn = (rng.next_u64() >> 11) as f64 / 9_007_199_254_740_992.0;
        let (sin, cos) = libm::sincos(TAU * turn);
        self.point_m = from + self.distance_m * Vector2::new(cos, sin);
        self.n_points += 1;
    }

    fn distance_m(&self, from: Point2<f64>) -> f64 {
        (self.point_m - from).norm()
    }
}

impl Extrinsic for Reach {
    fn value(&mut self, transition: &Transition<'_>) -> f64 {
        let [before, after] =
            [transition.before, transition.after].map(|state| state.centre_of_gravity_m.xy());
        if self.n_points == 0 {
            self.draw(before);
        }
        let (was_m, is_m) = (self.distance_m(before), self.distance_m(after));
        if is_m < self.radius_m {
            self.draw(after);
        }
        was_m - is_m
    }

    fn save(&self) -> Vec<u64> {
        vec![self.n_points, self.point_m.x.to_bits(), self.point_m.y.to_bits()]
    }

    fn restore(&mut self, state: &[u64]) -> Result<(), Error> {
        const EXPECTED: &str = "a number of points and the last one's place";
        let &[n_points, x, y] = state else {
            return Err(Error::State {
                expected: EXPECTED,
                found: format!("{} words", state.len()),
            });
        };
        let point_m = Point2::new(f64::from_bits(x), f64::from_bits(y));
        if !(point_m.x.is_finite() && point_m.y.is_finite()) {
            let found = format!("a point at ({}, {})", point_m.x, point_m.y);
            return Err(Error::State { expected: EXPECTED, found });
        }
        (self.n_points, self.point_m) = (n_points, point_m);
        Ok(())
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use nalgebra::Point3;

    use super::*;
    use crate::RobotState;

    /// A robot that goes straight to each point, half a metre in a control step, and what it sees.
    fn walk(seed: u64, n_steps: usize) -> (Vec<f64>, Vec<Point2<f64>>) {
        let settings = ReachSettings { distance_m: 3.0, radius_m: 0.25, scale: None };
        let mut task = settings.build(&RobotLayout::default(), seed).unwrap();
        let at = |place: Point2<f64>, z: f64| RobotState {
            centre_of_gravity_m: Point3::new(place.x, place.y, z),
            ..RobotState::default()
        };
        let mut place = Point2::new(1.0, -2.0);
        let (mut values, mut points) = (Vec::new(), Vec::new());
        for n in 0..n_steps {
            let point = match task.save()[..] {
                // Before the first step nobody knows where to go.
                [0, ..] => place,
                [_, x, y] => Point2::new(f64::from_bits(x), f64::from_bits(y)),
                _ => unreachable!(),
            };
            let way = point - place;
            let next = if way.norm() > 0.0 { place + way.normalize() * 0.5 } else { place };
            // Height doesn't count.
            let (before, after) = (at(place, n as f64), at(next, 0.0));
            let step = Transition::between(&before, &after);
            values.push(task.value(&step));
            points.push(point);
            place = next;
        }
        points.dedup();
        (values, points)
    }

    /// 3 m less 0.25 m take six steps of half a metre; each is worth what it brought.
    #[test]
    fn each_step_is_worth_what_it_brought_nearer() {
        let (values, points) = walk(7, 1 + 6 * 4);
        assert_eq!(values[0], 0.0);
        // Roundings of numbers of about 3.
        assert!(values[1..].iter().all(|value| (value - 0.5).abs() < 1e-14), "{values:?}");
        // The start, four points; a fifth was drawn in the last step.
        assert_eq!(points.len(), 5);
        for pair in points.windows(2) {
            assert!(((pair[1] - pair[0]).norm() - 3.0).abs() < 1e-13, "{points:?}");
        }
    }

    #[test]
    fn points_are_of_the_seed() {
        assert_eq!(walk(7, 50), walk(7, 50));
        assert_ne!(walk(7, 50).1, walk(8, 50).1);
    }

    /// 400 directions: the mean is within 5 standard errors, sqrt(1 / 2 n) each way, of nowhere.
    #[test]
    fn directions_are_even() {
        let (_, points) = walk(1, 1 + 6 * 400);
        let n = (points.len() - 1) as f64;
        let mean = (points[points.len() - 1] - points[0]) / (3.0 * n);
        assert!(mean.amax() < 5.0 * (0.5 / n).sqrt(), "{mean}");
    }

    #[test]
    fn a_state_without_sense_is_refused() {
        let mut task = ReachSettings::default().build(&RobotLayout::default(), 1).unwrap();
        let mut message = |state: &[u64]| task.restore(state).unwrap_err().to_string();
        assert!(message(&[]).ends_with("got 0 words"));
        let expected = "a reward's state must be a number of points and the last one's place, got a \
                        point at (NaN, 0)";
        assert_eq!(message(&[1, f64::NAN.to_bits(), 0]), expected);
    }
}
