#include "lockstep/plane_pairs.h"

#include <algorithm>
#include <cstring>

#include "state.h"

namespace itarl::lockstep {

namespace {

const btStaticPlaneShape& plane_of(const PlanePair& pair) {
  return static_cast<const btStaticPlaneShape&>(*pair.manifold->getBody1()->getCollisionShape());
}

// The one shape that a body has.
const btCollisionShape& shape_of(const PlanePair& pair) {
  const btCollisionShape& whole = *pair.rigid->getCollisionShape();
  if (!pair.in_compound) return whole;
  return *static_cast<const btCompoundShape&>(whole).getChildShape(0);
}

bool is_same(const btVector3& a, const btVector3& b) {
  return std::memcmp(a.m_floats, b.m_floats, 3 * sizeof(btScalar)) == 0;
}

// Fills in what the shape is; false if lanes don't know it.
bool read_shape(PlanePair& pair) {
  const btCollisionShape& whole = *pair.rigid->getCollisionShape();
  pair.in_compound = whole.isCompound();
  if (pair.in_compound) {
    const auto& compound = static_cast<const btCompoundShape&>(whole);
    if (compound.getNumChildShapes() != 1 || compound.getDynamicAabbTree() != nullptr) return false;
  }
  const btCollisionShape& shape = shape_of(pair);
  pair.up = 0;
  switch (shape.getShapeType()) {
    case BOX_SHAPE_PROXYTYPE:
      pair.shape = PairShape::Box;
      return true;
    case SPHERE_SHAPE_PROXYTYPE:
      pair.shape = PairShape::Capsule;
      return true;
    case CAPSULE_SHAPE_PROXYTYPE:
      pair.shape = PairShape::Capsule;
      pair.up = std::uint8_t(static_cast<const btCapsuleShape&>(shape).getUpAxis());
      return true;
    default:
      return false;
  }
}

// A point as Bullet makes it between the two, but for where it is.
btManifoldPoint new_point(const PlanePair& pair) {
  const btCollisionObject &a = *pair.manifold->getBody0(), &b = *pair.manifold->getBody1();
  const btVector3 up = b.getWorldTransform().getBasis() * plane_of(pair).getPlaneNormal();
  btManifoldPoint point(btVector3(0, 0, 0), btVector3(0, 0, 0), up, 0);
  point.m_combinedFriction = btManifoldResult::calculateCombinedFriction(&a, &b);
  point.m_combinedRestitution = btManifoldResult::calculateCombinedRestitution(&a, &b);
  point.m_combinedRollingFriction = btManifoldResult::calculateCombinedRollingFriction(&a, &b);
  point.m_combinedSpinningFriction = btManifoldResult::calculateCombinedSpinningFriction(&a, &b);
  btPlaneSpace1(up, point.m_lateralFrictionDir1, point.m_lateralFrictionDir2);
  point.m_partId0 = point.m_partId1 = point.m_index0 = point.m_index1 = -1;
  if (pair.in_compound) point.m_index0 = 0;
  return point;
}

// Whether a point is one that lanes could have made.
bool is_usual(const btManifoldPoint& point, const btManifoldPoint& usual) {
  const auto numbers = [](const btManifoldPoint& of) {
    return std::array{of.m_combinedFriction, of.m_combinedRollingFriction,
                      of.m_combinedSpinningFriction, of.m_combinedRestitution, of.m_prevRHS,
                      of.m_appliedImpulseLateral2, of.m_contactMotion1, of.m_contactMotion2,
                      of.m_contactCFM, of.m_contactERP, of.m_frictionCFM};
  };
  const auto words = [](const btManifoldPoint& of) {
    return std::array{of.m_partId0, of.m_partId1, of.m_index0, of.m_index1, of.m_contactPointFlags};
  };
  return numbers(point) == numbers(usual) && words(point) == words(usual) &&
         is_same(point.m_normalWorldOnB, usual.m_normalWorldOnB) &&
         is_same(point.m_lateralFrictionDir2, usual.m_lateralFrictionDir2) &&
         point.m_userPersistentData == nullptr && point.m_lifeTime >= 0;
}

// False if lanes can't go on with the pair.
bool read_pair(const btBroadphasePair& from, btManifoldArray& scratch, PlanePair& pair) {
  if (from.m_algorithm == nullptr) return false;
  scratch.resize(0);
  from.m_algorithm->getAllContactManifolds(scratch);
  if (scratch.size() != 1) return false;
  pair.manifold = scratch[0];
  pair.rigid = const_cast<btRigidBody*>(btRigidBody::upcast(pair.manifold->getBody0()));
  const btCollisionObject& plane = *pair.manifold->getBody1();
  const bool known = pair.rigid != nullptr && !pair.rigid->isStaticOrKinematicObject() &&
                     plane.isStaticObject() &&
                     plane.getCollisionShape()->getShapeType() == STATIC_PLANE_PROXYTYPE;
  if (!known || !read_shape(pair)) return false;
  if (pair.manifold->getContactProcessingThreshold() <
      pair.manifold->getContactBreakingThreshold()) {
    return false;
  }
  const btManifoldPoint usual = new_point(pair);
  if (usual.m_combinedRollingFriction > 0) return false;
  for (int i = 0; i < pair.manifold->getNumContacts(); ++i) {
    if (!is_usual(pair.manifold->getContactPoint(i), usual)) return false;
  }
  return true;
}

}  // namespace

bool list_pairs(State& state, const std::vector<std::uint32_t>& dynamic_ids,
                std::vector<PlanePair>& out) {
  out.clear();
  if (!state.broadphase.only_meets_planes()) return false;
  const btBroadphasePairArray& pairs =
      state.broadphase.getOverlappingPairCache()->getOverlappingPairArray();
  btManifoldArray scratch;
  for (int i = 0; i < pairs.size(); ++i) {
    const auto& a = *static_cast<btCollisionObject*>(pairs[i].m_pProxy0->m_clientObject);
    const auto& b = *static_cast<btCollisionObject*>(pairs[i].m_pProxy1->m_clientObject);
    if (!state.dispatcher.needsCollision(&a, &b)) {
      if (pairs[i].m_algorithm != nullptr) return false;
      continue;
    }
    PlanePair pair{};
    if (!read_pair(pairs[i], scratch, pair)) return false;
    pair.body = dynamic_ids[slot_of(*pair.rigid)];
    out.push_back(pair);
  }
  if (std::size_t(state.dispatcher.getNumManifolds()) != out.size()) return false;
  std::sort(out.begin(), out.end(),
            [](const PlanePair& a, const PlanePair& b) { return a.body < b.body; });
  // In what order a body's contacts with two planes come is Bullet's to say.
  const auto twice = std::adjacent_find(
      out.begin(), out.end(),
      [](const PlanePair& a, const PlanePair& b) { return a.body == b.body; });
  return twice == out.end();
}

namespace {

void put_three(Scalar* to, std::size_t width, std::uint32_t place, const btVector3& v) {
  for (std::uint32_t i = 0; i < 3; ++i) to[(place + i) * width] = v[int(i)];
}

void put_pose(Scalar* to, std::size_t width, std::uint32_t place, const btTransform& pose) {
  for (std::uint32_t row = 0; row < 3; ++row) {
    put_three(to, width, place + 3 * row, pose.getBasis()[int(row)]);
  }
  put_three(to, width, place + 9, pose.getOrigin());
}

btVector3 get_three(const Scalar* from, std::size_t width, std::uint32_t place) {
  return {from[place * width], from[(place + 1) * width], from[(place + 2) * width]};
}

}  // namespace

void put_pair(const PlanePair& pair, Scalar* to, std::size_t width) {
  const btManifoldPoint point = new_point(pair);
  const btTransform& plane = pair.manifold->getBody1()->getWorldTransform();
  put_pose(to, width, kPlanePose, plane);
  put_three(to, width, kPlaneAway, plane.inverse().getOrigin());
  put_three(to, width, kPlaneNormal, plane_of(pair).getPlaneNormal());
  to[kPlaneConstant * width] = plane_of(pair).getPlaneConstant();
  put_three(to, width, kPlaneUp, point.m_normalWorldOnB);
  put_three(to, width, kPlaneAlong, point.m_lateralFrictionDir1);
  put_pose(to, width, kShapeFrame,
           pair.in_compound ? static_cast<const btCompoundShape*>(pair.rigid->getCollisionShape())
                                  ->getChildTransform(0)
                            : btTransform::getIdentity());
  const btCollisionShape& shape = shape_of(pair);
  btVector3 half(0, 0, 0);
  btScalar height = 0;
  if (pair.shape == PairShape::Box) {
    const btScalar margin = shape.getMargin();
    half = static_cast<const btBoxShape&>(shape).getHalfExtentsWithoutMargin();
    half += btVector3(margin, margin, margin);
  } else if (shape.getShapeType() == CAPSULE_SHAPE_PROXYTYPE) {
    height = static_cast<const btCapsuleShape&>(shape).getHalfHeight();
  }
  put_three(to, width, kHalfExtents, half);
  to[kHalfHeight * width] = height;
  to[kMargin * width] = shape.getMargin();
  to[kBreaking * width] = pair.manifold->getContactBreakingThreshold();
  to[kPairFriction * width] = point.m_combinedFriction;
  to[kPairRestitution * width] = point.m_combinedRestitution;
}

void take_points(const PlanePair& pair, Scalar* to, std::size_t width) {
  const int count = pair.manifold->getNumContacts();
  to[0] = Scalar(count);
  for (int i = 0; i < kMostPoints; ++i) {
    Scalar* const numbers = to + (1 + std::uint32_t(i) * kPointNumbers) * width;
    const btManifoldPoint none(btVector3(0, 0, 0), btVector3(0, 0, 0), btVector3(0, 0, 0), 0);
    const btManifoldPoint& point = i < count ? pair.manifold->getContactPoint(i) : none;
    put_three(numbers, width, kLocalA, point.m_localPointA);
    put_three(numbers, width, kLocalB, point.m_localPointB);
    put_three(numbers, width, kWorldA, point.m_positionWorldOnA);
    put_three(numbers, width, kWorldB, point.m_positionWorldOnB);
    put_three(numbers, width, kDirection, point.m_lateralFrictionDir1);
    numbers[kDistance * width] = point.m_distance1;
    numbers[kImpulse * width] = point.m_appliedImpulse;
    numbers[kLateral * width] = point.m_appliedImpulseLateral1;
    const auto life = std::uint32_t(point.m_lifeTime);
    numbers[kLife * width] = Scalar(life % kLifeUnit);
    numbers[kLifeUnits * width] = Scalar(life / kLifeUnit);
  }
}

void put_points(const PlanePair& pair, const Scalar* from, std::size_t width) {
  const int count = int(from[0]);
  pair.manifold->setNumContacts(count);
  for (int i = 0; i < count; ++i) {
    const Scalar* const numbers = from + (1 + std::uint32_t(i) * kPointNumbers) * width;
    btManifoldPoint& point = pair.manifold->getContactPoint(i);
    point = new_point(pair);
    point.m_localPointA = get_three(numbers, width, kLocalA);
    point.m_localPointB = get_three(numbers, width, kLocalB);
    point.m_positionWorldOnA = get_three(numbers, width, kWorldA);
    point.m_positionWorldOnB = get_three(numbers, width, kWorldB);
    point.m_lateralFrictionDir1 = get_three(numbers, width, kDirection);
    point.m_distance1 = numbers[kDistance * width];
    point.m_appliedImpulse = numbers[kImpulse * width];
    point.m_appliedImpulseLateral1 = numbers[kLateral * width];
    point.m_lifeTime = int(std::uint32_t(numbers[kLife * width]) +
                           kLifeUnit * std::uint32_t(numbers[kLifeUnits * width]));
  }
}

}  // namespace itarl::lockstep
