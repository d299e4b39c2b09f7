//! A small made-up clip for tests: a block that slides along +y by 0.1 m a frame, with a ball before
//! it and a rod behind.

use nalgebra::Point3;
use runs::{Recording, RecordingLayout};
use svenja::{Hull, Morphology};

use super::{Clip, Quantity, RewardParts};

pub(super) const MODEL: &str = r##"
name = "Slider"
heading = { body = "block", axis = [0.0, 1.0, 0.0] }
feet = ["ball"]
penalised = ["rod"]

[[body]]
name = "block"
mass_kg = 2.0
position_m = [0.0, 0.0, 0.2]
shape = { kind = "box", half_extents_m = [0.2, 0.3, 0.1] }
colour = "#808080"

[[body]]
name = "ball"
mass_kg = 1.0
position_m = [0.0, 0.5, 0.1]
shape = { kind = "sphere", radius_m = 0.1 }

[[body]]
name = "rod"
mass_kg = 1.0
position_m = [0.0, -0.5, 0.1]
shape = { kind = "capsule", radius_m = 0.05, from_m = [-0.2, 0.0, 0.0], to_m = [0.2, 0.0, 0.0] }

[[joint]]
name = "front"
kind = "fixed"
parent = "block"
child = "ball"
anchor_m = [0.0, 0.4, 0.0]

[[joint]]
name = "back"
kind = "fixed"
parent = "block"
child = "rod"
anchor_m = [0.0, -0.4, 0.0]
"##;

/// Those of the paper.
pub(super) const PARTS: RewardParts = RewardParts {
    task: Quantity { symbol: "R_Loc", unit: "m" },
    information: Some(Quantity { symbol: "R_MI", unit: "nats" }),
};

/// As training records them; the viewer shows some.
const TERMS: [&str; 8] =
    ["reward", "extrinsic_raw", "2", "intrinsic_nats", "4", "5", "penalty", "7"];

pub(super) fn morphology() -> Morphology {
    Morphology::parse("slider.toml", MODEL).unwrap()
}

/// `n_steps` of 2 frames of 0.05 s, from control step 10. In odd steps the ball touches.
pub(super) fn recording(n_steps: usize) -> Recording {
    let names = |names: &[&str]| names.iter().map(ToString::to_string).collect::<Vec<_>>();
    let morphology = morphology();
    let half = 0.5_f32.sqrt();
    let frame = |frame: usize| {
        let bodies = morphology.bodies().iter();
        bodies.flat_map(move |body| {
            let at = body.pose.translation.vector;
            let y = at.y as f32 + 0.1 * frame as f32;
            // The rod is turned by a quarter about z.
            let (z, w) = if body.name == "rod" { (half, half) } else { (0.0, 1.0) };
            [at.x as f32, y, at.z as f32, 0.0, 0.0, z, w]
        })
    };
    Recording {
        layout: RecordingLayout {
            actuators: Vec::new(),
            bodies: names(&["block", "ball", "rod"]),
            frames_per_step: 2,
            seconds_per_frame: 0.05,
            sensors: names(&["ball"]),
            terms: TERMS.map(str::to_owned).into(),
        },
        first_control_step: 10,
        n_steps,
        poses: (0..2 * n_steps).flat_map(frame).collect(),
        sensors: (0..n_steps).map(|step| (step % 2) as f32).collect(),
        actions: Vec::new(),
        contacts: (0..n_steps).flat_map(|step| [0, (step % 2) as u8, 0]).collect(),
        terms: (0..8 * n_steps).map(|i| i as f64).collect(),
    }
}

pub(super) fn clip(n_steps: usize) -> Clip {
    Clip::new("a title".into(), PARTS, morphology(), recording(n_steps)).unwrap()
}

/// On a square of 0.2 m, 0.6 m high; its volume is 0.008 m³.
pub(super) fn pyramid() -> Hull {
    let corners =
        [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [0.3, 0.2, 6.0]];
    Hull::around(&corners.map(|corner| Point3::from(corner) * 0.1)).unwrap()
}
