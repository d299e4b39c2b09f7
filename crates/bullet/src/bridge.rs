//! The crossing to C++: the one file where `unsafe` is allowed.
//!
//! Few and wide: a call moves whole buffers, ids and plain structs, never a C++ reference.
//! Every function that can refuse returns `Result`; the shim (`cpp/`) checks all arguments, and
//! `cpp/refusal.h` turns whatever C++ throws into an `Err`, so nothing here can end the process.
//! Numbers cross as `f64` whatever Bullet's precision (exact for `f32`).
//!
//! The structs are the shim's flat view. Ids, states and contacts are public as they are; the
//! others are filled in by the typed settings of `shape.rs`, `body.rs` and `joint.rs`. Enums stay
//! inside: to C++ they are numbers, and Rust could make one that is none of them.
#![allow(unsafe_code)]
// cxx makes everything in its module public; what leaves the crate is chosen in lib.rs.
#![allow(unreachable_pub)]

use std::pin::Pin;

#[cxx::bridge(namespace = "itarl")]
pub mod ffi {
    /// A shape in a [`World`](crate::World).
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
    pub struct ShapeId {
        /// Counts the shapes ever added to that world, from 0; never used again after removal.
        pub slot: u32,
    }

    /// A body in a [`World`](crate::World).
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
    pub struct BodyId {
        /// Counts the bodies ever added to that world, from 0; never used again after removal.
        /// It is the body's place in the buffer of [`World::read_bodies`](crate::World::read_bodies).
        pub slot: u32,
    }

    /// A joint in a [`World`](crate::World).
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
    pub struct JointId {
        /// Counts the joints ever added to that world, from 0; never used again after removal.
        /// It is the joint's place in the buffer of [`World::read_joints`](crate::World::read_joints).
        pub slot: u32,
    }

    /// What a body does now, in world coordinates.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    pub struct BodyState {
        /// Centre of mass in m.
        pub position: [f64; 3],
        /// Body to world, `[3 x 3]` row-major, as Bullet keeps it.
        pub rotation: [f64; 9],
        /// The velocity of the centre of mass, in m/s.
        pub linear_velocity: [f64; 3],
        /// The angular velocity about the axes of the world, in rad/s.
        pub angular_velocity: [f64; 3],
        /// False where the body was removed; all else is then 0.
        pub exists: bool,
        /// False while Bullet has put the body to sleep, and for static bodies.
        pub awake: bool,
    }

    /// What a joint does now; see [`Joint`](crate::Joint) for the conventions.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    pub struct JointState {
        /// By [`Axis`](crate::Axis): the child's frame seen from the parent's frame, in m and rad.
        /// An axis that the joint locks reads the joint's error. Angles lie within half a turn of 0
        /// (about y, with three angles, a quarter): a wheel's jumps as it passes there.
        pub position: [f64; 6],
        /// Time derivatives of `position`, in m/s and rad/s.
        pub velocity: [f64; 6],
        /// Force of the joint on the child at its centre of mass, world coordinates, in N, over
        /// the last step.
        pub force: [f64; 3],
        /// Torque of the joint on the child about its centre of mass, world coordinates, in N m,
        /// over the last step.
        pub torque: [f64; 3],
        /// False where the joint was removed; all else is then 0.
        pub exists: bool,
    }

    /// What the motors of a joint did in the last step, by [`Axis`](crate::Axis); 0 for an axis without
    /// a motor.
    ///
    /// A hinge and a slider hold a stop and drive their axis by one constraint. What that does at the
    /// stop counts as the motor's, as far as the motor's own limit goes.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    pub struct MotorState {
        /// The force in N or torque in N m, the mean over the step, positive where it makes the axis'
        /// position grow; within the motor's `max_force`.
        pub force: [f64; 6],
        /// The mechanical work on the bodies, in J: the force times how far the axis moved in the step,
        /// negative where the motor brakes. On a joint with three angles: the torque about the axis on
        /// which the motor acts, times how far the bodies turned about that.
        pub work: [f64; 6],
    }

    /// A contact point of the last step's collision detection.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Contact {
        /// One of the two bodies; which one is up to Bullet.
        pub a: BodyId,
        /// The second body of the pair.
        pub b: BodyId,
        /// On the surface of `b`, world coordinates, in m.
        pub point: [f64; 3],
        /// Unit vector from `b` towards `a`, world coordinates.
        pub normal: [f64; 3],
        /// Gap in m, negative where the bodies overlap. Bullet finds points apart by up to 2 % of the
        /// radius of the smaller body (of the ball around its bounding box).
        pub distance: f64,
        /// Normal impulse on `a` along `normal` in the last step, in N s, at least 0.
        pub impulse: f64,
        /// Friction impulse on `a` in the last step, world coordinates, in N s.
        pub friction_impulse: [f64; 3],
    }

    #[derive(Clone, Copy, Debug, Serialize)]
    struct WorldSpec {
        gravity: [f64; 3],
        time_step: f64,
        iterations: u32,
        solver_mode: i32,
        joint_erp: f64,
        contact_erp: f64,
        cfm: f64,
        split_impulse: bool,
        split_impulse_threshold: f64,
        sleeping: bool,
    }

    #[derive(Clone, Copy, Debug, Serialize)]
    struct Pose {
        position: [f64; 3],
        /// x, y, z, w
        rotation: [f64; 4],
    }

    #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
    #[repr(u8)]
    enum Primitive {
        /// size: normal x, y, z; offset
        Plane,
        /// size: half extents x, y, z; -
        Box,
        /// size: radius; -; -; -
        Sphere,
        /// size: radius; length; -; -
        Capsule,
        /// size: radius; length; -; -
        Cylinder,
        /// size: radii x, y, z; -
        Ellipsoid,
    }

    #[derive(Clone, Copy, Debug, Serialize)]
    struct PrimitiveSpec {
        kind: Primitive,
        size: [f64; 4],
        /// 0, 1, 2: capsules and cylinders lie along x, y, z
        axis: u8,
    }

    #[derive(Clone, Copy, Debug, Serialize)]
    struct CompoundChild {
        shape: ShapeId,
        pose: Pose,
    }

    #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
    #[repr(u8)]
    enum Motion {
        Static,
        Dynamic,
        Kinematic,
    }

    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    #[repr(u8)]
    enum Push {
        Force,
        Torque,
        Impulse,
        AngularImpulse,
    }

    #[derive(Clone, Copy, Debug, Serialize)]
    struct BodySpec {
        shape: ShapeId,
        motion: Motion,
        pose: Pose,
        mass: f64,
        has_inertia: bool,
        inertia: [f64; 3],
        friction: f64,
        rolling_friction: f64,
        spinning_friction: f64,
        restitution: f64,
        linear_damping: f64,
        angular_damping: f64,
        group: i32,
        mask: i32,
    }

    #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
    #[repr(u8)]
    enum JointKind {
        Fixed,
        PointToPoint,
        Hinge,
        Slider,
        SixDofSpring,
    }

    /// `Option<f64>` for C++.
    #[derive(Clone, Copy, Debug, Default, Serialize)]
    struct Maybe {
        given: bool,
        value: f64,
    }

    #[derive(Clone, Copy, Debug, Serialize)]
    struct AxisSpec {
        /// Anywhere, whatever the limits.
        free: bool,
        lower: f64,
        upper: f64,
        stop_erp: Maybe,
        stop_cfm: Maybe,
        stop_bounce: Maybe,
        has_motor: bool,
        motor_velocity: f64,
        motor_force: f64,
        has_spring: bool,
        spring_stiffness: f64,
        spring_damping: f64,
        spring_equilibrium: f64,
    }

    #[derive(Clone, Copy, Debug, Serialize)]
    struct JointSpec {
        kind: JointKind,
        parent: BodyId,
        child: BodyId,
        frame_in_parent: Pose,
        frame_in_child: Pose,
        collide_connected: bool,
        axes: [AxisSpec; 6],
    }

    #[derive(Clone, Copy, Debug)]
    struct MotorCommand {
        joint: JointId,
        /// 0 to 5
        axis: u8,
        target_velocity: f64,
        max_force: f64,
    }

    /// What became of the steps of worlds in a [`Lockstep`](crate::Lockstep).
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub struct LockstepCounts {
        /// Steps that were swept in lanes.
        pub swept: u64,
        /// Sweeps, each of one or more worlds.
        pub sweeps: u64,
        /// Steps without any row, all of whose bodies fly or sleep.
        pub idle: u64,
        /// Groups of bodies, beside the last one of a step, that were left to Bullet's own loop:
        /// Bullet makes a group of each hundred or so joints and contacts that are apart.
        pub separate_groups: u64,
        /// Steps left to Bullet's own loop for what lanes don't cover: rolling friction, a random
        /// order of rows, rows that nothing can satisfy; all, with a Bullet that isn't Debian's.
        pub unsupported: u64,
        /// Steps left to it since what changed was so small that Bullet might have stopped early.
        pub maybe_converged: u64,
        /// Steps left to it since a number wasn't finite.
        pub not_finite: u64,
        /// Steps that were swept with joints whose rows Bullet made, world by world. Lanes make those
        /// of sliders, fixed and 6-dof joints between bodies that move.
        pub bullet_rows: u64,
        /// Steps that were swept with bodies that Bullet moved, world by world. It does where some
        /// are kinematic, might fall asleep, lie in a separate group or were pushed out of others.
        pub bullet_moves: u64,
        /// Steps that were swept with contacts that Bullet found, world by world. Lanes find those of
        /// boxes, capsules and spheres with planes, if all of a world's contacts are such: then all of
        /// the step is theirs, and worlds live in lanes from step to step.
        pub bullet_contacts: u64,
    }

    /// Where the time of a [`Lockstep`](crate::Lockstep) went, in s.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    pub struct LockstepTimes {
        /// Bullet's part before its iterations: collisions, islands, rows of contacts. Of worlds that
        /// live in lanes all that comes before them.
        pub begin: f64,
        /// From worlds into lanes: rows of joints, and those from Bullet's pools.
        pub pack: f64,
        /// Seconds in the solver's iterations.
        pub sweep: f64,
        /// Back to the worlds: impulses and motion; with the iterations that were left to Bullet's
        /// own loop.
        pub unpack: f64,
        /// Bullet's part after its iterations, and the check that all is finite. Of worlds that live
        /// in lanes all that comes after them.
        pub end: f64,
    }

    unsafe extern "C++" {
        include!("world.h");
        include!("lockstep/lockstep.h");

        /// All of a Bullet world, behind `std::unique_ptr`.
        type World;

        fn new_world(spec: &WorldSpec) -> Result<UniquePtr<World>>;

        fn add_primitive(self: Pin<&mut World>, spec: &PrimitiveSpec) -> Result<ShapeId>;
        fn add_hull(self: Pin<&mut World>, points: &[f64], margin: f64) -> Result<ShapeId>;
        fn add_compound(self: Pin<&mut World>, children: &[CompoundChild]) -> Result<ShapeId>;
        fn add_mesh(self: Pin<&mut World>, vertices: &[f64], triangles: &[u32]) -> Result<ShapeId>;
        fn remove_shape(self: Pin<&mut World>, id: ShapeId) -> Result<()>;

        fn add_body(self: Pin<&mut World>, spec: &BodySpec) -> Result<BodyId>;
        fn remove_body(self: Pin<&mut World>, id: BodyId) -> Result<()>;
        fn set_pose(self: Pin<&mut World>, id: BodyId, pose: &Pose) -> Result<()>;
        fn set_velocity(
            self: Pin<&mut World>,
            id: BodyId,
            linear: [f64; 3],
            angular: [f64; 3],
        ) -> Result<()>;
        fn push(
            self: Pin<&mut World>,
            id: BodyId,
            kind: Push,
            vector: [f64; 3],
            has_point: bool,
            point: [f64; 3],
        ) -> Result<()>;

        fn keep_apart(self: Pin<&mut World>, a: BodyId, b: BodyId) -> Result<()>;

        fn add_joint(self: Pin<&mut World>, spec: &JointSpec) -> Result<JointId>;
        fn remove_joint(self: Pin<&mut World>, id: JointId) -> Result<()>;
        fn set_motors(self: Pin<&mut World>, commands: &[MotorCommand]) -> Result<()>;

        fn step(self: Pin<&mut World>) -> Result<()>;
        fn steps(self: &World) -> u64;

        fn body_slots(self: &World) -> usize;
        fn joint_slots(self: &World) -> usize;
        fn contact_count(self: &World) -> usize;
        /// `out` must have as many entries as there are slots or contacts.
        fn read_bodies(self: &World, out: &mut [BodyState]) -> Result<()>;
        fn read_joints(self: &World, out: &mut [JointState]) -> Result<()>;
        fn read_angles_of(self: &World, ids: &[JointId], out: &mut [f64]) -> Result<()>;
        fn measure_motors(self: Pin<&mut World>, measure: bool);
        fn read_motors_of(self: &World, ids: &[JointId], out: &mut [MotorState]) -> Result<()>;
        fn read_contacts(self: &World, out: &mut [Contact]) -> Result<()>;
        fn mass_properties(self: &World, id: BodyId) -> Result<[f64; 4]>;

        /// The world's dynamic state; the slice is the world's own buffer.
        fn encode_state(self: Pin<&mut World>) -> Result<&[u8]>;
        fn decode_state(self: Pin<&mut World>, bytes: &[u8]) -> Result<()>;

        /// Steps worlds together.
        type Lockstep;

        fn has_instructions(instructions: u8) -> bool;
        fn lanes_of(instructions: u8) -> usize;
        fn new_lockstep(instructions: u8) -> Result<UniquePtr<Lockstep>>;
        fn expect(self: Pin<&mut Lockstep>, count: usize) -> Result<()>;
        /// # Safety
        /// The world must live, and nothing else use it, until `step` or until this is dropped. More
        /// worlds than were expected are left out.
        unsafe fn enlist(self: Pin<&mut Lockstep>, world: Pin<&mut World>);
        fn step(self: Pin<&mut Lockstep>) -> Result<()>;
        fn result(self: &Lockstep, index: usize) -> Result<()>;
        fn counts(self: &Lockstep) -> LockstepCounts;
        fn times(self: &Lockstep) -> LockstepTimes;
    }
}

/// One step of all worlds.
pub(crate) fn step_together<'a>(
    mut lockstep: Pin<&mut ffi::Lockstep>,
    worlds: impl ExactSizeIterator<Item = Pin<&'a mut ffi::World>>,
) -> Result<(), cxx::Exception> {
    lockstep.as_mut().expect(worlds.len())?;
    for world in worlds {
        // SAFETY: the iterator's borrows are exclusive and outlive this function, and `step`
        // forgets the worlds whether it succeeds or not.
        unsafe { lockstep.as_mut().enlist(world) };
    }
    lockstep.step()
}

// SAFETY: a `World` owns everything it points to (`cpp/state.h`), and Bullet built without
// BT_THREADSAFE, as Debian's is, ties nothing to a thread: no thread-local storage, no locks. What
// its libraries share between worlds is constant after loading, but for counters of debug ids and
// of split-impulse recoveries, which are incremented and never read for a result: what's lost when
// two threads do so at once is a count. The shim never uses what would really be shared, the
// static fixed body of single-body joints and the global callbacks. tests/determinism.rs steps
// worlds in many threads and moves them. Not `Sync`: Bullet's const methods aren't promised to be
// free of caches.
unsafe impl Send for ffi::World {}

// Worlds that live in lanes share these (`cpp/lockstep/cohort.h`), by pointers that are counted
// atomically. A world reads and marks its own lane; all are written by a `Lockstep` alone, in a step
// for which it has all of their worlds to itself.
// SAFETY: between steps a `Lockstep` follows pointers to nothing but its own memory and such lanes; it
// compares the addresses of the worlds in them.
unsafe impl Send for ffi::Lockstep {}
