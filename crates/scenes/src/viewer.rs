//! The 3-D viewer of a page: clips packed as JSON for `assets/viewer/*.js`, which draws them with
//! three.js, and the markup that it works on.
//!
//! Poses are packed in 16 bits a number ([`Packing`]); [`Packed::precision`] says what that means in m
//! and degrees.

use base64::{Engine, engine::general_purpose::STANDARD};
use maud::{Markup, html};
use runs::Packing;
use serde::Serialize;
use svenja::{Body, Collider, Morphology, Shape};

use super::{Clip, Error, Quantity, RewardParts};

/// Numbers of a pose.
const POSE: usize = 7;

/// A replay page has at most so many bytes of recordings: what a browser opens without a pause.
pub const PAGE_BYTES: usize = 40_000_000;

/// Below this many frames a second motion stutters: then rather show less of it.
const LEAST_HZ: f64 = 20.0;

/// Those of a recording's terms that the strip shows, by the names that training gives them.
pub const TERMS: [&str; 4] = ["reward", "extrinsic_raw", "intrinsic_nats", "penalty"];

/// All that a page shows in 3-D.
#[derive(Debug, Default, Serialize)]
pub struct Packed {
    models: Vec<PackedModel>,
    clips: Vec<PackedClip>,
}

#[derive(Debug, PartialEq, Serialize)]
struct PackedModel {
    name: String,
    bodies: Vec<PackedBody>,
    /// Contact sensors, as the strip shows them.
    rows: Vec<ContactRow>,
}

#[derive(Debug, PartialEq, Serialize)]
struct PackedBody {
    name: String,
    mass_kg: f64,
    colour: String,
    penalised: bool,
    shapes: Vec<PackedCollider>,
}

/// A shape where it lies in its body.
#[derive(Debug, PartialEq, Serialize)]
struct PackedCollider {
    #[serde(flatten)]
    shape: PackedShape,
    position: [f64; 3],
    /// x, y, z, w
    rotation: [f64; 4],
}

#[derive(Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum PackedShape {
    Box {
        half: [f64; 3],
    },
    Sphere {
        radius: f64,
    },
    Capsule {
        radius: f64,
        from: [f64; 3],
        to: [f64; 3],
    },
    Cylinder {
        radius: f64,
        from: [f64; 3],
        to: [f64; 3],
    },
    Ellipsoid {
        radii: [f64; 3],
    },
    /// x, y, z of the three corners of each triangle, anticlockwise from outside.
    Hull {
        corners: Vec<f32>,
    },
}

#[derive(Debug, PartialEq, Serialize)]
struct ContactRow {
    body: usize,
    name: String,
    short: String,
}

#[derive(Debug, Serialize)]
struct PackedClip {
    group: String,
    label: String,
    note: String,
    model: usize,
    first_control_step: u64,
    seconds_per_step: f64,
    seconds_per_frame: f64,
    /// Of the first frame, from the beginning of the first step.
    first_frame_s: f64,
    #[serde(flatten)]
    packing: Packing,
    poses: String,
    contacts: String,
    terms: Vec<PackedTerm>,
}

#[derive(Debug, Serialize)]
struct PackedTerm {
    name: String,
    unit: String,
    values: String,
}

impl Packed {
    /// Adds a clip, its end if it's longer than `most_bytes` allow, under a heading of the chooser.
    pub fn add(&mut self, group: &str, label: &str, clip: &Clip, most_bytes: usize) {
        let model = PackedModel::of(clip.morphology());
        let known = self.models.iter().position(|other| *other == model);
        let index = known.unwrap_or(self.models.len());
        if known.is_none() {
            self.models.push(model);
        }
        self.clips.push(pack(group, label, index, clip, most_bytes));
    }

    /// Whether there's nothing to show.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.clips.is_empty()
    }

    /// How far a drawn position may be from the recorded one, in m, and an orientation in degrees.
    #[must_use]
    pub fn precision(&self) -> [f64; 2] {
        let positions = self.clips.iter().map(|clip| clip.packing.position_m());
        [positions.fold(0.0, f64::max), Packing::TURN_RAD.to_degrees()]
    }

    /// As the content of a `<script>`: nothing in it can end the element.
    ///
    /// # Errors
    /// None in practice: what JSON can't hold isn't in a clip.
    pub fn json(&self) -> Result<String, Error> {
        Ok(serde_json::to_string(self)?.replace('<', "\\u003c"))
    }

    /// The viewer. `autoplay` begins at once.
    #[must_use]
    pub fn markup(&self, autoplay: bool) -> Markup {
        let [position, turn] = self.precision();
        html! {
            section .viewer data-viewer="clips" data-autoplay[autoplay] tabindex="-1" aria-label="3-D replay" {
                div .bar {
                    label hidden[self.clips.len() == 1] { "Watch " (self.chooser()) }
                    span .faint data-part="note" {}
                }
                div .stage {
                    canvas .scene data-part="scene" tabindex="0" aria-label="The robot in 3-D: drag to turn, wheel or two fingers to come nearer" {}
                    p .no-webgl data-part="no-webgl" hidden {
                        "This browser shows no WebGL, so the robot can't be drawn. The strip below and all else on this page work; "
                        code { "itarl replay CELL --gif FILE" } " makes a film that shows everywhere."
                    }
                }
                div .bar {
                    button type="button" data-part="play" aria-pressed="false" { "Play" }
                    input type="range" data-part="slider" aria-label="Time" min="0" max="1" step="any" value="0";
                    output data-part="time" {}
                    label { "Speed " select data-part="speed" {
                        @for speed in ["0.1", "0.25", "0.5", "1", "2", "4"] {
                            option value=(speed) selected[speed == "1"] { (speed) " \u{d7}" }
                        }
                    } }
                    button type="button" data-part="follow" aria-pressed="true" { "Following" }
                    button type="button" data-part="reset" { "Reset view" }
                }
                output .where data-part="where" {}
                canvas .strip data-part="strip" aria-label="Contacts and reward terms over time" {}
                div .legend {
                    span .contact { i {} "touches the ground" }
                    span .warning { i {} "touches, and is penalised for it" }
                    span .path { i {} "path of the centre of gravity" }
                }
                ul .keys {
                    @for (key, what) in KEYS { li { @for key in key.split(' ') { kbd { (key) } " " } (what) } }
                }
                p .faint {
                    "Poses are packed in 16 bits: positions to "
                    (format!("{:.1}", 1e3 * position)) " mm, orientations to " (format!("{turn:.3}"))
                    " degrees; between frames they are interpolated. The grid's bold lines are 5 m apart, or 1 m around small robots."
                }
            }
        }
    }

    fn chooser(&self) -> Markup {
        let groups = self.clips.chunk_by(|a, b| a.group == b.group);
        let mut index = 0..;
        html! {
            select data-part="clip" {
                @for clips in groups {
                    optgroup label=(clips[0].group) {
                        @for (clip, i) in clips.iter().zip(&mut index) {
                            option value=(i) { (clip.label) }
                        }
                    }
                }
            }
        }
    }
}

const KEYS: [(&str, &str); 6] = [
    ("space", "play, pause"),
    ("\u{2190} \u{2192}", "a control step; with shift, a second"),
    ("home end", "first, last"),
    ("+ -", "speed"),
    ("f", "follow or free"),
    ("r", "reset the view"),
];

impl PackedModel {
    fn of(morphology: &Morphology) -> Self {
        let bodies = morphology.bodies();
        let packed = bodies.iter().enumerate().map(|(i, body)| PackedBody {
            name: body.name.clone(),
            mass_kg: body.mass_kg,
            colour: colour(body),
            penalised: morphology.penalised().contains(&i),
            shapes: body.colliders.iter().map(PackedCollider::from).collect(),
        });
        let rows = morphology.contacts().iter().enumerate().map(|(i, &body)| ContactRow {
            body,
            name: format!("{} {}", i + 1, bodies[body].name),
            short: match morphology.feet().contains(&body) {
                true => format!("foot {}", i + 1),
                false => format!("part {}", i + 1),
            },
        });
        Self { name: morphology.name().into(), bodies: packed.collect(), rows: rows.collect() }
    }
}

/// `#rrggbb`
fn colour(body: &Body) -> String {
    let [red, green, blue] = body.colour;
    format!("#{red:02x}{green:02x}{blue:02x}")
}

impl From<&Collider> for PackedCollider {
    fn from(Collider { shape, pose }: &Collider) -> Self {
        let (position, rotation) = (pose.translation.vector, pose.rotation.coords);
        Self { shape: shape.into(), position: position.into(), rotation: rotation.into() }
    }
}

impl From<&Shape> for PackedShape {
    fn from(shape: &Shape) -> Self {
        let ends = |rod: &svenja::Rod| (rod.radius_m, rod.from_m.into(), rod.to_m.into());
        match shape {
            Shape::Box { half_extents_m } => Self::Box { half: (*half_extents_m).into() },
            Shape::Sphere { radius_m } => Self::Sphere { radius: *radius_m },
            Shape::Capsule(rod) => {
                let (radius, from, to) = ends(rod);
                Self::Capsule { radius, from, to }
            }
            Shape::Cylinder(rod) => {
                let (radius, from, to) = ends(rod);
                Self::Cylinder { radius, from, to }
            }
            Shape::Ellipsoid { radii_m } => Self::Ellipsoid { radii: (*radii_m).into() },
            Shape::Hull(hull) => {
                let corners = hull.facets_m().flatten().flat_map(|it| [it.x, it.y, it.z]);
                Self::Hull { corners: corners.map(|value| value as f32).collect() }
            }
        }
    }
}

/// Which part of a clip is packed: every so many frames of the last steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Selection {
    first_step: usize,
    every: usize,
}

impl Selection {
    /// As much as fits: first fewer frames, as long as motion stays smooth, then fewer steps.
    fn of(clip: &Clip, most_bytes: usize) -> Self {
        let layout = &clip.recording().layout;
        let (steps, frames) = (clip.recording().n_steps, layout.frames_per_step);
        // In Base64, which takes 4 letters for 3 bytes.
        let frame_bytes = layout.bodies.len() * POSE * size_of::<i16>() * 4 / 3;
        let step_bytes = layout.bodies.len() * 4 / 3;
        let fits = |every: usize| {
            let bytes = frame_bytes * frames.div_ceil(every) + step_bytes;
            (most_bytes / bytes.max(1)).max(1)
        };
        let smooth = (1.0 / (LEAST_HZ * layout.seconds_per_frame) + 1e-9) as usize;
        let every =
            (1..=smooth.max(1)).find(|&every| fits(every) >= steps).unwrap_or(smooth.max(1));
        Self { first_step: steps - steps.min(fits(every)), every }
    }

    /// The last one of the clip is among them.
    fn frames(self, clip: &Clip) -> impl Iterator<Item = usize> + Clone {
        let first = self.first_step * clip.recording().layout.frames_per_step;
        let n = clip.n_frames() - first;
        (first + (n - 1) % self.every..clip.n_frames()).step_by(self.every)
    }
}

fn pack(group: &str, label: &str, model: usize, clip: &Clip, most_bytes: usize) -> PackedClip {
    let recording = clip.recording();
    let layout = &recording.layout;
    let n_bodies = layout.bodies.len();
    let selection = Selection::of(clip, most_bytes);
    let Selection { first_step, every } = selection;
    let first_frame = selection.frames(clip).next().unwrap_or_default();
    let before = (first_step * layout.frames_per_step) as f64 * layout.seconds_per_frame;
    let chosen = selection.frames(clip).flat_map(|frame| {
        recording.poses[frame * n_bodies * POSE..][..n_bodies * POSE].chunks_exact(POSE)
    });
    let packing = Packing::covering(chosen.clone());
    let numbers = chosen.flat_map(|pose| packing.pack(pose));
    let first = recording.first_control_step + first_step as u64;
    let last = recording.first_control_step + recording.n_steps as u64;
    PackedClip {
        group: group.into(),
        label: label.into(),
        note: format!("control steps {} to {last}", first + 1),
        model,
        first_control_step: first,
        seconds_per_step: layout.frames_per_step as f64 * layout.seconds_per_frame,
        seconds_per_frame: every as f64 * layout.seconds_per_frame,
        first_frame_s: clip.seconds(first_frame) - before,
        packing,
        poses: STANDARD.encode(numbers.flat_map(i16::to_le_bytes).collect::<Vec<_>>()),
        contacts: STANDARD.encode(&recording.contacts[first_step * n_bodies..]),
        terms: terms(clip, first_step),
    }
}

/// What the strip shows of the reward: all of it, then task and information by themselves, the latter
/// if any is measured, and the penalty if there was any.
fn terms(clip: &Clip, first_step: usize) -> Vec<PackedTerm> {
    let recording = clip.recording();
    let names = &recording.layout.terms;
    let RewardParts { task, information } = clip.reward_parts();
    let label = |it: Quantity| (it.symbol, it.unit);
    let labels =
        [Some(("r", "")), Some(label(task)), information.map(label), Some(("penalty", ""))];
    let column = |(term, label): (&str, Option<(&str, &str)>)| {
        let (name, unit) = label?;
        let place = names.iter().position(|name| name == term)?;
        let values = recording.terms.iter().skip(place).step_by(names.len()).skip(first_step);
        let values: Vec<f32> = values.map(|&value| value as f32).collect();
        let shows = term != "penalty" || values.iter().any(|&value| value != 0.0);
        let bytes: Vec<_> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let [name, unit] = [name, unit].map(str::to_owned);
        shows.then(|| PackedTerm { name, unit, values: STANDARD.encode(bytes) })
    };
    TERMS.into_iter().zip(labels).filter_map(column).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example::clip;

    fn numbers(text: &str) -> Vec<i16> {
        let bytes = STANDARD.decode(text).unwrap();
        bytes.as_chunks().0.iter().map(|&pair| i16::from_le_bytes(pair)).collect()
    }

    #[test]
    fn poses_come_back_within_the_stated_precision() {
        let clip = clip(30);
        let mut packed = Packed::default();
        packed.add("group", "label", &clip, usize::MAX);
        let [position, degrees] = packed.precision();
        // 5.9 m of y and 1 m between ball and rod: a step is 3.45 m/32767, and half of it in each of
        // three axes is the most.
        assert!((position - 0.5 * 3.0_f64.sqrt() * 3.45 / 32767.0).abs() < 1e-9, "{position}");
        let it = &packed.clips[0];
        let numbers = numbers(&it.poses);
        assert_eq!(numbers.len(), 60 * 3 * POSE);
        for (i, (pose, recorded)) in
            numbers.chunks(POSE).zip(clip.recording().poses.chunks(POSE)).enumerate()
        {
            let at = |axis: usize| {
                it.packing.centre_m[axis] + it.packing.step_m[axis] * f64::from(pose[axis])
            };
            let off: f64 = (0..3).map(|axis| (at(axis) - f64::from(recorded[axis])).powi(2)).sum();
            assert!(off.sqrt() <= position, "{i}: {off}");
            let dot: f64 =
                (3..7).map(|j| f64::from(pose[j]) / 32767.0 * f64::from(recorded[j])).sum();
            let length: f64 = (3..7).map(|j| (f64::from(pose[j]) / 32767.0).powi(2)).sum();
            let turn = 2.0 * (dot / length.sqrt()).min(1.0).acos().to_degrees();
            // arccos near 1 loses half of the digits of an f32 recording: 0.03 degrees.
            assert!(turn <= degrees + 0.03, "{i}: {turn}");
        }
        assert_eq!(
            (it.first_frame_s, it.seconds_per_frame, it.seconds_per_step),
            (0.05, 0.05, 0.1)
        );
    }

    #[test]
    fn what_does_not_fit_is_left_out_from_the_beginning() {
        let clip = clip(30);
        // A frame of 3 bodies takes 56 letters, a step's contacts 4; at 20 Hz there's every frame.
        let all = Selection::of(&clip, 30 * 116);
        assert_eq!(all, Selection { first_step: 0, every: 1 });
        assert_eq!(Selection::of(&clip, 12 * 116), Selection { first_step: 18, every: 1 });
        assert_eq!(Selection::of(&clip, 0), Selection { first_step: 29, every: 1 });
        let frames: Vec<_> = Selection { first_step: 27, every: 2 }.frames(&clip).collect();
        assert_eq!(frames, [55, 57, 59]);

        let mut packed = Packed::default();
        packed.add("group", "label", &clip, 12 * 116);
        let it = &packed.clips[0];
        assert_eq!((it.first_control_step, it.note.as_str()), (28, "control steps 29 to 40"));
        assert_eq!(numbers(&it.poses).len(), 24 * 3 * POSE);
        let values = STANDARD.decode(&it.terms[0].values).unwrap();
        // The first term of step 18 is number 18 * 8.
        assert_eq!(values.len(), 12 * 4);
        assert_eq!(values[..4], 144_f32.to_le_bytes());
    }

    #[test]
    fn models_are_packed_once_and_nothing_ends_the_script() {
        let clip = clip(2);
        let mut packed = Packed::default();
        for label in ["</script>", "<!--"] {
            packed.add("group", label, &clip, usize::MAX);
        }
        assert_eq!((packed.models.len(), packed.clips.len()), (1, 2));
        let json = packed.json().unwrap();
        assert!(!json.contains('<'));
        let value: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert_eq!(value["clips"][0]["label"], "</script>");
        assert_eq!(value["models"][0]["rows"][0]["body"], 1);
        assert_eq!(value["models"][0]["bodies"][0]["colour"], "#808080");
        assert!(!packed.markup(false).into_string().contains("</script>"));
    }
}
