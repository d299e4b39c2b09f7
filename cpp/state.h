// What a World owns, from top to bottom, and the order in which it goes: bottom up.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bullet/src/bridge.rs.h"
#include "broadphase.h"
#include "checks.h"
#include "motors.h"
#include "pausing.h"
#include "lockstep/joint_form.h"

namespace itarl {

namespace lockstep {
class Cohort;
}

#ifdef ITARL_FLOAT64
static_assert(sizeof(btScalar) == 8, "float64 needs Bullet's headers with BT_USE_DOUBLE_PRECISION");
#else
static_assert(sizeof(btScalar) == 4, "BT_USE_DOUBLE_PRECISION without the crate's feature float64");
#endif

// btSimpleBroadphase has a fixed number of places and compares all pairs.
inline constexpr int kMostBodies = 4096;

// Bullet's mesh shape points into these.
struct MeshData {
  std::vector<btScalar> vertices;  // x, y, z of each
  std::vector<int> indices;        // three a triangle
  btTriangleIndexVertexArray view;
};

struct ShapeEntry {
  std::unique_ptr<MeshData> mesh;
  std::unique_ptr<btCollisionShape> shape;
  std::vector<std::uint32_t> children;  // slots of a compound's shapes
  int users = 0;                        // bodies and compounds that point to it
  bool solid = true;                    // false for planes and meshes, which have no inside
};

struct BodyEntry {
  std::unique_ptr<btRigidBody> body;
  std::uint32_t shape = 0;
  Motion motion = Motion::Static;
  int joints = 0;
  std::vector<BodyEntry*> apart;  // those that it never collides with, joints or not
};

struct JointEntry {
  std::unique_ptr<btTypedConstraint> joint;
  JointKind kind = JointKind::Fixed;
  btTransform frame_in_parent;
  btTransform frame_in_child;
  BodyEntry* parent = nullptr;
  BodyEntry* child = nullptr;
  std::array<bool, 6> has_motor{};
  std::string axes;  // a letter for each: what rows the solver has for it
  lockstep::JointForm form;
  btJointFeedback feedback{};  // of which body B's part is read
  MotorState motors{};  // of the last step, if that was measured
};

struct State {
  explicit State(const WorldSpec& spec);
  ~State();
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher;
  Broadphase broadphase;
  PausingSolver solver;
  // Slots are never used again; an empty pointer is a removed entry.
  std::vector<std::unique_ptr<ShapeEntry>> shapes;
  std::vector<std::unique_ptr<BodyEntry>> bodies;
  std::vector<std::unique_ptr<JointEntry>> joints;
  MotorMeter motors{joints};
  PausingWorld world;

  btScalar time_step;
  bool sleeping;
  // In m/s, of dynamic bodies.
  double fastest() const { return kLongestMove / double(time_step); }
  std::uint64_t steps = 0;
  int live_bodies = 0;
  // Set when the state stopped being finite, or half of one was restored: Bullet must not go on.
  std::optional<Refusal> broken;
  std::vector<std::uint8_t> snapshot;  // the buffer behind encode_state
  // Of lockstep/structure.h; empty until someone asks, and when bodies or joints come and go.
  mutable std::vector<std::uint64_t> structure;
  // Another one after bodies or joints came or went: copies of what they're made of are good as long
  // as it's the same.
  std::shared_ptr<const int> build = std::make_shared<int>();

  // With whom the world lives in lanes, if it does, and in which one.
  std::shared_ptr<lockstep::Cohort> cohort;
  std::size_t lane = 0;
  // Brings Bullet's objects up to date with it.
  void settle() const;
  void leave_lanes();

  void restructure() {
    structure.clear();
    build = std::make_shared<int>();
  }

  // Before each step, whoever makes it.
  void begin_step();

  ShapeEntry& shape(const Call& call, std::string_view argument, ShapeId id) const;
  BodyEntry& body(const Call& call, std::string_view argument, BodyId id) const;
  JointEntry& joint(const Call& call, std::string_view argument, JointId id) const;
};

// Has Bullet forget the contact points that two bodies have: it would go on solving them as they are
// when their collisions are switched off.
void forget_contacts(State& state, btRigidBody& a, btRigidBody& b);

// Counts a step that was made, and throws if the state stopped being finite in it.
void check_step(State& state);

// The slot of a body, which Bullet carries as its user index.
inline std::uint32_t slot_of(const btCollisionObject& object) {
  return static_cast<std::uint32_t>(object.getUserIndex());
}

inline btTransform to_transform(const Call& call, const std::string& argument, const Pose& pose) {
  return btTransform(call.rotation(argument + ".rotation", pose.rotation),
                     call.point(argument + ".position", pose.position));
}

}  // namespace itarl
