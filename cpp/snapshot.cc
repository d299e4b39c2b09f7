// A world's dynamic state as bytes, and back, such that the continuation has the same bits.
//
// What a step of Bullet depends on, besides how the world was built:
//   - of each body: transform, its interpolation transform (the kinematic velocity's "before"),
//     velocities, accumulated force and torque, activation state and timer;
//   - of each joint: motor targets and limits (all else is computed anew in every step), and the
//     reaction of the last step, which can be read;
//   - the contact points with their impulses, which warm starting and contact persistence use;
//   - the order of the overlapping pairs, in which contacts are found, and the order of the
//     dispatcher's manifolds, in which the solver sorts (unstably) and sweeps them;
//   - which child shapes of a compound have an algorithm, since that decides where the next
//     manifold goes in that order;
//   - the solver's random seed, if it randomises the row order.
//
// Manifolds belong to collision algorithms, and those to pairs. Restoring makes all pairs and
// algorithms anew, has each create its manifold, puts the manifolds into the saved order and
// fills in the points.
#include <BulletCollision/CollisionDispatch/btCompoundCollisionAlgorithm.h>

#include "snapshot_bytes.h"
#include "state.h"
#include "world.h"

namespace itarl {

namespace {

// Bullet has no accessors for these; a derived class may name them.
struct CompoundAlgorithm : btCompoundCollisionAlgorithm {
  static auto& children(btCompoundCollisionAlgorithm& algorithm) {
    return algorithm.*(&CompoundAlgorithm::m_childCollisionAlgorithms);
  }
  static bool is_swapped(const btCompoundCollisionAlgorithm& algorithm) {
    return algorithm.*(&CompoundAlgorithm::m_isSwapped);
  }
};

// One algorithm of a pair: all there is, or that of a compound's child.
// The children's own pairs are visited in the same order when writing and when restoring.

void write_algorithm(Writer& to, btCollisionAlgorithm& algorithm, btManifoldArray& scratch) {
  if (auto* compound = dynamic_cast<btCompoundCollisionAlgorithm*>(&algorithm)) {
    auto& children = CompoundAlgorithm::children(*compound);
    for (int i = 0; i < children.size(); ++i) {
      to.put<std::uint8_t>(children[i] != nullptr);
      if (children[i]) write_algorithm(to, *children[i], scratch);
    }
    return;
  }
  scratch.resize(0);
  algorithm.getAllContactManifolds(scratch);
  to.put(static_cast<std::uint32_t>(scratch.size()));
  for (int i = 0; i < scratch.size(); ++i) {
    to.put(static_cast<std::uint32_t>(scratch[i]->m_index1a));
  }
}

class AlgorithmReader {
 public:
  AlgorithmReader(State& state, std::uint32_t manifold_count)
      : state_(state), order_(manifold_count, nullptr) {}

  // Brings a new algorithm into the state that `from` tells.
  void restore(Reader& from, btCollisionAlgorithm& algorithm, const btCollisionObjectWrapper& a,
               const btCollisionObjectWrapper& b) {
    if (auto* compound = dynamic_cast<btCompoundCollisionAlgorithm*>(&algorithm)) {
      restore_children(from, *compound, a, b);
      return;
    }
    // Some algorithms make their manifold only now. The points that they find are replaced.
    btManifoldResult result(&a, &b);
    algorithm.processCollision(&a, &b, state_.world.getDispatchInfo(), &result);
    scratch_.resize(0);
    algorithm.getAllContactManifolds(scratch_);
    if (from.get<std::uint32_t>() != static_cast<std::uint32_t>(scratch_.size())) {
      refuse_snapshot("a pair of shapes has another number of manifolds here");
    }
    for (int i = 0; i < scratch_.size(); ++i) {
      const std::uint32_t place =
          from.get_below(static_cast<std::uint32_t>(order_.size()), "manifold");
      if (order_[place]) refuse_snapshot("its state has two manifolds in one place");
      order_[place] = scratch_[i];
    }
  }

  // Puts the dispatcher's manifolds into the saved order.
  void reorder() const {
    if (static_cast<std::size_t>(state_.dispatcher.getNumManifolds()) != order_.size()) {
      refuse_snapshot("its state has another number of manifolds");
    }
    for (const btPersistentManifold* manifold : order_) {
      if (!manifold) refuse_snapshot("its state leaves a manifold out");
    }
    btPersistentManifold** manifolds = state_.dispatcher.getInternalManifoldPointer();
    for (std::size_t i = 0; i < order_.size(); ++i) {
      manifolds[i] = order_[i];
      manifolds[i]->m_index1a = static_cast<int>(i);
    }
  }

 private:
  void restore_children(Reader& from, btCompoundCollisionAlgorithm& compound,
                        const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b) {
    const bool swapped = CompoundAlgorithm::is_swapped(compound);
    const btCollisionObjectWrapper& whole = swapped ? b : a;
    const btCollisionObjectWrapper& other = swapped ? a : b;
    const auto& shape = static_cast<const btCompoundShape&>(*whole.getCollisionShape());
    auto& children = CompoundAlgorithm::children(compound);  // all there, being new
    for (int i = 0; i < children.size(); ++i) {
      if (!from.get<std::uint8_t>()) {
        children[i]->~btCollisionAlgorithm();
        state_.dispatcher.freeCollisionAlgorithm(children[i]);
        children[i] = nullptr;
        continue;
      }
      const btTransform pose = whole.getWorldTransform() * shape.getChildTransform(i);
      const btCollisionObjectWrapper child(&whole, shape.getChildShape(i),
                                           whole.getCollisionObject(), pose, -1, i);
      restore(from, *children[i], child, other);
    }
  }

  State& state_;
  std::vector<btPersistentManifold*> order_;
  btManifoldArray scratch_;
};

void write_body(Writer& to, const btRigidBody& body) {
  to.put(body.getWorldTransform());
  to.put(body.getInterpolationWorldTransform());
  to.put(body.getInterpolationLinearVelocity());
  to.put(body.getInterpolationAngularVelocity());
  to.put(body.getLinearVelocity());
  to.put(body.getAngularVelocity());
  to.put(body.getTotalForce());
  to.put(body.getTotalTorque());
  to.put(static_cast<std::int32_t>(body.getActivationState()));
  to.put(body.getDeactivationTime());
}

void read_body(Reader& from, btRigidBody& body) {
  body.setWorldTransform(from.get_transform());
  body.setInterpolationWorldTransform(from.get_transform());
  body.setInterpolationLinearVelocity(from.get_vector_in_range());
  body.setInterpolationAngularVelocity(from.get_vector_in_range());
  body.setLinearVelocity(from.get_vector_in_range());
  body.setAngularVelocity(from.get_vector_in_range());
  body.clearForces();
  body.applyCentralForce(from.get_vector_in_range());  // 0 + f: the factors are 1
  body.applyTorque(from.get_vector_in_range());
  const auto activation = from.get<std::int32_t>();
  if (activation < ACTIVE_TAG || activation > DISABLE_SIMULATION) {
    refuse_snapshot("its state holds an unknown activation state");
  }
  body.forceActivationState(activation);
  body.setDeactivationTime(from.get_finite());
  body.updateInertiaTensor();
}

// Motors, in Bullet's own signs and units.
void write_joint(Writer& to, const JointEntry& entry) {
  switch (entry.kind) {
    case JointKind::Hinge: {
      auto& hinge = static_cast<btHingeConstraint&>(*entry.joint);
      to.put(hinge.getMotorTargetVelocity());
      to.put(hinge.getMaxMotorImpulse());
      break;
    }
    case JointKind::Slider: {
      auto& slider = static_cast<btSliderConstraint&>(*entry.joint);
      to.put(slider.getTargetLinMotorVelocity());
      to.put(slider.getMaxLinMotorForce());
      to.put(slider.getTargetAngMotorVelocity());
      to.put(slider.getMaxAngMotorForce());
      break;
    }
    case JointKind::SixDofSpring: {
      auto& joint = static_cast<btGeneric6DofSpring2Constraint&>(*entry.joint);
      const btTranslationalLimitMotor2& linear = *joint.getTranslationalLimitMotor();
      to.put(linear.m_targetVelocity);
      to.put(linear.m_maxMotorForce);
      for (int i = 0; i < 3; ++i) {
        to.put(joint.getRotationalLimitMotor(i)->m_targetVelocity);
        to.put(joint.getRotationalLimitMotor(i)->m_maxMotorForce);
      }
      break;
    }
    default:
      break;
  }
  to.put(entry.feedback.m_appliedForceBodyB);
  to.put(entry.feedback.m_appliedTorqueBodyB);
}

void read_joint(Reader& from, JointEntry& entry) {
  entry.joint->setEnabled(true);  // Bullet switches one off whose impulse overflowed
  switch (entry.kind) {
    case JointKind::Hinge: {
      auto& hinge = static_cast<btHingeConstraint&>(*entry.joint);
      hinge.setMotorTargetVelocity(from.get_finite());
      hinge.setMaxMotorImpulse(from.get_finite());
      break;
    }
    case JointKind::Slider: {
      auto& slider = static_cast<btSliderConstraint&>(*entry.joint);
      slider.setTargetLinMotorVelocity(from.get_finite());
      slider.setMaxLinMotorForce(from.get_finite());
      slider.setTargetAngMotorVelocity(from.get_finite());
      slider.setMaxAngMotorForce(from.get_finite());
      break;
    }
    case JointKind::SixDofSpring: {
      auto& joint = static_cast<btGeneric6DofSpring2Constraint&>(*entry.joint);
      btTranslationalLimitMotor2& linear = *joint.getTranslationalLimitMotor();
      linear.m_targetVelocity = from.get_vector();
      linear.m_maxMotorForce = from.get_vector();
      for (int i = 0; i < 3; ++i) {
        joint.getRotationalLimitMotor(i)->m_targetVelocity = from.get_finite();
        joint.getRotationalLimitMotor(i)->m_maxMotorForce = from.get_finite();
      }
      break;
    }
    default:
      break;
  }
  entry.feedback.m_appliedForceBodyB = from.get_vector();
  entry.feedback.m_appliedTorqueBodyB = from.get_vector();
  entry.motors = MotorState{};
}

void write_point(Writer& to, const btManifoldPoint& point) {
  to.put(point.m_localPointA);
  to.put(point.m_localPointB);
  to.put(point.m_positionWorldOnA);
  to.put(point.m_positionWorldOnB);
  to.put(point.m_normalWorldOnB);
  to.put(point.m_lateralFrictionDir1);
  to.put(point.m_lateralFrictionDir2);
  for (btScalar value :
       {point.m_distance1, point.m_combinedFriction, point.m_combinedRollingFriction,
        point.m_combinedSpinningFriction, point.m_combinedRestitution, point.m_appliedImpulse,
        point.m_prevRHS, point.m_appliedImpulseLateral1, point.m_appliedImpulseLateral2,
        point.m_contactMotion1, point.m_contactMotion2, point.m_contactCFM, point.m_contactERP,
        point.m_frictionCFM}) {
    to.put(value);
  }
  for (int value : {point.m_partId0, point.m_partId1, point.m_index0, point.m_index1,
                    point.m_contactPointFlags, point.m_lifeTime}) {
    to.put(static_cast<std::int32_t>(value));
  }
}

btManifoldPoint read_point(Reader& from) {
  const btVector3 zero(0, 0, 0);
  btManifoldPoint point(zero, zero, zero, 0);
  for (btVector3* vector :
       {&point.m_localPointA, &point.m_localPointB, &point.m_positionWorldOnA,
        &point.m_positionWorldOnB, &point.m_normalWorldOnB, &point.m_lateralFrictionDir1,
        &point.m_lateralFrictionDir2}) {
    *vector = from.get_vector();
  }
  for (btScalar* value :
       {&point.m_distance1, &point.m_combinedFriction, &point.m_combinedRollingFriction,
        &point.m_combinedSpinningFriction, &point.m_combinedRestitution, &point.m_appliedImpulse,
        &point.m_prevRHS, &point.m_appliedImpulseLateral1, &point.m_appliedImpulseLateral2,
        &point.m_contactMotion1, &point.m_contactMotion2, &point.m_contactCFM,
        &point.m_contactERP, &point.m_frictionCFM}) {
    *value = from.get_finite();
  }
  for (int* value : {&point.m_partId0, &point.m_partId1, &point.m_index0, &point.m_index1,
                     &point.m_contactPointFlags, &point.m_lifeTime}) {
    *value = from.get<std::int32_t>();
  }
  return point;
}

void write_pairs(Writer& to, State& state) {
  const btBroadphasePairArray& pairs =
      state.broadphase.getOverlappingPairCache()->getOverlappingPairArray();
  to.put(static_cast<std::uint32_t>(state.dispatcher.getNumManifolds()));
  to.put(static_cast<std::uint32_t>(pairs.size()));
  btManifoldArray scratch;
  for (int i = 0; i < pairs.size(); ++i) {
    for (const btBroadphaseProxy* proxy : {pairs[i].m_pProxy0, pairs[i].m_pProxy1}) {
      to.put(slot_of(*static_cast<const btCollisionObject*>(proxy->m_clientObject)));
    }
    to.put<std::uint8_t>(pairs[i].m_algorithm != nullptr);
    if (pairs[i].m_algorithm) write_algorithm(to, *pairs[i].m_algorithm, scratch);
  }
}

void remove_all_pairs(State& state) {
  btOverlappingPairCache& cache = *state.broadphase.getOverlappingPairCache();
  while (cache.getNumOverlappingPairs() > 0) {
    const btBroadphasePair& last =
        cache.getOverlappingPairArray()[cache.getNumOverlappingPairs() - 1];
    cache.removeOverlappingPair(last.m_pProxy0, last.m_pProxy1, &state.dispatcher);
  }
}

// Some algorithms make no manifold for two bodies that sleep, which weren't asleep when their
// manifold was made. While this lives, none is.
class AllAwake {
 public:
  explicit AllAwake(State& state) {
    for (const auto& entry : state.bodies) {
      if (!entry) continue;
      was_.emplace_back(entry->body.get(), entry->body->getActivationState());
      entry->body->forceActivationState(ACTIVE_TAG);
    }
  }
  ~AllAwake() {
    for (const auto& [body, activation] : was_) body->forceActivationState(activation);
  }
  AllAwake(const AllAwake&) = delete;
  AllAwake& operator=(const AllAwake&) = delete;

 private:
  std::vector<std::pair<btRigidBody*, int>> was_;
};

void read_pairs(Reader& from, State& state) {
  remove_all_pairs(state);
  const auto manifold_count = from.get<std::uint32_t>();
  const auto pair_count = from.get<std::uint32_t>();
  // Each takes at least four bytes: don't let a wrong count ask for memory that isn't there.
  if (manifold_count > from.left() / 4) refuse_snapshot("its state ends early");
  AlgorithmReader algorithms(state, manifold_count);
  btOverlappingPairCache& cache = *state.broadphase.getOverlappingPairCache();
  const auto slots = static_cast<std::uint32_t>(state.bodies.size());
  for (std::uint32_t i = 0; i < pair_count; ++i) {
    btRigidBody* body[2];
    for (btRigidBody*& end : body) {
      const auto& entry = state.bodies[from.get_below(slots, "body")];
      if (!entry) refuse_snapshot("its state names a body that was removed");
      end = entry->body.get();
    }
    btBroadphasePair* pair =
        body[0] == body[1] ? nullptr
                           : cache.addOverlappingPair(body[0]->getBroadphaseProxy(),
                                                      body[1]->getBroadphaseProxy());
    if (!pair || cache.getNumOverlappingPairs() != int(i + 1)) {
      refuse_snapshot("its state holds a pair of bodies that can't be");
    }
    if (!from.get<std::uint8_t>()) continue;
    // The cache orders the two by their ids; Bullet's near callback does what follows.
    auto* first = static_cast<btCollisionObject*>(pair->m_pProxy0->m_clientObject);
    auto* second = static_cast<btCollisionObject*>(pair->m_pProxy1->m_clientObject);
    const btCollisionObjectWrapper a(nullptr, first->getCollisionShape(), first,
                                     first->getWorldTransform(), -1, -1);
    const btCollisionObjectWrapper b(nullptr, second->getCollisionShape(), second,
                                     second->getWorldTransform(), -1, -1);
    pair->m_algorithm =
        state.dispatcher.findAlgorithm(&a, &b, nullptr, BT_CONTACT_POINT_ALGORITHMS);
    algorithms.restore(from, *pair->m_algorithm, a, b);
  }
  algorithms.reorder();
}

void write_manifolds(Writer& to, State& state) {
  for (int i = 0; i < state.dispatcher.getNumManifolds(); ++i) {
    const btPersistentManifold& manifold = *state.dispatcher.getManifoldByIndexInternal(i);
    to.put(static_cast<std::uint32_t>(manifold.getNumContacts()));
    for (int k = 0; k < manifold.getNumContacts(); ++k) write_point(to, manifold.getContactPoint(k));
  }
}

void read_manifolds(Reader& from, State& state) {
  for (int i = 0; i < state.dispatcher.getNumManifolds(); ++i) {
    btPersistentManifold& manifold = *state.dispatcher.getManifoldByIndexInternal(i);
    const std::uint32_t count = from.get_below(MANIFOLD_CACHE_SIZE + 1, "contact point");
    manifold.setNumContacts(0);
    for (std::uint32_t k = 0; k < count; ++k) {
      const btManifoldPoint point = read_point(from);
      manifold.setNumContacts(static_cast<int>(k + 1));
      manifold.getContactPoint(static_cast<int>(k)) = point;
    }
  }
}

}  // namespace

rust::Slice<const std::uint8_t> World::encode_state() {
  state_->settle();
  State& state = *state_;
  if (state.broken) throw *state.broken;
  Writer to(state.snapshot);
  to.put(state.steps);
  to.put(static_cast<std::uint64_t>(state.solver.getRandSeed()));
  for (const auto& entry : state.bodies) {
    if (entry) write_body(to, *entry->body);
  }
  for (const auto& entry : state.joints) {
    if (entry) write_joint(to, *entry);
  }
  write_pairs(to, state);
  write_manifolds(to, state);
  return {state.snapshot.data(), state.snapshot.size()};
}

void World::decode_state(rust::Slice<const std::uint8_t> bytes) {
  State& state = changing();
  try {
    Reader from(bytes);
    state.steps = from.get<std::uint64_t>();
    state.solver.setRandSeed(from.get<std::uint64_t>());
    for (const auto& entry : state.bodies) {
      if (entry) read_body(from, *entry->body);
    }
    for (const auto& entry : state.joints) {
      if (entry) read_joint(from, *entry);
    }
    {
      const AllAwake awake(state);
      read_pairs(from, state);
    }
    read_manifolds(from, state);
    if (from.left() != 0) refuse_snapshot("its state is followed by something else");
  } catch (const Refusal& refusal) {
    // Half of it may be in force: no going on from here but by another restore.
    state.broken = refusal;
    throw;
  } catch (...) {
    state.broken = Refusal('S', {"restoring ended early"});
    throw;
  }
  state.broken.reset();
}

}  // namespace itarl
