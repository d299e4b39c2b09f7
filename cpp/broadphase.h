// The overlapping pairs of bounding boxes.
#pragma once

#include <BulletCollision/BroadphaseCollision/btSimpleBroadphase.h>

namespace itarl {

// Not btDbvtBroadphase, Bullet's usual one: with its grown boxes and its tree of them, which pairs
// it holds depends on the past, and a snapshot would have to bring all that back. This one's only
// memory is the order of the pairs; for one robot it's as quick.
//
// Bullet's own compares all boxes and asks the cache for each pair of bodies whether it has it. Most
// are parts of one robot, which never collide and are never in the cache: they are passed over.
class Broadphase final : public btSimpleBroadphase {
 public:
  explicit Broadphase(int most_bodies) : btSimpleBroadphase(most_bodies) {}

  void calculateOverlappingPairs(btDispatcher* dispatcher) override {
    int last = -1;
    for (int i = 0; i <= m_LastHandleIndex; ++i) {
      btSimpleBroadphaseProxy* const a = &m_pHandles[i];
      if (a->m_clientObject == nullptr) continue;
      last = i;
      for (int j = i + 1; j <= m_LastHandleIndex; ++j) {
        btSimpleBroadphaseProxy* const b = &m_pHandles[j];
        if (b->m_clientObject == nullptr) continue;
        const bool collide = (a->m_collisionFilterGroup & b->m_collisionFilterMask) != 0 &&
                             (b->m_collisionFilterGroup & a->m_collisionFilterMask) != 0;
        if (!collide) continue;
        const bool known = m_pairCache->findPair(a, b) != nullptr;
        const bool overlap = aabbOverlap(a, b);
        if (overlap && !known) m_pairCache->addOverlappingPair(a, b);
        if (!overlap && known) m_pairCache->removeOverlappingPair(a, b, dispatcher);
      }
    }
    m_LastHandleIndex = last;
  }
};

}  // namespace itarl
