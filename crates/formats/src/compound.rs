//! Several axes in one joint, as a 6-dof joint of Bullet's can have them.
//!
//! It first slides along x, y and z of its frame in the parent, then turns about z, then about the new
//! y, then about the newest x. So of a joint's axes those fit that slide first, in right angles to each
//! other, and then turn about axes through one point in right angles. Two that turn are z and x: with
//! y locked, nothing is near the angle of 90 degrees about y that three can't pass.

use nalgebra::{Matrix3, Point3, Rotation3, Unit, UnitQuaternion, Vector3};

use crate::robot::{Axis, Motion, across};

/// Axes are in right angles, or along each other, up to this sine: beyond the digits that files have,
/// and no more than a body is drawn askew without being noticed.
const ASKEW: f64 = 1e-3;

/// Lines pass through one point up to this, in m.
const APART_M: f64 = 1e-5;

/// A joint's axes in its frame.
#[derive(Clone, Debug)]
pub(crate) struct Fit {
    /// In the drawing.
    pub(crate) rotation: UnitQuaternion<f64>,
    /// In the drawing.
    pub(crate) anchor_m: Point3<f64>,
    /// The letter of each axis: 0, 1, 2 for x, y, z.
    pub(crate) letters: Vec<usize>,
    /// Whether each points against its letter.
    pub(crate) against: Vec<bool>,
}

/// Indices of those that fit together, the earlier ones first.
pub(crate) fn fitting(axes: &[Axis]) -> Vec<usize> {
    let mut kept: Vec<usize> = Vec::new();
    for i in 0..axes.len() {
        let mut tried: Vec<Axis> = kept.iter().map(|&k| axes[k].clone()).collect();
        tried.push(axes[i].clone());
        if fit(&tried).is_some() {
            kept.push(i);
        }
    }
    kept
}

/// How axes fit in one joint, if they do.
pub(crate) fn fit(axes: &[Axis]) -> Option<Fit> {
    let turns: Vec<&Axis> = axes.iter().filter(|it| it.motion == Motion::Turns).collect();
    let slides: Vec<&Axis> = axes.iter().filter(|it| it.motion == Motion::Slides).collect();
    if turns.len() > 3 || slides.len() > 3 || axes.is_empty() {
        return None;
    }
    let square = |a: &Axis, b: &Axis| a.direction.dot(&b.direction).abs() < ASKEW;
    let along = |a: &Axis, b: &Axis| a.direction.cross(&b.direction).norm() < ASKEW;
    let all_square = |axes: &[&Axis]| {
        axes.iter().enumerate().all(|(i, a)| axes[i + 1..].iter().all(|b| square(a, b)))
    };
    if !all_square(&turns) || !all_square(&slides) {
        return None;
    }
    // What slides behind a turn is carried along by it, unless it slides along what that turns about.
    let mut before: Vec<&Axis> = Vec::new();
    for axis in axes {
        match axis.motion {
            Motion::Turns => before.push(axis),
            Motion::Slides if before.iter().all(|turn| along(turn, axis)) => {}
            Motion::Slides => return None,
        }
    }
    if slides
        .iter()
        .any(|slide| turns.iter().any(|turn| !square(slide, turn) && !along(slide, turn)))
    {
        return None;
    }
    let rotation = rotation(&turns, &slides);
    let anchor_m = anchor(&turns, &slides)?;
    let columns = rotation.to_rotation_matrix().into_inner();
    let (mut letters, mut against) = (Vec::new(), Vec::new());
    for axis in axes {
        let along: Vector3<f64> = columns.transpose() * axis.direction.into_inner();
        let letter = along.iamax();
        letters.push(letter);
        against.push(along[letter] < 0.0);
    }
    Some(Fit { rotation, anchor_m, letters, against })
}

fn rotation(turns: &[&Axis], slides: &[&Axis]) -> UnitQuaternion<f64> {
    let (z, x) = match *turns {
        [first, second] => (first.direction, Some(second.direction)),
        [first, second, _] => {
            let x = Unit::new_normalize(second.direction.cross(&first.direction));
            (first.direction, Some(x))
        }
        [first, ..] => (first.direction, None),
        [] => (slides[0].direction, None),
    };
    // With room left the frame is along what slides.
    let other = slides.iter().map(|it| it.direction).find(|it| it.dot(&z).abs() < ASKEW);
    let x = x.or(other).unwrap_or_else(|| across(&z)[0]);
    let x = Unit::new_normalize(x.into_inner() - z.into_inner() * z.dot(&x));
    let columns = Matrix3::from_columns(&[x.into_inner(), z.cross(&x), z.into_inner()]);
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(columns))
}

/// A point on all axes that turn; of one or none its own.
fn anchor(turns: &[&Axis], slides: &[&Axis]) -> Option<Point3<f64>> {
    let distance =
        |point: &Point3<f64>, axis: &Axis| (point - axis.anchor_m).cross(&axis.direction).norm();
    let point = match *turns {
        [] => slides[0].anchor_m,
        [only] => only.anchor_m,
        [first, second, ..] => {
            // Where the first comes nearest to the second.
            let apart = second.anchor_m - first.anchor_m;
            let (u, v) = (first.direction, second.direction);
            let cos = u.dot(&v);
            let along = (apart.dot(&u) - apart.dot(&v) * cos) / (1.0 - cos * cos);
            first.anchor_m + u.into_inner() * along
        }
    };
    // Anchors that are written as the same point stay it.
    let written = turns.first().map_or(point, |first| first.anchor_m);
    let on_all = |point: &Point3<f64>| turns.iter().all(|axis| distance(point, axis) < APART_M);
    [written, point].into_iter().find(on_all)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(motion: Motion, direction: [f64; 3], anchor: [f64; 3]) -> Axis {
        Axis::new(motion, Unit::new_normalize(direction.into()), anchor.into())
    }

    fn turn(direction: [f64; 3]) -> Axis {
        axis(Motion::Turns, direction, [0.0; 3])
    }

    fn slide(direction: [f64; 3]) -> Axis {
        axis(Motion::Slides, direction, [0.0; 3])
    }

    /// Whether the joint with that frame moves as the axes do, one after the other.
    fn moves_alike(axes: &[Axis]) {
        let fit = fit(axes).unwrap();
        let positions = [0.3, -0.5, 0.7, 0.2, 0.1, -0.4];
        let one_by_one = axes
            .iter()
            .zip(positions)
            .rev()
            .fold(nalgebra::Isometry3::identity(), |moved, (axis, position)| {
                axis.moved(position) * moved
            });
        // Bullet's order: slides, then about z, y, x.
        let frame = nalgebra::Isometry3::from_parts(fit.anchor_m.coords.into(), fit.rotation);
        let mut inner = nalgebra::Isometry3::identity();
        let mut order: Vec<usize> = (0..axes.len()).collect();
        order
            .sort_by_key(|&i| (axes[i].motion == Motion::Turns, std::cmp::Reverse(fit.letters[i])));
        for i in order {
            let sign = if fit.against[i] { -1.0 } else { 1.0 };
            let unit = Unit::new_unchecked(Vector3::ith(fit.letters[i], sign));
            inner *= Axis::new(axes[i].motion, unit, Point3::origin()).moved(positions[i]);
        }
        let together = frame * inner * frame.inverse();
        let difference = (one_by_one.to_homogeneous() - together.to_homogeneous()).amax();
        // A few roundings.
        assert!(difference < 1e-12, "{difference} {fit:?}");
    }

    #[test]
    fn joints_move_as_their_axes_do_one_after_the_other() {
        moves_alike(&[turn([0.0, 1.0, 0.0])]);
        moves_alike(&[turn([2.0, 1.0, 1.0]), turn([0.0, -1.0, 1.0])]);
        // The humanoid's hips, right and left.
        moves_alike(&[turn([1.0, 0.0, 0.0]), turn([0.0, 0.0, 1.0]), turn([0.0, 1.0, 0.0])]);
        moves_alike(&[turn([-1.0, 0.0, 0.0]), turn([0.0, 0.0, 1.0]), turn([0.0, 1.0, 0.0])]);
        // The cheetah's rails.
        moves_alike(&[slide([1.0, 0.0, 0.0]), slide([0.0, 0.0, 1.0]), turn([0.0, 1.0, 0.0])]);
        // A rod that turns and shifts.
        moves_alike(&[turn([0.0, 1.0, 1.0]), slide([0.0, 1.0, 1.0])]);
        let first = axis(Motion::Turns, [0.0, 0.0, 1.0], [1.0, 0.0, 5.0]);
        let second = axis(Motion::Turns, [1.0, 0.0, 0.0], [-2.0, 0.0, 1.0]);
        moves_alike(&[first.clone(), second.clone()]);
        assert_eq!(fit(&[first, second]).unwrap().anchor_m, Point3::new(1.0, 0.0, 1.0));
    }

    #[test]
    fn what_no_joint_does_does_not_fit() {
        let x = turn([1.0, 0.0, 0.0]);
        assert_eq!(fitting(&[x.clone(), turn([1.0, 1.0, 0.0])]), [0], "askew");
        assert_eq!(fitting(&[x.clone(), x.clone()]), [0], "twice");
        assert_eq!(fitting(&[x.clone(), slide([0.0, 1.0, 0.0])]), [0], "carried along");
        let apart = axis(Motion::Turns, [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        assert_eq!(fitting(&[x, apart]), [0], "apart");
    }
}
