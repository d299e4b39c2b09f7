// A world's life and its step.
#include "world.h"

#include "lockstep/cohort.h"
#include "state.h"

namespace itarl {

namespace {

template <typename Entry, typename Id>
Entry& find(const std::vector<std::unique_ptr<Entry>>& entries, const Call& call,
            std::string_view argument, Id id) {
  if (id.slot >= entries.size()) {
    call.refuse_id(argument, std::to_string(id.slot),
                   "only " + std::to_string(entries.size()) + " were ever added");
  }
  if (!entries[id.slot]) call.refuse_id(argument, std::to_string(id.slot), "it was removed");
  return *entries[id.slot];
}

[[noreturn]] void blew_up(const State& state, const btCollisionObject& body,
                          const char* quantity, const btVector3& v) {
  refuse_state(std::to_string(slot_of(body)), std::to_string(state.steps), quantity, to_text(v));
}

// Throws, naming the first body that left the range in which all that is computed from it is
// finite, or that moves too far in a step: Bullet would leave its bounding box behind.
void check_bodies(const State& state) {
  for (const auto& entry : state.bodies) {
    if (!entry || entry->motion == Motion::Static) continue;
    const btRigidBody& body = *entry->body;
    const btTransform& pose = body.getWorldTransform();
    const auto check = [&](bool fine, const char* quantity, const btVector3& v) {
      if (!fine) blew_up(state, body, quantity, v);
    };
    const btVector3& velocity = body.getLinearVelocity();
    const bool slow = body.isKinematicObject() || within(velocity, state.fastest());
    check(in_range(velocity) && slow, "linear velocity", velocity);
    check(in_range(body.getAngularVelocity()), "angular velocity", body.getAngularVelocity());
    check(is_near(pose.getOrigin()), "position", pose.getOrigin());
    for (int row = 0; row < 3; ++row) {
      check(in_range(pose.getBasis()[row]), "rotation", pose.getBasis()[row]);
    }
  }
}

// What the solver found may overflow where the velocities don't. A sum is finite only if its terms
// are, or if they nearly overflow, which is as good as infinite.
void check_impulses(const State& state) {
  const auto check = [&](const btCollisionObject& body, const char* quantity, const btVector3& v) {
    const btScalar sum = btFabs(v.x()) + btFabs(v.y()) + btFabs(v.z());
    if (!std::isfinite(sum)) blew_up(state, body, quantity, v);
  };
  for (const auto& entry : state.joints) {
    if (!entry) continue;
    check(*entry->child->body, "joint force", entry->feedback.m_appliedForceBodyB);
    check(*entry->child->body, "joint torque", entry->feedback.m_appliedTorqueBodyB);
  }
  for (int i = 0; i < state.dispatcher.getNumManifolds(); ++i) {
    const btPersistentManifold& manifold = *state.dispatcher.getManifoldByIndexInternal(i);
    const bool first = !manifold.getBody0()->isStaticOrKinematicObject();
    for (int k = 0; k < manifold.getNumContacts(); ++k) {
      const btManifoldPoint& point = manifold.getContactPoint(k);
      check(first ? *manifold.getBody0() : *manifold.getBody1(), "contact impulse",
            btVector3(point.m_appliedImpulse, point.m_appliedImpulseLateral1,
                      point.m_appliedImpulseLateral2));
    }
  }
}

// Bullet sets aside 4096 contact manifolds and as many algorithms for each world, about 6 MB that it
// writes through. These suffice for a robot; when they're used up Bullet takes more from the heap.
btDefaultCollisionConstructionInfo modest_pools() {
  btDefaultCollisionConstructionInfo info;
  info.m_defaultMaxPersistentManifoldPoolSize = 128;
  info.m_defaultMaxCollisionAlgorithmPoolSize = 128;
  return info;
}

}  // namespace

State::State(const WorldSpec& spec)
    : configuration(modest_pools()),
      dispatcher(&configuration),
      broadphase(kMostBodies),
      world(&dispatcher, &broadphase, &solver, &configuration) {
  const Call call{"World::new"};
  world.setGravity(call.numbers("gravity", spec.gravity));
  time_step = call.within("time_step", spec.time_step, 1e-6, 1, "between 1e-6 and 1 s");
  if (spec.iterations < 1 || spec.iterations > 1'000'000) {
    call.refuse("iterations", "between 1 and 1000000", std::to_string(spec.iterations));
  }
  const char* const fraction = "between 0 and 1";
  btContactSolverInfo& info = world.getSolverInfo();
  info.m_numIterations = static_cast<int>(spec.iterations);
  info.m_solverMode = spec.solver_mode;
  info.m_erp = call.within("joint_erp", spec.joint_erp, 0, 1, fraction);
  info.m_erp2 = call.within("contact_erp", spec.contact_erp, 0, 1, fraction);
  info.m_globalCfm = call.non_negative("cfm", spec.cfm);
  info.m_splitImpulse = spec.split_impulse;
  info.m_splitImpulsePenetrationThreshold =
      call.number("split_impulse_threshold", spec.split_impulse_threshold);
  sleeping = spec.sleeping;
}

State::~State() {
  for (const auto& entry : joints) {
    if (entry) world.removeConstraint(entry->joint.get());
  }
  for (const auto& entry : bodies) {
    if (entry) world.removeRigidBody(entry->body.get());
  }
}

ShapeEntry& State::shape(const Call& call, std::string_view argument, ShapeId id) const {
  return find(shapes, call, argument, id);
}
BodyEntry& State::body(const Call& call, std::string_view argument, BodyId id) const {
  return find(bodies, call, argument, id);
}
JointEntry& State::joint(const Call& call, std::string_view argument, JointId id) const {
  return find(joints, call, argument, id);
}

void State::settle() const {
  if (cohort) cohort->settle(lane, const_cast<State&>(*this));
}

void State::leave_lanes() {
  settle();
  cohort.reset();
}

void State::begin_step() {
  if (solver.is_observed()) motors.begin(time_step);
}

void check_step(State& state) {
  ++state.steps;
  try {
    check_bodies(state);
    check_impulses(state);
  } catch (const Refusal& refusal) {
    state.broken = refusal;
    throw;
  }
}

World::World(const WorldSpec& spec) : state_(std::make_unique<State>(spec)) {}
World::~World() = default;

const State& World::settled() const {
  state_->settle();
  return *state_;
}

State& World::changing() {
  state_->leave_lanes();
  return *state_;
}

std::unique_ptr<World> new_world(const WorldSpec& spec) { return std::make_unique<World>(spec); }

void World::step() {
  State& state = changing();
  if (state.broken) throw *state.broken;
  state.begin_step();
  // With 0 substeps stepSimulation makes one step of exactly this length.
  state.world.stepSimulation(state.time_step, 0);
  check_step(state);
}

std::uint64_t World::steps() const noexcept { return state_->steps; }

}  // namespace itarl
