//! An animated scene for Blender and others: glTF 2.0 (ISO/IEC 12113) in its binary form.
//!
//! One node a body, with its shape as a mesh around its centre of mass; one animation with a
//! translation and a rotation of each at every recorded frame. All are children of one node that
//! turns z up into glTF's y up, so positions in the file are those of the recording, in m.

use serde_json::{Value, json};
use svenja::Body;

use super::{
    Clip, Error,
    mesh::{Corner, Mesh},
};

const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// The bytes of a GLB file.
///
/// # Errors
/// [`Error::TooLarge`]: more than 4 GiB, which the format can't hold.
pub fn encode(clip: &Clip) -> Result<Vec<u8>, Error> {
    let mut file = Builder::default();
    let bodies = clip.morphology().bodies();
    // A body without a shape has no mesh: that's an error in glTF, unlike a node without one.
    let seen = bodies.iter().enumerate().filter(|(_, body)| !body.colliders.is_empty());
    let meshes: Vec<Value> = seen.clone().map(|(i, body)| file.mesh(body, i)).collect();
    let seen: Vec<usize> = seen.map(|(i, _)| i).collect();
    let materials: Vec<Value> = bodies.iter().map(material).collect();
    let animation = file.animation(clip);
    let nodes = bodies.iter().enumerate().map(|(i, body)| {
        let pose = clip.pose(0, i);
        let (position, rotation) = (pose.translation.vector, pose.rotation.coords);
        let mut node = json!({
            "name": body.name,
            "translation": single(position.as_slice()),
            "rotation": single(rotation.as_slice()),
        });
        if let Ok(mesh) = seen.binary_search(&i) {
            node["mesh"] = json!(mesh);
        }
        node
    });
    // A quarter turn about -x: z goes to y.
    let half = 0.5_f64.sqrt();
    let root = json!({
        "name": clip.title(),
        "rotation": [-half, 0.0, 0.0, half],
        "children": (0..bodies.len()).collect::<Vec<_>>(),
    });
    let document = json!({
        "asset": { "version": "2.0", "generator": concat!("itarl ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "name": clip.morphology().name(), "nodes": [bodies.len()] }],
        "nodes": nodes.chain([root]).collect::<Vec<_>>(),
        "meshes": meshes,
        "materials": materials,
        "animations": [animation],
        "accessors": file.accessors,
        "bufferViews": file.views,
        "buffers": [{ "byteLength": file.bytes.len() }],
    });
    container(serde_json::to_vec(&document)?, file.bytes)
}

fn material(body: &Body) -> Value {
    let [red, green, blue] = body.colour.map(linear);
    json!({
        "name": body.name,
        "pbrMetallicRoughness": {
            "baseColorFactor": [red, green, blue, 1.0],
            "metallicFactor": 0.0,
            "roughnessFactor": 0.6,
        },
    })
}

/// Header, then the chunks `JSON` and `BIN`, each a multiple of 4 bytes.
fn container(mut json: Vec<u8>, mut binary: Vec<u8>) -> Result<Vec<u8>, Error> {
    json.resize(json.len().next_multiple_of(4), b' ');
    binary.resize(binary.len().next_multiple_of(4), 0);
    let too_large = |_| Error::TooLarge("a GLB file can't have more than 4 GiB");
    let u32_of = |n: usize| u32::try_from(n).map_err(too_large);
    let total = u32_of(12 + 8 + json.len() + 8 + binary.len())?;
    let mut bytes = Vec::with_capacity(total as usize);
    bytes.extend_from_slice(b"glTF");
    for number in [2, total, u32_of(json.len())?] {
        bytes.extend(number.to_le_bytes());
    }
    bytes.extend_from_slice(b"JSON");
    bytes.append(&mut json);
    bytes.extend(u32_of(binary.len())?.to_le_bytes());
    bytes.extend_from_slice(b"BIN\0");
    bytes.append(&mut binary);
    Ok(bytes)
}

/// As the file's numbers are, for the same ones in the nodes and in the animation.
fn single(values: &[f64]) -> Vec<f32> {
    values.iter().map(|&value| value as f32).collect()
}

/// A channel of a colour as light: the sRGB curve backwards.
fn linear(byte: u8) -> f64 {
    let value = f64::from(byte) / 255.0;
    if value <= 0.040_45 { value / 12.92 } else { libm::pow((value + 0.055) / 1.055, 2.4) }
}

/// The binary part, and what describes it.
#[derive(Default)]
struct Builder {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Builder {
    /// `values` in rows of `width`; with the least and the largest of each column where they are
    /// asked for.
    fn floats(&mut self, values: &[f32], width: usize, target: Option<u32>, bounds: bool) -> usize {
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][width - 1];
        let bytes: Vec<_> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let mut accessor = json!({
            "bufferView": self.view(&bytes, target),
            "componentType": FLOAT,
            "count": values.len() / width,
            "type": kind,
        });
        if bounds {
            let column = |i: usize| values.iter().skip(i).step_by(width).copied();
            let least: Vec<_> =
                (0..width).map(|i| column(i).fold(f32::INFINITY, f32::min)).collect();
            let most: Vec<_> =
                (0..width).map(|i| column(i).fold(f32::NEG_INFINITY, f32::max)).collect();
            accessor["min"] = json!(least);
            accessor["max"] = json!(most);
        }
        self.accessor(accessor)
    }

    fn accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut view =
            json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.bytes.extend_from_slice(bytes);
        self.views.push(view);
        self.views.len() - 1
    }

    /// One of as many parts as the body has shapes.
    fn mesh(&mut self, body: &Body, material: usize) -> Value {
        let parts = body.colliders.iter().map(|it| self.part(&Mesh::of(it), material));
        json!({ "name": body.name, "primitives": parts.collect::<Vec<_>>() })
    }

    fn part(&mut self, mesh: &Mesh, material: usize) -> Value {
        let corners =
            |of: fn(&Corner) -> [f32; 3]| mesh.corners.iter().flat_map(of).collect::<Vec<_>>();
        let positions = self.floats(&corners(|it| it.position), 3, Some(ARRAY_BUFFER), true);
        let normals = self.floats(&corners(|it| it.normal), 3, Some(ARRAY_BUFFER), false);
        let bytes: Vec<_> = mesh.triangles.iter().flat_map(|corner| corner.to_le_bytes()).collect();
        let view = self.view(&bytes, Some(ELEMENT_ARRAY_BUFFER));
        let triangles = self.accessor(json!({
            "bufferView": view,
            "componentType": UNSIGNED_SHORT,
            "count": mesh.triangles.len(),
            "type": "SCALAR",
        }));
        json!({
            "attributes": { "POSITION": positions, "NORMAL": normals },
            "indices": triangles,
            "material": material,
        })
    }

    fn animation(&mut self, clip: &Clip) -> Value {
        let frames = 0..clip.n_frames();
        // From 0, where players begin.
        let seconds = |frame: usize| (clip.seconds(frame) - clip.seconds(0)) as f32;
        let times: Vec<_> = frames.clone().map(seconds).collect();
        let times = self.floats(&times, 1, None, true);
        let (mut channels, mut samplers) = (Vec::new(), Vec::new());
        for body in 0..clip.morphology().bodies().len() {
            let pose = |frame: usize| clip.pose(frame, body);
            let position = |frame| single(pose(frame).translation.vector.as_slice());
            let rotation = |frame| single(pose(frame).rotation.coords.as_slice());
            let positions: Vec<_> = frames.clone().flat_map(position).collect();
            let rotations: Vec<_> = frames.clone().flat_map(rotation).collect();
            for (path, values, width) in [("translation", positions, 3), ("rotation", rotations, 4)]
            {
                let output = self.floats(&values, width, None, false);
                channels.push(json!({
                    "sampler": samplers.len(),
                    "target": { "node": body, "path": path },
                }));
                samplers
                    .push(json!({ "input": times, "output": output, "interpolation": "LINEAR" }));
            }
        }
        json!({ "name": clip.title(), "channels": channels, "samplers": samplers })
    }
}

#[cfg(test)]
mod tests {
    use gltf::animation::util::ReadOutputs;
    use nalgebra::{Quaternion, UnitQuaternion, Vector3};

    use super::*;
    use crate::example::{self, clip};

    /// The document is checked as it's read; the binary chunk is the one buffer.
    fn read(clip: &Clip) -> (gltf::Document, Vec<u8>) {
        let bytes = encode(clip).unwrap();
        let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(&bytes).unwrap();
        (document, blob.unwrap())
    }

    #[test]
    fn the_animation_is_the_recording() {
        let clip = clip(3);
        let (document, blob) = read(&clip);
        let animation = document.animations().next().unwrap();
        assert_eq!(animation.channels().count(), 6);
        for channel in animation.channels() {
            let reader = channel.reader(|_| Some(&blob));
            let times: Vec<_> = reader.read_inputs().unwrap().collect();
            assert_eq!(times.len(), 6);
            assert_eq!(times[0], 0.0);
            assert!((times[5] - 0.25).abs() < 1e-6);
            let body = channel.target().node().index();
            match reader.read_outputs().unwrap() {
                ReadOutputs::Translations(positions) => {
                    let positions: Vec<_> = positions.collect();
                    assert_eq!(positions.len(), 6);
                    for (frame, position) in positions.iter().enumerate() {
                        let recorded = &clip.recording().poses[(3 * frame + body) * 7..][..3];
                        assert_eq!(position, recorded);
                    }
                }
                ReadOutputs::Rotations(rotations) => {
                    for (frame, q) in rotations.into_f32().enumerate() {
                        let recorded = clip.pose(frame, body).rotation;
                        let q = Quaternion::new(q[3], q[0], q[1], q[2]).cast::<f64>();
                        assert!((q.coords - recorded.coords).norm() < 1e-6);
                    }
                }
                _ => panic!("neither a translation nor a rotation"),
            }
        }
    }

    /// z is up in the recording and y in the file: the root turns (x, y, z) to (x, z, -y).
    #[test]
    fn nodes_are_bodies_in_their_first_pose() {
        let clip = clip(2);
        let (document, _) = read(&clip);
        let root = document.scenes().next().unwrap().nodes().next().unwrap();
        let (_, turn, _) = root.transform().decomposed();
        let turn =
            UnitQuaternion::from_quaternion(Quaternion::new(turn[3], turn[0], turn[1], turn[2]));
        let up = turn * Vector3::new(1.0_f32, 2.0, 3.0);
        assert!((up - Vector3::new(1.0, 3.0, -2.0)).norm() < 1e-5, "{up}");
        let names: Vec<_> = root.children().map(|node| node.name().unwrap().to_owned()).collect();
        assert_eq!(names, ["block", "ball", "rod"]);
        for (body, node) in root.children().enumerate() {
            let (position, rotation, _) = node.transform().decomposed();
            let recorded = &clip.recording().poses[body * 7..][..7];
            assert_eq!([&position[..], &rotation[..]].concat(), recorded);
        }
        // "#808080" is 0.2159 of the light: any table of sRGB.
        let colour = document.materials().next().unwrap().pbr_metallic_roughness();
        assert!((colour.base_color_factor()[0] - 0.2159).abs() < 1e-4);
    }

    #[test]
    fn a_body_may_have_no_shape_and_several() {
        let several = r#"shapes = [{ kind = "sphere", radius_m = 0.1 },
            { kind = "ellipsoid", radii_m = [0.1, 0.2, 0.3], position_m = [0.0, 0.0, 1.0] }]"#;
        let rod = r#"shape = { kind = "capsule", radius_m = 0.05, from_m = [-0.2, 0.0, 0.0], to_m = [0.2, 0.0, 0.0] }"#;
        let ball = r#"shape = { kind = "sphere", radius_m = 0.1 }"#;
        let model = example::MODEL.replace(ball, "inertia_kg_m2 = [1, 1, 1]").replace(rod, several);
        let model = svenja::Morphology::parse("m.toml", &model).unwrap();
        let clip = Clip::new(String::new(), example::PARTS, model, example::recording(2)).unwrap();
        let (document, _) = read(&clip);
        let root = document.scenes().next().unwrap().nodes().next().unwrap();
        let parts: Vec<_> =
            root.children().map(|it| it.mesh().map(|mesh| mesh.primitives().count())).collect();
        assert_eq!(parts, [Some(1), None, Some(2)]);
        let box_of = |i: usize| {
            let mesh = document.meshes().nth(1).unwrap();
            mesh.primitives().nth(i).unwrap().bounding_box()
        };
        assert!((box_of(0).max[2] - 0.1).abs() < 1e-6, "{:?}", box_of(0));
        assert!((box_of(1).max[2] - 1.3).abs() < 1e-6, "{:?}", box_of(1));
    }

    #[test]
    fn the_container_is_as_long_as_it_says() {
        let bytes = encode(&clip(1)).unwrap();
        let number = |at: usize| u32::from_le_bytes(*bytes[at..].first_chunk().unwrap()) as usize;
        assert_eq!((&bytes[..4], number(4), number(8)), (&b"glTF"[..], 2, bytes.len()));
        let json = number(12);
        assert_eq!((&bytes[16..20], json % 4), (&b"JSON"[..], 0));
        assert_eq!(&bytes[20 + json + 4..][..4], b"BIN\0");
        assert_eq!(20 + json + 8 + number(20 + json), bytes.len());
    }
}
