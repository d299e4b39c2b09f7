//! Svenja, in RoSiML as her authors have her, gives the joints of `models/svenja.toml`: anchors relative
//! to the source along the world's axes, and angles of generic joints that count left-handed.
#![allow(clippy::unwrap_used, missing_docs)]

use std::{collections::BTreeMap, fs, path::Path};

use formats::{Axis, Options};
use nalgebra::{Point3, Rotation3, Vector3};
use toml::{Table, Value};

fn vector(value: &Value) -> Vector3<f64> {
    let numbers: Vec<f64> = value.as_array().unwrap().iter().map(number).collect();
    Vector3::new(numbers[0], numbers[1], numbers[2])
}

fn number(value: &Value) -> f64 {
    value.as_float().unwrap()
}

fn tables<'a>(table: &'a Table, key: &str) -> Vec<&'a Table> {
    let list = table.get(key).and_then(Value::as_array).into_iter().flatten();
    list.map(|it| it.as_table().unwrap()).collect()
}

#[test]
fn svenja_has_the_joints_of_her_model_file() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let imported =
        formats::import(&root.join("tests/robots/svenja.rosiml"), &Options::default()).unwrap();
    let robot = &imported.robot;
    let model: Table =
        fs::read_to_string(root.join("models/svenja.toml")).unwrap().parse().unwrap();
    let bodies: BTreeMap<&str, &Table> =
        tables(&model, "body").into_iter().map(|it| (it["name"].as_str().unwrap(), it)).collect();
    for (name, body) in &bodies {
        let link = robot.links.iter().find(|link| link.name == *name).unwrap();
        assert_eq!(link.inertial.unwrap().mass_kg, number(&body["mass_kg"]), "{name}");
        assert_eq!(link.friction, body.get("friction").map(number), "{name}");
        assert_eq!(link.pose.translation.vector, vector(&body["position_m"]), "{name}");
    }
    let joints = tables(&model, "joint");
    // One half and what is in the middle: the model's other half is its mirror image.
    assert_eq!((joints.len(), robot.joints.len()), (11, 20));
    for joint in joints {
        let name = joint["name"].as_str().unwrap();
        let own = robot.joints.iter().find(|it| it.name == name).unwrap();
        let parent = joint["parent"].as_str().unwrap();
        assert_eq!(robot.links[own.parent.unwrap()].name, parent);
        assert_eq!(robot.links[own.child].name, joint["child"].as_str().unwrap());
        let axes = tables(joint, "axes");
        assert_eq!(axes.len(), own.axes.len(), "{name}");
        let anchor =
            Point3::from(vector(&bodies[parent]["position_m"]) + vector(&joint["anchor_m"]));
        let angles = joint.get("frame_deg").map(vector).unwrap_or_default().map(f64::to_radians);
        let frame = Rotation3::from_euler_angles(angles.x, angles.y, angles.z);
        for axis in axes {
            let letter = "xyz".find(axis["about"].as_str().unwrap()).unwrap();
            let direction = frame * Vector3::ith(letter, 1.0);
            let along = |it: &&Axis| it.direction.dot(&direction).abs() > 1.0 - 1e-12;
            let found = own.axes.iter().find(along).unwrap();
            assert!((found.anchor_m - anchor).norm() < 1e-12, "{name}");
            // The same motion, counted the same way.
            let flipped = found.direction.dot(&direction) < 0.0;
            let [lower, upper] = found.range.unwrap();
            let (range, reversed) = match flipped {
                true => ([-upper, -lower], !found.reversed),
                false => ([lower, upper], found.reversed),
            };
            let expected: Vec<f64> =
                axis["range_deg"].as_array().unwrap().iter().map(number).collect();
            assert!((range[0].to_degrees() - expected[0]).abs() < 1e-12, "{name} {range:?}");
            assert!((range[1].to_degrees() - expected[1]).abs() < 1e-12, "{name} {range:?}");
            let is_reversed = axis.get("reversed").is_some_and(|it| it.as_bool().unwrap());
            assert_eq!(reversed, is_reversed, "{name}");
            if axis.contains_key("spring") {
                assert_eq!((found.spring.unwrap().stiffness, found.damping), (0.1, 1.0), "{name}");
            }
        }
    }
    assert_eq!(robot.touch.len(), 9);
    assert!(imported.text.contains("feet = [\"tarsus front right\", "), "{}", imported.text);
}
