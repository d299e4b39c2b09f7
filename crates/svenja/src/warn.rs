//! What a model file may say and had better not: what Bullet takes and doesn't do well.
//!
//! # Far turns about y
//! Of the three angles of a 6-dof joint (about z, then the new y, then the newest x) Bullet corrects
//! those about x and z along axes on which they change at only cos b of the rate, with b the angle
//! about y, and takes back `erp` of the error as if it were the whole: `erp / cos b`. Beyond twice the
//! error a correction makes it larger. So what is locked about x or z is only held where
//!
//! ```text
//! erp < 2 cos b
//! ```
//!
//! which is 60 degrees for stops with an erp of 1, and never a quarter turn. Where both turn nothing
//! is locked, and ranges correct nothing within their ends.

//!
//! # Moments that nothing has
//! Each principal moment of a solid is at most the sum of the two others. Files of robots have others
//! now and then; Bullet takes them, and turns such a body as nothing would turn.

use config::Problem;

use crate::{
    Freedom, Turn,
    file::{BodyFile, JointFile, ModelFile},
};

/// What rounding in a file may add to a moment: a plate's is the sum of the others.
const SLACK: f64 = 1e-3;

/// Beyond, the stops that hold are so soft that an axis hardly comes near its ends.
const FARTHEST_DEG: f64 = 85.0;

pub(crate) fn warnings(file: &ModelFile) -> Vec<Problem> {
    let bodies = file.bodies.iter().filter_map(impossible);
    bodies.chain(file.joints.iter().filter_map(far_turn)).collect()
}

fn impossible(body: &BodyFile) -> Option<Problem> {
    let moments = body.inertia_kg_m2.as_ref()?;
    let (largest, sum) = (moments.value.max(), moments.value.sum());
    if largest <= (sum - largest) * (1.0 + SLACK) {
        return None;
    }
    let message = format!(
        "body '{}': inertia_kg_m2: no solid has a moment of {largest} beside two that are {} together",
        body.name.value,
        sum - largest
    );
    Some(Problem { place: moments.place.clone(), message })
}

fn far_turn(joint: &JointFile) -> Option<Problem> {
    let n_turns = joint.axes.iter().filter(|axis| !axis.freedom.is_linear()).count();
    if !joint.kind.is_six_dof() || n_turns == 3 {
        return None;
    }
    let about_y = Freedom::About(Turn::Y);
    let (index, axis) = joint.axes.iter().enumerate().find(|(_, axis)| axis.freedom == about_y)?;
    let [lower, upper] = axis.range?;
    let reach_rad = upper.max(-lower) + axis.stop_margin;
    let erp = joint.stop.erp;
    if erp < 2.0 * libm::cos(reach_rad) {
        return None;
    }
    let reach_deg = reach_rad.to_degrees();
    let held_deg = reach_deg.min(FARTHEST_DEG);
    let message = format!(
        "joint '{}': axes[{index}]: range_deg and its stops reach {reach_deg:.0} degrees about y, but \
         with a stop.erp of {erp} Bullet can't hold beyond {:.0} what the joint locks; with at most \
         {:.2}, the cosine, it can up to {held_deg:.0}",
        joint.name.value,
        libm::acos(erp / 2.0).to_degrees(),
        libm::cos(held_deg.to_radians()),
    );
    Some(Problem { place: axis.place.clone(), message })
}
