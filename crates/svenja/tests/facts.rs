//! Every row of the published model, table by table.
//!
//! Source: the RoSiML file `svenja.xml` of the NMODE repository, which the paper's authors published.
//! It counts the angles of `generic` joints (hips) left-handed, those of `hinge` joints (knees)
//! right-handed; `gamma` turns the joint's frame about z.

#![allow(clippy::unwrap_used, missing_docs)]

use std::path::Path;

use nalgebra::Vector3;
use svenja::{JointKind, Morphology};

/// Roundings of the published figures, which have six decimals, and of ours.
const EPSILON: f64 = 1e-9;

/// name, mass in kg, friction, position in m
type BodyRow = (&'static str, f64, f64, [f64; 3]);

#[rustfmt::skip]
const BODIES: [BodyRow; 21] = [
    ("main", 10.0, 1.0, [0.0, 0.0, 0.5]),
    ("head", 10.0, 1.0, [0.0, 0.825276, 0.553054]),
    ("rear", 20.0, 1.0, [0.0, -1.389205, 0.618514]),
    ("femur front right", 2.0, 0.0, [0.583046, 0.767045, 0.847976]),
    ("tibia front right", 1.5, 1.0, [0.917606, 1.346437, 0.913042]),
    ("tarsus front right", 1.0, 1.0, [1.30757, 2.021959, 0.254967]),
    ("femur front left", 2.0, 0.0, [-0.583046, 0.767045, 0.847976]),
    ("tibia front left", 1.5, 1.0, [-0.917606, 1.346437, 0.913042]),
    ("tarsus front left", 1.0, 1.0, [-1.30757, 2.021959, 0.254967]),
    ("femur centre right", 2.0, 0.0, [0.700179, 0.0, 0.859246]),
    ("tibia centre right", 1.5, 1.0, [1.080656, 0.0, 0.903537]),
    ("tarsus centre right", 1.0, 1.0, [1.613117, 0.0, 0.261126]),
    ("femur centre left", 2.0, 0.0, [-0.700179, 0.0, 0.859246]),
    ("tibia centre left", 1.5, 1.0, [-1.080656, 0.0, 0.903537]),
    ("tarsus centre left", 1.0, 1.0, [-1.613117, 0.0, 0.261126]),
    ("femur rear right", 4.0, 0.0, [0.690446, -0.953069, 0.892816]),
    ("tibia rear right", 3.0, 1.0, [1.129061, -1.712857, 0.911182]),
    ("tarsus rear right", 2.4, 1.0, [1.645274, -2.606881, 0.250164]),
    ("femur rear left", 4.0, 0.0, [-0.690446, -0.953069, 0.892816]),
    ("tibia rear left", 3.0, 1.0, [-1.129061, -1.712857, 0.911182]),
    ("tarsus rear left", 2.4, 1.0, [-1.645274, -2.606881, 0.250164]),
];

/// name, kind, source, destination, anchor in m from the source, gamma in degrees, axis, range in
/// degrees, and which ends of it -1 and 1 are (1 for max)
type JointRow = (
    &'static str,
    &'static str,
    &'static str,
    &'static str,
    [f64; 3],
    f64,
    char,
    [f64; 2],
    [u8; 2],
);

#[rustfmt::skip]
const JOINTS: [JointRow; 26] = [
    ("main - head", "fixed", "main", "head", [0.0, 0.0, 0.0], 0.0, '-', [0.0, 0.0], [0, 1]),
    ("main - rear", "fixed", "main", "rear", [0.0, 0.0, 0.0], 0.0, '-', [0.0, 0.0], [0, 1]),
    ("front left Fe-Ma", "generic", "main", "femur front left", [-0.345967, 0.356388, -0.094383], 30.0, 'x', [-5.0, 20.0], [0, 1]),
    ("front left Fe-Ma", "generic", "main", "femur front left", [-0.345967, 0.356388, -0.094383], 30.0, 'z', [-25.0, 35.0], [0, 1]),
    ("front left Fe-Ti", "hinge", "femur front left", "tibia front left", [-0.285346, 0.494232, 0.468772], 30.0, 'x', [-15.0, 10.0], [0, 1]),
    ("front left Ti-Ta", "hinge", "tibia front left", "tarsus front left", [-0.069505, 0.120302, -0.476651], 30.0, 'x', [-30.0, 5.0], [1, 0]),
    ("front right Fe-Ma", "generic", "main", "femur front right", [0.345967, 0.356388, -0.094383], -30.0, 'x', [-5.0, 20.0], [0, 1]),
    ("front right Fe-Ma", "generic", "main", "femur front right", [0.345967, 0.356388, -0.094383], -30.0, 'z', [-35.0, 25.0], [1, 0]),
    ("front right Fe-Ti", "hinge", "femur front right", "tibia front right", [0.285346, 0.494232, 0.468772], -30.0, 'x', [-15.0, 10.0], [0, 1]),
    ("front right Ti-Ta", "hinge", "tibia front right", "tarsus front right", [0.069505, 0.120302, -0.476651], -30.0, 'x', [-30.0, 5.0], [1, 0]),
    ("centre left Fe-Ma", "generic", "main", "femur centre left", [-0.373759, 0.0, -0.15891], 0.0, 'y', [-0.5, 45.0], [0, 1]),
    ("centre left Fe-Ma", "generic", "main", "femur centre left", [-0.373759, 0.0, -0.15891], 0.0, 'z', [-45.0, 45.0], [0, 1]),
    ("centre left Ti-Ta", "hinge", "tibia centre left", "tarsus centre left", [-0.008504, 0.0, -0.471905], 90.0, 'x', [-30.0, 5.0], [1, 0]),
    ("centre left Fe-Ti", "hinge", "femur centre left", "tibia centre left", [-0.385284, 0.0, 0.464624], 90.0, 'x', [-2.5, 45.0], [0, 1]),
    ("centre right Fe-Ma", "generic", "main", "femur centre right", [0.373759, 0.0, -0.15891], 0.0, 'y', [-45.0, 0.5], [1, 0]),
    ("centre right Fe-Ma", "generic", "main", "femur centre right", [0.373759, 0.0, -0.15891], 0.0, 'z', [-45.0, 45.0], [1, 0]),
    ("centre right Ti-Ta", "hinge", "tibia centre right", "tarsus centre right", [0.008504, 0.0, -0.471905], 90.0, 'x', [-5.0, 30.0], [0, 1]),
    ("centre right Fe-Ti", "hinge", "femur centre right", "tibia centre right", [0.385284, 0.0, 0.464624], -90.0, 'x', [-2.5, 45.0], [0, 1]),
    ("rear left Fe-Ma", "generic", "main", "femur rear left", [-0.350748, -0.364688, -0.163432], -120.0, 'y', [-20.0, 5.0], [1, 0]),
    ("rear left Fe-Ma", "generic", "main", "femur rear left", [-0.350748, -0.364688, -0.163432], -120.0, 'z', [-20.0, 30.0], [0, 1]),
    ("rear left Fe-Ti", "hinge", "femur rear left", "tibia rear left", [-0.354114, -0.613342, 0.42241], -30.0, 'x', [-5.0, 27.5], [1, 0]),
    ("rear left Ti-Ta", "hinge", "tibia rear left", "tarsus rear left", [-0.10703, -0.185465, -0.465533], -30.0, 'x', [-25.0, 20.0], [0, 1]),
    ("rear right Fe-Ma", "generic", "main", "femur rear right", [0.350748, -0.364688, -0.163432], 120.0, 'y', [-5.0, 20.0], [0, 1]),
    ("rear right Fe-Ma", "generic", "main", "femur rear right", [0.350748, -0.364688, -0.163432], 120.0, 'z', [-30.0, 20.0], [1, 0]),
    ("rear right Fe-Ti", "hinge", "femur rear right", "tibia rear right", [0.354114, -0.613342, 0.42241], 30.0, 'x', [-5.0, 27.5], [1, 0]),
    ("rear right Ti-Ta", "hinge", "tibia rear right", "tarsus rear right", [0.10703, -0.185465, -0.465533], 30.0, 'x', [-25.0, 20.0], [0, 1]),
];

fn svenja() -> Morphology {
    Morphology::open(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models/svenja.toml"))
        .unwrap()
}

/// The frame's axis in space.
fn unit(gamma_deg: f64, axis: char) -> Vector3<f64> {
    let (sin, cos) = gamma_deg.to_radians().sin_cos();
    match axis {
        'x' => Vector3::new(cos, sin, 0.0),
        'y' => Vector3::new(-sin, cos, 0.0),
        _ => Vector3::z(),
    }
}

#[test]
fn bodies_are_those_of_the_table() {
    let svenja = svenja();
    assert_eq!(svenja.bodies().len(), BODIES.len());
    for (name, mass, friction, position) in BODIES {
        let body = svenja.bodies().iter().find(|body| body.name == name).unwrap();
        assert_eq!(body.mass_kg, mass, "{name}");
        assert_eq!(body.friction, friction, "{name}");
        assert_eq!(body.pose.translation.vector, Vector3::from(position), "{name}");
        assert_eq!(body.pose.rotation.angle(), 0.0, "{name}");
    }
    assert_eq!(svenja.start().translation.vector, Vector3::new(0.0, 0.0, 0.7));
}

#[test]
fn joints_are_those_of_the_table() {
    let svenja = svenja();
    let mut n_axes = 0;
    for (name, kind, source, destination, anchor, gamma, axis, range, ends) in JOINTS {
        let joint = svenja.joints().iter().find(|joint| joint.name == name).unwrap();
        let (expected, hip) = match kind {
            "fixed" => (JointKind::Fixed, false),
            "generic" => (JointKind::Spherical, true),
            _ => (JointKind::SliderHinge, false),
        };
        assert_eq!(joint.kind, expected, "{name}");
        assert_eq!(svenja.bodies()[joint.parent.unwrap()].name, source, "{name}");
        assert_eq!(svenja.bodies()[joint.child].name, destination, "{name}");
        let from_source = joint.frame.translation.vector
            - svenja.bodies()[joint.parent.unwrap()].pose.translation.vector;
        assert!((from_source - Vector3::from(anchor)).norm() < EPSILON, "{name}");
        if kind == "fixed" {
            assert!(joint.axes.is_empty());
            continue;
        }

        // As turns in space, which don't depend on the frame that a model file chooses.
        let turn = unit(gamma, axis);
        let ours = joint
            .axes
            .iter()
            .find(|ours| {
                ((joint.frame.rotation * ours.freedom.direction().unit()).dot(&turn)).abs() > 0.99
            })
            .unwrap();
        let in_space = joint.frame.rotation * ours.freedom.direction().unit();
        let sign = if hip { -1.0 } else { 1.0 };
        for (command, end) in [-1.0, 1.0].into_iter().zip(ends) {
            let published = turn * (sign * range[usize::from(end)].to_radians());
            let error = (in_space * ours.position_of(command) - published).norm();
            assert!(error < EPSILON, "{name} {axis}, command {command}: {error}");
        }
        let margin = if hip { 0.1 } else { 0.0 };
        assert!((ours.stop_margin - margin).abs() < EPSILON, "{name}");
        let servo = ours.servo.unwrap();
        assert_eq!((servo.speed_limit, servo.force_limit), (0.5, 750.0), "{name}");
        let spring = ours.spring.map(|s| (s.stiffness, s.damping, s.equilibrium));
        assert_eq!(spring, hip.then_some((0.1, 1.0, 0.0)), "{name}");
        assert_eq!((joint.stop.erp, joint.stop.cfm), (1.0, 0.0), "{name}");
        n_axes += 1;
    }
    assert_eq!(n_axes, 24);
    assert_eq!(svenja.joints().len(), 20);
    assert_eq!(svenja.degrees_of_freedom(), 30);
}

#[test]
fn sensors_and_actuators_are_in_the_published_order() {
    let svenja = svenja();
    let mut names = Vec::new();
    for place in ["front", "centre", "rear"] {
        for side in ["left", "right"] {
            for axis in ["Fe-Ma/lift", "Fe-Ma/swing", "Fe-Ti", "Ti-Ta"] {
                names.push(format!("{place} {side} {axis}"));
            }
        }
    }
    let of = |ids: &[svenja::AxisId]| -> Vec<String> {
        ids.iter().map(|&id| svenja.axis_name(id)).collect()
    };
    assert_eq!(of(svenja.sensors()), names);
    assert_eq!(of(svenja.actuators()), names);
    let bodies = |indices: &[usize]| -> Vec<&str> {
        indices.iter().map(|&i| svenja.bodies()[i].name.as_str()).collect()
    };
    let feet = [
        "tarsus front left",
        "tarsus front right",
        "tarsus centre left",
        "tarsus centre right",
        "tarsus rear left",
        "tarsus rear right",
    ];
    assert_eq!(bodies(svenja.feet()), feet);
    assert_eq!(bodies(svenja.contacts()), feet);
    assert_eq!(bodies(svenja.penalised()), ["head", "rear"]);
    assert_eq!(svenja.groups().len(), 6);
    assert_eq!(*svenja.heading().axis, Vector3::y());
    assert!(!svenja.self_collision());
}

/// "Capsules: femur from hip anchor to knee anchor, tibia from knee to ankle, tarsus to its tip."
#[test]
fn legs_reach_from_anchor_to_anchor() {
    let svenja = svenja();
    for joint in svenja.joints().iter().filter(|joint| joint.kind != JointKind::Fixed) {
        let ends = |body: usize| {
            let body = &svenja.bodies()[body];
            let (svenja::Shape::Capsule(rod), pose) = (&body.colliders[0].shape, &body.pose) else {
                return None;
            };
            Some([pose * rod.from_m, pose * rod.to_m])
        };
        let anchor = nalgebra::Point3::from(joint.frame.translation.vector);
        let child = ends(joint.child).unwrap();
        // Six decimals in the file.
        assert!((child[0] - anchor).norm() < 2e-6, "{}", joint.name);
        if let Some(parent) = ends(joint.parent.unwrap()) {
            assert!((parent[1] - anchor).norm() < 2e-6, "{}", joint.name);
        }
    }
}
