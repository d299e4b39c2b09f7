//! Collision shapes, in the body's own frame with its centre of mass as origin. Lengths in m,
//! between 1e-6 and 1e6.

use nalgebra::{Isometry3, Point3, Unit, Vector3};

use crate::{bridge::ffi, ffi::ShapeId};

/// Which way a capsule or a cylinder lies in its own frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Lengthwise {
    /// Along x.
    X,
    /// Along y.
    Y,
    /// Along z.
    Z,
}

/// A shape to be added with [`World::add_shape`](crate::World::add_shape).
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// All points p with `normal . p <= offset`. For bodies that aren't dynamic.
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
    /// A cylinder with half balls at its ends.
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
    /// The convex hull of 4 to 1024 points that span a volume.
    Hull {
        /// Points inside are allowed and cost time.
        points: Vec<Point3<f64>>,
        /// Bullet rounds a hull by this radius, outside of it; its own default is 0.04 m.
        margin: f64,
    },
    /// Up to 256 boxes, spheres, capsules, cylinders or hulls that move as one. Its inertia, if
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

    /// The primitive shapes as the shim wants them; None for those made of several parts.
    pub(crate) fn to_primitive(&self) -> Option<ffi::PrimitiveSpec> {
        use ffi::Primitive;
        let spec = |kind, size, axis| Some(ffi::PrimitiveSpec { kind, size, axis });
        match *self {
            Self::Plane { normal, offset } => {
                spec(Primitive::Plane, [normal.x, normal.y, normal.z, offset], 0)
            }
            Self::Box { half_extents: h } => spec(Primitive::Box, [h.x, h.y, h.z, 0.0], 0),
            Self::Sphere { radius } => spec(Primitive::Sphere, [radius, 0.0, 0.0, 0.0], 0),
            Self::Capsule { radius, length, along } => {
                spec(Primitive::Capsule, [radius, length, 0.0, 0.0], along as u8)
            }
            Self::Cylinder { radius, length, along } => {
                spec(Primitive::Cylinder, [radius, length, 0.0, 0.0], along as u8)
            }
            Self::Hull { .. } | Self::Compound { .. } | Self::Mesh { .. } => None,
        }
    }
}
