// The overlapping pairs of bounding boxes.
#pragma once

#include <BulletCollision/BroadphaseCollision/btSimpleBroadphase.h>

#include <cstddef>
#include <utility>
#include <vector>

namespace itarl {

// Not btDbvtBroadphase, Bullet's usual one: with its grown boxes and its tree of them, which pairs
// it holds depends on the past, and a snapshot would have to bring all that back. This one's only
// memory is the order of the pairs; for one robot it's as quick.
//
// Bullet's own compares all boxes and asks the cache for each pair of bodies whether it has it. Most
// are parts of one robot, which never collide and are never in the cache: they are passed over. And
// a plane's box is endless: what can only meet planes always overlaps, and needs no box.
class Broadphase final : public btSimpleBroadphase {
 public:
  explicit Broadphase(int most_bodies) : btSimpleBroadphase(most_bodies) {}

  btBroadphaseProxy* createProxy(const btVector3& lower, const btVector3& upper, int shape_type,
                                 void* object, int group, int mask,
                                 btDispatcher* dispatcher) override;
  void destroyProxy(btBroadphaseProxy* proxy, btDispatcher* dispatcher) override;
  void calculateOverlappingPairs(btDispatcher* dispatcher) override;

  // Whether a body could meet another that isn't a plane.
  bool needs_box(const btBroadphaseProxy& proxy) { return info_of(proxy).needs_box; }
  bool is_plane(const btBroadphaseProxy& proxy) { return info_of(proxy).is_plane; }
  // Whether all that could ever meet does, and one of each two is a plane.
  bool only_meets_planes() {
    study();
    return all_with_planes_ && m_pairCache->getNumOverlappingPairs() == int(pairs_.size());
  }
  // How far from its body's origin a shape goes at most; nothing of a plane.
  btScalar reach(const btBroadphaseProxy& proxy) { return info_of(proxy).reach; }

 private:
  struct Info {
    bool is_plane = false;
    bool needs_box = false;
    btScalar reach = 0;
  };
  // Brings what follows up to date with the bodies that there are.
  void study();
  const Info& info_of(const btBroadphaseProxy& proxy) {
    study();
    return info_[std::size_t(static_cast<const btSimpleBroadphaseProxy*>(&proxy) - m_pHandles)];
  }

  bool is_known_ = false;
  std::vector<Info> info_;  // by handle
  // What may collide, in Bullet's order; and whether one of each pair is a plane.
  std::vector<std::pair<btSimpleBroadphaseProxy*, btSimpleBroadphaseProxy*>> pairs_;
  bool all_with_planes_ = false;
};

}  // namespace itarl
