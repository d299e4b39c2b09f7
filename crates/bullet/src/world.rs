//! The world: everything goes through here.

use std::pin::Pin;

use cxx::UniquePtr;
use nalgebra::{Isometry3, Point3, Vector3};
use serde::Serialize;
use xxhash_rust::xxh3::Xxh3;

use crate::{
    Body, BodyId, BodyState, Contact, Error, Joint, JointId, JointState, MotorCommand, MotorState,
    Push, Shape, ShapeId, WorldSettings, body::to_pose, bridge::ffi, shape::ShapeSpec, snapshot,
};

/// A simulated world: shapes, bodies, joints, and what they do.
///
/// The same calls in the same order give the same bits, whatever other worlds or threads do.
/// A world can be moved to another thread; it can't be used from two at once.
///
/// Calls never panic and never end the process: what Bullet couldn't use is an [`Error`], and the
/// world is then as before.
pub struct World {
    inner: UniquePtr<ffi::World>,
    /// Of all calls that built the world.
    build: Xxh3,
    /// What [`World::set_motors`] hands over, kept so that it allocates once.
    commands: Vec<ffi::MotorCommand>,
}

impl World {
    /// An empty world.
    pub fn new(settings: &WorldSettings) -> Result<Self, Error> {
        let spec = settings.to_spec();
        let mut world =
            Self { inner: ffi::new_world(&spec)?, build: Xxh3::new(), commands: Vec::new() };
        world.record("world", &spec);
        Ok(world)
    }

    /// Adds a shape for bodies and compounds to use.
    pub fn add_shape(&mut self, shape: &Shape) -> Result<ShapeId, Error> {
        let spec = shape.to_spec();
        let inner = self.inner.pin_mut();
        let id = match &spec {
            ShapeSpec::Primitive(primitive) => inner.add_primitive(primitive)?,
            ShapeSpec::Hull { points, margin } => inner.add_hull(points, *margin)?,
            ShapeSpec::Compound(children) => inner.add_compound(children)?,
            ShapeSpec::Mesh { vertices, triangles } => inner.add_mesh(vertices, triangles)?,
        };
        self.record("shape", &spec);
        Ok(id)
    }

    /// Removes a shape that no body and no compound uses.
    pub fn remove_shape(&mut self, id: ShapeId) -> Result<(), Error> {
        self.inner.pin_mut().remove_shape(id)?;
        self.record("remove shape", &id);
        Ok(())
    }

    /// Adds a body; at most 4096 at a time.
    pub fn add_body(&mut self, body: &Body) -> Result<BodyId, Error> {
        let spec = body.to_spec();
        let id = self.inner.pin_mut().add_body(&spec)?;
        self.record("body", &spec);
        Ok(id)
    }

    /// Removes a body that has no joints.
    pub fn remove_body(&mut self, id: BodyId) -> Result<(), Error> {
        self.inner.pin_mut().remove_body(id)?;
        self.record("remove body", &id);
        Ok(())
    }

    /// Lets two bodies never collide with each other, whatever their filters say: for as long as both
    /// are in the world.
    ///
    /// # Errors
    /// A body that isn't there; twice the same; two that are kept apart already.
    pub fn keep_apart(&mut self, a: BodyId, b: BodyId) -> Result<(), Error> {
        self.inner.pin_mut().keep_apart(a, b)?;
        self.record("keep apart", &(a, b));
        Ok(())
    }

    /// Adds a joint between two bodies, of which at least one is dynamic.
    pub fn add_joint(&mut self, joint: &Joint) -> Result<JointId, Error> {
        let spec = joint.to_spec();
        let id = self.inner.pin_mut().add_joint(&spec)?;
        self.record("joint", &spec);
        Ok(id)
    }

    /// Removes a joint.
    pub fn remove_joint(&mut self, id: JointId) -> Result<(), Error> {
        self.inner.pin_mut().remove_joint(id)?;
        self.record("remove joint", &id);
        Ok(())
    }

    /// Puts a dynamic body elsewhere, at once and with its velocities; or tells a kinematic body
    /// where to be, which gives it the velocity of getting there within the next step. (A kinematic
    /// body can't be put elsewhere without pushing what it meets; [`World::read_bodies`] shows its
    /// new pose at once.)
    pub fn set_pose(&mut self, id: BodyId, pose: &Isometry3<f64>) -> Result<(), Error> {
        Ok(self.inner.pin_mut().set_pose(id, &to_pose(pose))?)
    }

    /// Sets a dynamic body's velocities, in m/s and rad/s, in world coordinates.
    pub fn set_velocity(
        &mut self,
        id: BodyId,
        linear: &Vector3<f64>,
        angular: &Vector3<f64>,
    ) -> Result<(), Error> {
        Ok(self.inner.pin_mut().set_velocity(id, (*linear).into(), (*angular).into())?)
    }

    /// Adds a force, a torque or an impulse to a dynamic body, in world coordinates.
    ///
    /// Forces and impulses act at `point` (in world coordinates), or at the centre of mass if
    /// there is none; torques and angular impulses are refused a point.
    pub fn push(
        &mut self,
        id: BodyId,
        kind: Push,
        vector: &Vector3<f64>,
        point: Option<&Point3<f64>>,
    ) -> Result<(), Error> {
        let (has_point, point) = (point.is_some(), point.copied().unwrap_or_default());
        let (vector, point) = ((*vector).into(), point.coords.into());
        Ok(self.inner.pin_mut().push(id, kind.to_bridge(), vector, has_point, point)?)
    }

    /// Sets targets and limits of motors, from the next step on. If one command is refused, none
    /// is carried out.
    pub fn set_motors(&mut self, commands: &[MotorCommand]) -> Result<(), Error> {
        self.commands.clear();
        self.commands.extend(commands.iter().map(|command| command.to_bridge()));
        Ok(self.inner.pin_mut().set_motors(&self.commands)?)
    }

    /// Makes one step of [`WorldSettings::time_step`].
    ///
    /// # Errors
    /// [`Error::BlewUp`] if a body's state stops being finite, then and in all later steps; the
    /// error of a [`World::restore`] that left the world in between.
    pub fn step(&mut self) -> Result<(), Error> {
        Ok(self.inner.pin_mut().step()?)
    }

    /// Steps made since the world began; a restored snapshot brings its own count.
    pub fn steps(&self) -> u64 {
        self.inner.steps()
    }

    /// What all bodies do now, `out[id.slot]` for each. `out` is resized to fit, so nothing is
    /// allocated if the caller keeps it.
    pub fn read_bodies(&self, out: &mut Vec<BodyState>) -> Result<(), Error> {
        out.resize(self.inner.body_slots(), BodyState::default());
        Ok(self.inner.read_bodies(out)?)
    }

    /// What all joints do now, `out[id.slot]` for each. `out` is resized to fit, so nothing is
    /// allocated if the caller keeps it.
    pub fn read_joints(&self, out: &mut Vec<JointState>) -> Result<(), Error> {
        out.resize(self.inner.joint_slots(), JointState::default());
        Ok(self.inner.read_joints(out)?)
    }

    /// The angular positions of some joints, in rad: `out[3 i + k]` for `ids[i]` about x, y, z for `k`
    /// of 0, 1, 2, as [`JointState::position`] has them. `out` is resized to fit. Reading only what is
    /// needed pays where it's read before every step.
    pub fn read_angles_of(&self, ids: &[JointId], out: &mut Vec<f64>) -> Result<(), Error> {
        out.resize(3 * ids.len(), 0.0);
        Ok(self.inner.read_angles_of(ids, out)?)
    }

    /// Whether steps measure what motors do, for [`World::read_motors_of`]; not in the beginning. It
    /// takes some time, and changes nothing that the world does.
    pub fn measure_motors(&mut self, measure: bool) {
        self.inner.pin_mut().measure_motors(measure);
    }

    /// What the motors of some joints did in the last step, `out[i]` for `ids[i]`: 0 before the first
    /// step, after a [`World::restore`], and while both bodies sleep. `out` is resized to fit.
    ///
    /// # Errors
    /// A joint that isn't there; a world that doesn't [measure its motors](World::measure_motors).
    pub fn read_motors_of(&self, ids: &[JointId], out: &mut Vec<MotorState>) -> Result<(), Error> {
        out.resize(ids.len(), MotorState::default());
        Ok(self.inner.read_motors_of(ids, out)?)
    }

    /// All contact points of the last step, in Bullet's order. `out` is resized to fit.
    pub fn read_contacts(&self, out: &mut Vec<Contact>) -> Result<(), Error> {
        out.resize(self.inner.contact_count(), Contact::NONE);
        Ok(self.inner.read_contacts(out)?)
    }

    /// Mass in kg (0: not dynamic) and principal moments of inertia in kg m².
    pub fn mass_properties(&self, id: BodyId) -> Result<(f64, Vector3<f64>), Error> {
        let [mass, x, y, z] = self.inner.mass_properties(id)?;
        Ok((mass, Vector3::new(x, y, z)))
    }

    /// Writes all that the continuation depends on into `out`, in place of what it held.
    ///
    /// [`World::restore`] brings it back into this world, or into another one that was built by
    /// the same calls in the same order: its continuation has the same bits.
    pub fn snapshot(&mut self, out: &mut Vec<u8>) -> Result<(), Error> {
        let build = self.build.digest();
        snapshot::seal(build, self.inner.pin_mut().encode_state()?, out);
        Ok(())
    }

    /// Goes back to a [`World::snapshot`].
    ///
    /// # Errors
    /// [`Error::Snapshot`] if the bytes are damaged or of a world that was built differently; the
    /// world is then as before, but for [`SnapshotError::Malformed`](crate::SnapshotError): bytes
    /// that someone made up, whose beginning may be in force. It then refuses to step until
    /// something else is restored.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), Error> {
        let state = snapshot::open(self.build.digest(), bytes)?;
        Ok(self.inner.pin_mut().decode_state(state)?)
    }

    /// For [`Lockstep`](crate::Lockstep).
    pub(crate) fn inner_mut(&mut self) -> Pin<&mut ffi::World> {
        self.inner.pin_mut()
    }

    fn record<T: Serialize>(&mut self, call: &str, arguments: &T) {
        // Postcard refuses only types of unknown length, and there is none here.
        if let Ok(bytes) = postcard::to_allocvec(&(call, arguments)) {
            self.build.update(&bytes);
        }
    }
}

impl std::fmt::Debug for World {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter
            .debug_struct("World")
            .field("steps", &self.steps())
            .field("body_slots", &self.inner.body_slots())
            .field("joint_slots", &self.inner.joint_slots())
            .finish_non_exhaustive()
    }
}

impl Contact {
    /// What fresh places of a buffer hold until they're filled.
    const NONE: Self = Self {
        a: BodyId { slot: 0 },
        b: BodyId { slot: 0 },
        point: [0.0; 3],
        normal: [0.0; 3],
        distance: 0.0,
        impulse: 0.0,
        friction_impulse: [0.0; 3],
    };
}
