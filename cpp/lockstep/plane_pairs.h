// Bodies and the planes that they may meet, whose contacts lanes can find (contacts.inc).
#pragma once

#include <btBulletDynamicsCommon.h>

#include <cstdint>
#include <vector>

#include "lockstep/tasks.h"

namespace itarl {
struct State;
}

namespace itarl::lockstep {

// One of a world.
struct PlanePair {
  std::uint32_t body;  // among those that move
  btRigidBody* rigid;
  btPersistentManifold* manifold;
  PairShape shape;
  std::uint8_t up;
  bool in_compound;

  bool is_like(const PlanePair& other) const {
    return body == other.body && shape == other.shape && up == other.up &&
           in_compound == other.in_compound;
  }
};

// All pairs of a world that was stepped by Bullet, in the order of the bodies; false if there may be
// contacts that lanes can't find, or points that they can't go on with.
bool list_pairs(State& state, const std::vector<std::uint32_t>& dynamic_ids,
                std::vector<PlanePair>& out);

// What doesn't change of a pair: kPairNumbers, `width` apart.
void put_pair(const PlanePair& pair, Scalar* to, std::size_t width);
// Its points, from Bullet's manifold (kManifoldNumbers) and back.
void take_points(const PlanePair& pair, Scalar* to, std::size_t width);
void put_points(const PlanePair& pair, const Scalar* from, std::size_t width);

}  // namespace itarl::lockstep
