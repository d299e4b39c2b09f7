// Rigid bodies: adding, moving, pushing, reading.
#include <algorithm>

#include "state.h"
#include "world.h"

namespace itarl {

namespace {

// Principal moments of inertia. Bullet inverts them, in its own precision.
btVector3 inertia_of(const Call& call, const BodySpec& spec, const ShapeEntry& shape,
                     btScalar mass) {
  btVector3 inertia(0, 0, 0);
  if (spec.has_inertia) {
    inertia = call.numbers("inertia", spec.inertia);
  } else {
    shape.shape->calculateLocalInertia(mass, inertia);
  }
  for (int i = 0; i < 3; ++i) {
    if (!(inertia[i] > 0 && std::isfinite(1 / inertia[i]) && std::isfinite(inertia[i]))) {
      const std::string name = spec.has_inertia ? "inertia" : "inertia from mass and shape";
      call.refuse(name + "." + "xyz"[i], "above 0, with a finite inverse", inertia[i]);
    }
  }
  return inertia;
}

// Turned any way, its bounding box must stay below the 1e6 m from corner to corner at which
// Bullet leaves the box where it was. A plane's has no end, and needn't move.
void check_extent(const Call& call, const btCollisionShape& shape) {
  if (shape.getShapeType() == STATIC_PLANE_PROXYTYPE) return;
  btVector3 centre;
  btScalar radius;
  shape.getBoundingSphere(centre, radius);
  if (!(2 * radius <= kLargestMovingDiagonal)) {
    call.refuse("shape", "at most 4e5 m from corner to corner for a body that moves",
                "one of " + to_text(2 * radius) + " m");
  }
}

// What slept on a body must notice when it goes away.
void wake_neighbours(State& state, const btRigidBody& body) {
  for (int i = 0; i < state.dispatcher.getNumManifolds(); ++i) {
    const btPersistentManifold& manifold = *state.dispatcher.getManifoldByIndexInternal(i);
    if (manifold.getBody0() == &body) manifold.getBody1()->activate();
    if (manifold.getBody1() == &body) manifold.getBody0()->activate();
  }
}

}  // namespace

void forget_contacts(State& state, btRigidBody& a, btRigidBody& b) {
  btOverlappingPairCache& cache = *state.broadphase.getOverlappingPairCache();
  btBroadphasePair* pair = cache.findPair(a.getBroadphaseProxy(), b.getBroadphaseProxy());
  if (pair) cache.cleanOverlappingPair(*pair, &state.dispatcher);
}

BodyId World::add_body(const BodySpec& spec) {
  const Call call{"add_body"};
  State& state = changing();
  if (state.live_bodies == kMostBodies) {
    call.refuse("body", "one of at most " + std::to_string(kMostBodies) + " in a world",
                "one more");
  }
  ShapeEntry& shape = state.shape(call, "shape", spec.shape);
  const btTransform pose = to_transform(call, "pose", spec.pose);
  if (spec.motion != Motion::Static) check_extent(call, *shape.shape);
  const bool dynamic = spec.motion == Motion::Dynamic;
  btScalar mass = 0;
  btVector3 inertia(0, 0, 0);
  if (dynamic) {
    mass = call.within("mass", spec.mass, 1e-12, 1e12, "between 1e-12 and 1e12 kg");
    if (!shape.solid) {
      call.refuse("shape", "a solid one for a dynamic body", shape.shape->getName());
    }
    inertia = inertia_of(call, spec, shape, mass);
  }

  btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shape.shape.get(), inertia);
  info.m_startWorldTransform = pose;
  info.m_friction = call.non_negative("friction", spec.friction);
  info.m_rollingFriction = call.non_negative("rolling_friction", spec.rolling_friction);
  info.m_spinningFriction = call.non_negative("spinning_friction", spec.spinning_friction);
  const char* const fraction = "between 0 and 1";
  info.m_restitution = call.within("restitution", spec.restitution, 0, 1, fraction);
  info.m_linearDamping = call.within("linear_damping", spec.linear_damping, 0, 1, fraction);
  info.m_angularDamping = call.within("angular_damping", spec.angular_damping, 0, 1, fraction);

  auto entry = std::make_unique<BodyEntry>();
  entry->body = std::make_unique<btRigidBody>(info);
  entry->shape = spec.shape.slot;
  entry->motion = spec.motion;
  btRigidBody& body = *entry->body;
  body.setUserIndex(static_cast<int>(state.bodies.size()));
  if (spec.motion == Motion::Kinematic) {
    body.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    body.setActivationState(DISABLE_DEACTIVATION);  // else its poses go unnoticed
  } else if (dynamic && !state.sleeping) {
    body.setActivationState(DISABLE_DEACTIVATION);
  }

  state.restructure();
  state.bodies.push_back(std::move(entry));
  state.world.addRigidBody(&body, spec.group, spec.mask);
  ++shape.users;
  ++state.live_bodies;
  return BodyId{static_cast<std::uint32_t>(state.bodies.size() - 1)};
}

void World::remove_body(BodyId id) {
  const Call call{"remove_body"};
  State& state = changing();
  BodyEntry& entry = state.body(call, "id", id);
  if (entry.joints > 0) {
    call.refuse("id", "a body without joints",
                "body " + std::to_string(id.slot) + ", which has " + std::to_string(entry.joints));
  }
  wake_neighbours(state, *entry.body);
  // Bullet compares addresses, of which a later body may have this one's.
  for (BodyEntry* other : entry.apart) {
    other->body->setIgnoreCollisionCheck(entry.body.get(), false);
    other->apart.erase(std::find(other->apart.begin(), other->apart.end(), &entry));
  }
  state.world.removeRigidBody(entry.body.get());
  --state.shapes[entry.shape]->users;
  --state.live_bodies;
  state.bodies[id.slot].reset();
  state.restructure();
}

// A joint between them keeps them apart as well; Bullet counts how often it's told.
void World::keep_apart(BodyId a, BodyId b) {
  const Call call{"keep_apart"};
  State& state = changing();
  BodyEntry& one = state.body(call, "a", a);
  BodyEntry& other = state.body(call, "b", b);
  if (&one == &other) {
    call.refuse("b", "another body than a", "body " + std::to_string(b.slot));
  }
  if (std::find(one.apart.begin(), one.apart.end(), &other) != one.apart.end()) {
    call.refuse("b", "a body that isn't kept apart from a already",
                "body " + std::to_string(b.slot));
  }
  one.apart.reserve(one.apart.size() + 1);
  other.apart.reserve(other.apart.size() + 1);
  wake_neighbours(state, *one.body);
  one.body->setIgnoreCollisionCheck(other.body.get(), true);
  other.body->setIgnoreCollisionCheck(one.body.get(), true);
  one.apart.push_back(&other);
  other.apart.push_back(&one);
  forget_contacts(state, *one.body, *other.body);
  state.restructure();
}

void World::set_pose(BodyId id, const Pose& pose) {
  const Call call{"set_pose"};
  State& state = changing();
  BodyEntry& entry = state.body(call, "id", id);
  const btTransform checked = to_transform(call, "pose", pose);
  if (entry.motion == Motion::Static) {
    call.refuse("id", "a dynamic or kinematic body",
                "body " + std::to_string(id.slot) + ", which is static");
  }
  btRigidBody& body = *entry.body;
  if (entry.motion == Motion::Kinematic) {
    // Bullet takes the velocity from the difference to its interpolation transform.
    body.setWorldTransform(checked);
  } else {
    wake_neighbours(state, body);
    body.setCenterOfMassTransform(checked);
  }
  body.activate();
}

void World::set_velocity(BodyId id, std::array<double, 3> linear, std::array<double, 3> angular) {
  const Call call{"set_velocity"};
  State& state = changing();
  BodyEntry& entry = state.body(call, "id", id);
  const btVector3 checked_linear = call.numbers("linear", linear);
  const btVector3 checked_angular = call.numbers("angular", angular);
  if (entry.motion != Motion::Dynamic) {
    call.refuse("id", "a dynamic body",
                "body " + std::to_string(id.slot) + ", which is static or kinematic");
  }
  if (!within(checked_linear, state.fastest())) {
    call.refuse("linear", "at most 5e5 m in a step", to_text(checked_linear) + " m/s");
  }
  entry.body->setLinearVelocity(checked_linear);
  entry.body->setAngularVelocity(checked_angular);
  entry.body->activate();
}

void World::push(BodyId id, Push kind, std::array<double, 3> vector, bool has_point,
                 std::array<double, 3> point) {
  const Call call{"push"};
  State& state = changing();
  BodyEntry& entry = state.body(call, "id", id);
  const btVector3 checked = call.numbers("vector", vector);
  if (entry.motion != Motion::Dynamic) {
    call.refuse("id", "a dynamic body",
                "body " + std::to_string(id.slot) + ", which is static or kinematic");
  }
  btRigidBody& body = *entry.body;
  const bool moves = kind == Push::Force || kind == Push::Impulse;
  if (has_point && !moves) call.refuse("point", "absent for a torque or an angular impulse", "one");
  btVector3 arm(0, 0, 0);
  if (has_point) arm = call.point("point", point) - body.getCenterOfMassPosition();
  // A light body, a long arm or many pushes leave the range where one vector doesn't.
  const bool at_once = kind == Push::Impulse || kind == Push::AngularImpulse;
  const btVector3 move = moves ? checked : btVector3(0, 0, 0);
  const btVector3 turn = moves ? arm.cross(checked) : checked;
  const bool stays_in_range =
      at_once ? within(body.getLinearVelocity() + move * body.getInvMass(), state.fastest()) &&
                    in_range(body.getAngularVelocity() + body.getInvInertiaTensorWorld() * turn)
              : in_range(body.getTotalForce() + move) && in_range(body.getTotalTorque() + turn);
  if (!stays_in_range) {
    call.refuse("vector",
                at_once ? "small enough to keep the body below 5e5 m in a step and 1e18 rad/s"
                        : "small enough to keep the body's total force and torque within 1e18",
                to_text(checked));
  }
  switch (kind) {
    case Push::Force:
      body.applyForce(checked, arm);
      break;
    case Push::Torque:
      body.applyTorque(checked);
      break;
    case Push::Impulse:
      body.applyImpulse(checked, arm);
      break;
    case Push::AngularImpulse:
      body.applyTorqueImpulse(checked);
      break;
    default:
      call.refuse("kind", "a kind of push", std::to_string(int(kind)));
  }
  body.activate();
}

std::size_t World::body_slots() const noexcept { return state_->bodies.size(); }

void World::read_bodies(rust::Slice<BodyState> out) const {
  const State& state = settled();
  if (out.size() != state.bodies.size()) {
    Call{"read_bodies"}.refuse("out", std::to_string(state.bodies.size()) + " entries long",
                               std::to_string(out.size()));
  }
  for (std::size_t slot = 0; slot < out.size(); ++slot) {
    BodyState& to = out[slot];
    if (!state.bodies[slot]) {
      to = BodyState{};
      continue;
    }
    const btRigidBody& body = *state.bodies[slot]->body;
    const btTransform& pose = body.getWorldTransform();
    to.position = to_array(pose.getOrigin());
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        to.rotation[3 * row + column] = pose.getBasis()[row][column];
      }
    }
    to.linear_velocity = to_array(body.getLinearVelocity());
    to.angular_velocity = to_array(body.getAngularVelocity());
    to.exists = true;
    to.awake = body.isActive();
  }
}

std::array<double, 4> World::mass_properties(BodyId id) const {
  const BodyEntry& entry = state_->body(Call{"mass_properties"}, "id", id);
  const btVector3 inertia = entry.body->getLocalInertia();
  return {entry.body->getMass(), inertia.x(), inertia.y(), inertia.z()};
}

}  // namespace itarl
