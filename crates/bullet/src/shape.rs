//! Collision shapes, in the body's own frame with its centre of mass as origin. Lengths in m,
//! between 1e-6 and 1e6.

use nalgebra::{Isometry3, Point3, Unit, Vector3};
use serde::Serialize;

use crate::{body::to_pose, bridge::ffi, ffi::ShapeId};

/// Which way a capsule or a cylinder lies in its own frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Lengthwise {
    /// The x axis of the shape's own frame.
    X,
    /// The y axis of the shape's own frame.
    Y,
    /// The z axis of the shape's own frame.
    Z,
}

/// A shape to be added with [`World::add_shape`](crate::World::add_shape).
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// All points p with `normal . p <= offset`. For bodies that aren't dynamic. Bullet finds one
    /// contact point with it a step, so what lands flat tips and sinks in first; a large box finds
    /// all corners at once.
    Plane {
        /// Points out of the ground.
        normal: Unit<Vector3<f64>>,
        /// Distance of the surface from the origin along the normal, in m.
        offset: f64,
    },
    /// A box.
    Box {
        /// Half its size along x, y and z.
        half_extents: Vector3<f64>,
    },
    /// A ball.
    Sphere {
        /// In m.
        radius: f64,
    },
    /// A ball that is stretched along its axes.
    Ellipsoid {
        /// Half its size along x, y and z.
        radii: Vector3<f64>,
    },
    /// A cylinder with half balls at its ends. Its inertia, if not given, is that of its bounding
    /// box: about its length that's a third too much, or more.
    Capsule {
        /// In m.
        radius: f64,
        /// Of the cylinder, without the half balls.
        length: f64,
        /// Which way it lies.
        along: Lengthwise,
    },
    /// A cylinder.
    Cylinder {
        /// In m.
        radius: f64,
        /// From end to end.
        length: f64,
        /// Which way it lies.
        along: Lengthwise,
    },
    /// The convex hull of 4 to 1024 points that span a volume. Its inertia, if not given, is that
    /// of its bounding box, to which Bullet adds three margins on every side.
    Hull {
        /// Points inside are allowed and cost time.
        points: Vec<Point3<f64>>,
        /// Bullet rounds a hull by this radius, outside of it; its own default is 0.04 m.
        margin: f64,
    },
    /// Up to 256 boxes, spheres, capsules, cylinders, ellipsoids or hulls that move as one. Its inertia, if
    /// not given, is that of its bounding box.
    Compound {
        /// Each shape with its pose in the compound's frame.
        children: Vec<(ShapeId, Isometry3<f64>)>,
    },
    /// Triangles, for ground that isn't flat. For bodies that aren't dynamic.
    Mesh {
        /// Corners.
        vertices: Vec<Point3<f64>>,
        /// Three indices into `vertices` each; no triangle without an area.
        triangles: Vec<[u32; 3]>,
    },
}

impl Shape {
    /// The half space below z = 0.
    pub fn ground() -> Self {
        Self::Plane { normal: Vector3::z_axis(), offset: 0.0 }
    }

    pub(crate) fn to_spec(&self) -> ShapeSpec {
        use ffi::Primitive;
        let primitive =
            |kind, size, axis| ShapeSpec::Primitive(ffi::PrimitiveSpec { kind, size, axis });
        match self {
            Self::Plane { normal, offset } => {
                primitive(Primitive::Plane, [normal.x, normal.y, normal.z, *offset], 0)
            }
            Self::Box { half_extents: h } => primitive(Primitive::Box, [h.x, h.y, h.z, 0.0], 0),
            Self::Sphere { radius } => primitive(Primitive::Sphere, [*radius, 0.0, 0.0, 0.0], 0),
            Self::Ellipsoid { radii: r } => {
                primitive(Primitive::Ellipsoid, [r.x, r.y, r.z, 0.0], 0)
            }
            Self::Capsule { radius, length, along } => {
                primitive(Primitive::Capsule, [*radius, *length, 0.0, 0.0], *along as u8)
            }
            Self::Cylinder { radius, length, along } => {
                primitive(Primitive::Cylinder, [*radius, *length, 0.0, 0.0], *along as u8)
            }
            Self::Hull { points, margin } => {
                ShapeSpec::Hull { points: flatten(points), margin: *margin }
            }
            Self::Compound { children } => ShapeSpec::Compound(
                children
                    .iter()
                    .map(|(shape, pose)| ffi::CompoundChild { shape: *shape, pose: to_pose(pose) })
                    .collect(),
            ),
            Self::Mesh { vertices, triangles } => ShapeSpec::Mesh {
                vertices: flatten(vertices),
                triangles: triangles.as_flattened().to_vec(),
            },
        }
    }
}

/// A shape as the shim wants it.
#[derive(Serialize)]
pub(crate) enum ShapeSpec {
    Primitive(ffi::PrimitiveSpec),
    /// x, y, z of each point
    Hull {
        points: Vec<f64>,
        margin: f64,
    },
    Compound(Vec<ffi::CompoundChild>),
    /// x, y, z of each vertex; three indices of each triangle
    Mesh {
        vertices: Vec<f64>,
        triangles: Vec<u32>,
    },
}

fn flatten(points: &[Point3<f64>]) -> Vec<f64> {
    points.iter().flat_map(|point| point.coords.iter().copied()).collect()
}
