// Bodies' numbers, from Bullet's objects and back.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <cstddef>

#include "lockstep/tasks.h"

namespace itarl::lockstep {

// Where a body is and how fast, once it has moved: numbers lie `width` apart.
inline void put_body(btRigidBody& to, const Scalar* from, std::size_t width) {
  const auto three = [&](std::uint32_t place) {
    return btVector3(from[place * width], from[(place + 1) * width], from[(place + 2) * width]);
  };
  btTransform& pose = to.getWorldTransform();
  // Bullet lets nobody set this; it would work it out once more.
  auto& inertia = const_cast<btMatrix3x3&>(to.getInvInertiaTensorWorld());
  for (std::uint32_t row = 0; row < 3; ++row) {
    pose.getBasis()[int(row)] = three(kPose + 3 * row);
    inertia[int(row)] = three(kInertia + 3 * row);
  }
  pose.setOrigin(three(kPose + 9));
  to.getInterpolationWorldTransform() = pose;
  to.setLinearVelocity(three(kLinear));
  to.setAngularVelocity(three(kAngular));
  to.setInterpolationLinearVelocity(three(kLinear));
  to.setInterpolationAngularVelocity(three(kAngular));
  to.setCompanionId(-1);
  to.clearForces();
}

// All numbers of a body on which nothing but gravity acts, and which nobody pushes.
inline void take_body(const btRigidBody& from, btScalar time_step, Scalar* to, std::size_t width) {
  const auto three = [&](std::uint32_t place, const btVector3& v) {
    for (std::uint32_t i = 0; i < 3; ++i) to[(place + i) * width] = v[int(i)];
  };
  for (std::uint32_t row = 0; row < 3; ++row) {
    three(kPose + 3 * row, from.getWorldTransform().getBasis()[int(row)]);
    three(kInertia + 3 * row, from.getInvInertiaTensorWorld()[int(row)]);
  }
  three(kPose + 9, from.getWorldTransform().getOrigin());
  three(kLinear, from.getLinearVelocity());
  three(kAngular, from.getAngularVelocity());
  // applyGravity, initSolverBody; (acceleration / inverse mass) isn't public.
  const btVector3 gravity = from.getGravity() * (btScalar(1) / from.getInvMass());
  const btVector3 force = btVector3(0, 0, 0) + gravity * from.getLinearFactor();
  three(kForce, force * from.getInvMass() * time_step);
  three(kTorque, btVector3(0, 0, 0));
  to[kBodyInverseMass * width] = from.getInvMass();
  three(kInertiaOwn, from.getInvInertiaDiagLocal());
}

}  // namespace itarl::lockstep
