// The one C++ class that Rust sees. What it holds is private (state.h); each group of functions
// has a file: world.cc, shapes.cc, bodies.cc, joints.cc, motors.cc, contacts.cc, snapshot.cc.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "refusal.h"
#include "rust/cxx.h"

namespace itarl {

// Plain structs shared with Rust; defined in crates/bullet/src/bridge.rs.
struct WorldSpec;
struct PrimitiveSpec;
struct CompoundChild;
struct BodySpec;
struct JointSpec;
struct Pose;
struct ShapeId;
struct BodyId;
struct JointId;
struct BodyState;
struct JointState;
struct Contact;
struct MotorCommand;
struct MotorState;
enum class Push : std::uint8_t;

struct State;

class World {
 public:
  explicit World(const WorldSpec& spec);
  ~World();

  // shapes.cc
  ShapeId add_primitive(const PrimitiveSpec& spec);
  ShapeId add_hull(rust::Slice<const double> points, double margin);
  ShapeId add_compound(rust::Slice<const CompoundChild> children);
  ShapeId add_mesh(rust::Slice<const double> vertices, rust::Slice<const std::uint32_t> triangles);
  void remove_shape(ShapeId id);

  // bodies.cc
  BodyId add_body(const BodySpec& spec);
  void remove_body(BodyId id);
  void keep_apart(BodyId a, BodyId b);
  void set_pose(BodyId id, const Pose& pose);
  void set_velocity(BodyId id, std::array<double, 3> linear, std::array<double, 3> angular);
  void push(BodyId id, Push kind, std::array<double, 3> vector, bool has_point,
            std::array<double, 3> point);
  std::size_t body_slots() const noexcept;
  void read_bodies(rust::Slice<BodyState> out) const;
  std::array<double, 4> mass_properties(BodyId id) const;

  // joints.cc
  JointId add_joint(const JointSpec& spec);
  void remove_joint(JointId id);
  void set_motors(rust::Slice<const MotorCommand> commands);
  std::size_t joint_slots() const noexcept;
  void read_joints(rust::Slice<JointState> out) const;
  void read_angles_of(rust::Slice<const JointId> ids, rust::Slice<double> out) const;

  // motors.cc
  void measure_motors(bool measure) noexcept;
  void read_motors_of(rust::Slice<const JointId> ids, rust::Slice<MotorState> out) const;

  // contacts.cc
  std::size_t contact_count() const noexcept;
  void read_contacts(rust::Slice<Contact> out) const;

  // world.cc
  void step();
  std::uint64_t steps() const noexcept;

  // For lockstep/lockstep.cc.
  State& state() noexcept { return *state_; }

  // snapshot.cc
  rust::Slice<const std::uint8_t> encode_state();
  void decode_state(rust::Slice<const std::uint8_t> bytes);

 private:
  // The state for those who read what moves, and for those who change anything: a world that lives in
  // lanes is brought up to date for the former, and leaves them for the latter.
  const State& settled() const;
  State& changing();

  std::unique_ptr<State> state_;
};

std::unique_ptr<World> new_world(const WorldSpec& spec);

}  // namespace itarl
