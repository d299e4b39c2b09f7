// What the reference programs share: a world as Bullet's manual builds one, on Bullet's API alone.
// Nothing is freed; the process ends.
#pragma once

#include <BulletCollision/BroadphaseCollision/btSimpleBroadphase.h>
#include <btBulletDynamicsCommon.h>

#include <vector>

// All numbers are told as double and rounded to btScalar once, as the crate's are.
inline btScalar num(double value) { return static_cast<btScalar>(value); }
inline btVector3 vec(double x, double y, double z) { return btVector3(num(x), num(y), num(z)); }
inline btQuaternion quat(double x, double y, double z, double w) {
  return btQuaternion(num(x), num(y), num(z), num(w));
}
inline btTransform at(const btVector3& origin,
                      const btQuaternion& rotation = btQuaternion::getIdentity()) {
  return btTransform(rotation, origin);
}

// 1 and -1 by turns, for `half` steps each.
inline double square(int step, int half) { return step / half % 2 == 0 ? 1.0 : -1.0; }

inline const btScalar kTimeStep = num(0.01);

struct PlainWorld {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  // The crate's: each kind of broadphase has its own order of pairs, in which contacts are found
  // and solved, and so its own bits.
  btSimpleBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
  std::vector<btRigidBody*> bodies;

  PlainWorld() {
    world.setGravity(vec(0, 0, -9.81));
    world.getSolverInfo().m_numIterations = 200;
  }

  btRigidBody& add(btRigidBody::btRigidBodyConstructionInfo info, const btTransform& pose) {
    info.m_startWorldTransform = pose;
    auto* body = new btRigidBody(info);
    if (info.m_mass > 0) body->setActivationState(DISABLE_DEACTIVATION);
    bodies.push_back(body);
    world.addRigidBody(body);
    return *body;
  }

  // The same call for all of a body's settings but its pose; mass 0 makes a static body.
  static btRigidBody::btRigidBodyConstructionInfo of(btCollisionShape* shape, double mass) {
    btVector3 inertia(0, 0, 0);
    if (mass > 0) shape->calculateLocalInertia(num(mass), inertia);
    return {num(mass), nullptr, shape, inertia};
  }

  void step() { world.stepSimulation(kTimeStep, 1, kTimeStep); }

  // Calls `out` with each number of each body's state: position, rotation by rows, velocity,
  // angular velocity.
  template <typename Out>
  void read(Out out) const {
    const auto all = [&](const btVector3& v) {
      for (int i = 0; i < 3; ++i) out(static_cast<double>(v[i]));
    };
    for (const btRigidBody* body : bodies) {
      all(body->getWorldTransform().getOrigin());
      for (int row = 0; row < 3; ++row) all(body->getWorldTransform().getBasis()[row]);
      all(body->getLinearVelocity());
      all(body->getAngularVelocity());
    }
  }
};
