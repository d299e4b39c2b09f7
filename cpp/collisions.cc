// Bullet's collision detection, but for what can't change anything.
#include <btBulletDynamicsCommon.h>

#include "broadphase.h"
#include "pausing.h"

namespace itarl {

namespace {

// How far from its origin a shape goes at most.
btScalar reach_of(const btCollisionShape& shape) {
  if (shape.getShapeType() == CAPSULE_SHAPE_PROXYTYPE) {
    const auto& capsule = static_cast<const btCapsuleShape&>(shape);
    return capsule.getHalfHeight() + capsule.getRadius();
  }
  btScalar reach = 0;
  if (shape.isCompound()) {
    const auto& compound = static_cast<const btCompoundShape&>(shape);
    for (int i = 0; i < compound.getNumChildShapes(); ++i) {
      const btScalar offset = compound.getChildTransform(i).getOrigin().length();
      reach = btMax(reach, offset + reach_of(*compound.getChildShape(i)));
    }
    return reach;
  }
  btVector3 centre;
  shape.getBoundingSphere(centre, reach);
  return reach + centre.length();
}

// How far above a plane the lowest point of a shape is, at least. `up` is the plane's normal in the
// shape's frame, `height` that of the shape's origin.
btScalar lowest_of(const btCollisionShape& shape, const btVector3& up, btScalar height) {
  if (shape.getShapeType() == CAPSULE_SHAPE_PROXYTYPE) {
    const auto& capsule = static_cast<const btCapsuleShape&>(shape);
    return height - btFabs(up[capsule.getUpAxis()]) * capsule.getHalfHeight() - capsule.getRadius();
  }
  if (!shape.isCompound()) return height - reach_of(shape);
  const auto& compound = static_cast<const btCompoundShape&>(shape);
  btScalar lowest = height;
  for (int i = 0; i < compound.getNumChildShapes(); ++i) {
    const btTransform& child = compound.getChildTransform(i);
    lowest = btMin(lowest, lowest_of(*compound.getChildShape(i), up * child.getBasis(),
                                     height + up.dot(child.getOrigin())));
  }
  return lowest;
}

}  // namespace

btBroadphaseProxy* Broadphase::createProxy(const btVector3& lower, const btVector3& upper,
                                           int shape_type, void* object, int group, int mask,
                                           btDispatcher* dispatcher) {
  is_known_ = false;
  return btSimpleBroadphase::createProxy(lower, upper, shape_type, object, group, mask, dispatcher);
}

void Broadphase::destroyProxy(btBroadphaseProxy* proxy, btDispatcher* dispatcher) {
  is_known_ = false;
  btSimpleBroadphase::destroyProxy(proxy, dispatcher);
}

void Broadphase::study() {
  if (is_known_) return;
  pairs_.clear();
  all_with_planes_ = true;
  int last = -1;
  for (int i = 0; i <= m_LastHandleIndex; ++i) {
    if (m_pHandles[i].m_clientObject != nullptr) last = i;
  }
  m_LastHandleIndex = last;
  info_.assign(std::size_t(last + 1), Info{});
  for (int i = 0; i <= last; ++i) {
    const auto* const object = static_cast<btCollisionObject*>(m_pHandles[i].m_clientObject);
    if (object == nullptr) continue;
    Info& info = info_[std::size_t(i)];
    info.is_plane = object->getCollisionShape()->getShapeType() == STATIC_PLANE_PROXYTYPE;
    if (info.is_plane) continue;
    info.reach = reach_of(*object->getCollisionShape());
  }
  for (int i = 0; i <= last; ++i) {
    btSimpleBroadphaseProxy* const a = &m_pHandles[i];
    if (a->m_clientObject == nullptr) continue;
    for (int j = i + 1; j <= last; ++j) {
      btSimpleBroadphaseProxy* const b = &m_pHandles[j];
      if (b->m_clientObject == nullptr) continue;
      const bool collide = (a->m_collisionFilterGroup & b->m_collisionFilterMask) != 0 &&
                           (b->m_collisionFilterGroup & a->m_collisionFilterMask) != 0;
      if (!collide) continue;
      pairs_.emplace_back(a, b);
      Info &one = info_[std::size_t(i)], &other = info_[std::size_t(j)];
      if (one.is_plane || other.is_plane) continue;
      all_with_planes_ = false;
      one.needs_box = other.needs_box = true;
    }
  }
  is_known_ = true;
}

void Broadphase::calculateOverlappingPairs(btDispatcher* dispatcher) {
  if (only_meets_planes()) return;  // all that's in the cache is among the pairs
  for (const auto& [a, b] : pairs_) {
    const bool known = m_pairCache->findPair(a, b) != nullptr;
    const bool overlap = aabbOverlap(a, b);
    if (overlap && !known) m_pairCache->addOverlappingPair(a, b);
    if (!overlap && known) m_pairCache->removeOverlappingPair(a, b, dispatcher);
  }
}

// predictUnconstraintMotion, but for damping by factors of 1, which are powers that take time, and
// for where a body will be: Bullet asks for that to make boxes alone, and then moves the body for
// good. (A body that sleeps stays where it is; the prediction then stays, too.)
void PausingWorld::predict_motion(btScalar time_step) {
  for (int i = 0; i < m_nonStaticRigidBodies.size(); ++i) {
    btRigidBody& body = *m_nonStaticRigidBodies[i];
    if (body.isStaticOrKinematicObject()) continue;
    if (body.getLinearDamping() != 0 || body.getAngularDamping() != 0) body.applyDamping(time_step);
    if (needs_box(body)) {
      body.predictIntegratedTransform(time_step, body.getInterpolationWorldTransform());
    }
  }
}

bool PausingWorld::needs_box(const btCollisionObject& object) {
  return object.getActivationState() != DISABLE_DEACTIVATION || object.isKinematicObject() ||
         broadphase_.needs_box(*object.getBroadphaseHandle());
}

// performDiscreteCollisionDetection
void PausingWorld::find_contacts() {
  for (int i = 0; i < m_collisionObjects.size(); ++i) {
    if (needs_box(*m_collisionObjects[i])) updateSingleAabb(m_collisionObjects[i]);
  }
  computeOverlappingPairs();
  // Bullet's near callback removes no pair.
  btBroadphasePairArray& pairs = broadphase_.getOverlappingPairCache()->getOverlappingPairArray();
  for (int i = 0; i < pairs.size(); ++i) {
    if (!stays_apart(pairs[i])) {
      btCollisionDispatcher::defaultNearCallback(pairs[i], dispatcher_, getDispatchInfo());
    }
  }
}

// Whether a body without contact points is so high above a plane that none is found: by more than
// its lowest point, and the distance at which points are found, and what rounding may do.
bool PausingWorld::stays_apart(const btBroadphasePair& pair) {
  const bool first_is_plane = broadphase_.is_plane(*pair.m_pProxy0);
  if (pair.m_algorithm == nullptr || first_is_plane == broadphase_.is_plane(*pair.m_pProxy1)) {
    return false;
  }
  const btBroadphaseProxy* const above = first_is_plane ? pair.m_pProxy1 : pair.m_pProxy0;
  const btBroadphaseProxy* const below = first_is_plane ? pair.m_pProxy0 : pair.m_pProxy1;
  const auto& plane = *static_cast<const btCollisionObject*>(below->m_clientObject);
  const auto& body = *static_cast<const btCollisionObject*>(above->m_clientObject);
  const auto& shape = static_cast<const btStaticPlaneShape&>(*plane.getCollisionShape());
  const btTransform& pose = body.getWorldTransform();
  const btVector3 normal = plane.getWorldTransform().getBasis() * shape.getPlaneNormal();
  const btVector3 from_plane = pose.getOrigin() - plane.getWorldTransform().getOrigin();
  const btScalar height = normal.dot(from_plane) - shape.getPlaneConstant();
  const btScalar reach = broadphase_.reach(*above);
  const btScalar sizes =
      pose.getOrigin().length() + from_plane.length() + btFabs(shape.getPlaneConstant());
  // Contact points are found within 0.02 of an object's size, which isn't twice what it reaches.
  const btScalar margin = btScalar(0.05) * reach + btScalar(1e-3) * sizes;
  if (!(height > reach + margin) &&
      !(lowest_of(*body.getCollisionShape(), normal * pose.getBasis(), height) > margin)) {
    return false;
  }
  found_.resize(0);
  pair.m_algorithm->getAllContactManifolds(found_);
  for (int i = 0; i < found_.size(); ++i) {
    if (found_[i]->getNumContacts() > 0) return false;
  }
  return true;
}

}  // namespace itarl
