// The scene of benches/step.rs in Bullet's own conventions: a walker with six legs that crawls on
// the ground. For each number read from stdin it makes as many steps, and replies with a line:
// the nanoseconds they took, then the state of all bodies.
#include <chrono>
#include <cstdio>

#include "plain.h"

namespace {

struct Walker : PlainWorld {
  struct Leg {
    btGeneric6DofSpring2Constraint* hip;
    btSliderConstraint* knee;
    btSliderConstraint* ankle;
  };
  std::vector<Leg> legs;
  int steps = 0;

  Walker() {
    auto* coxa = new btCapsuleShape(num(0.03), num(0.06));
    auto* femur = new btCapsuleShape(num(0.03), num(0.14));
    auto* tibia = new btCapsuleShapeZ(num(0.03), num(0.2));

    auto info = of(new btStaticPlaneShape(vec(0, 0, 1), num(0)), 0);
    info.m_friction = num(1);
    add(info, at(vec(0, 0, 0)));
    btRigidBody& trunk = add(of(new btBoxShape(vec(0.35, 0.1, 0.05)), 2.0), at(vec(0, 0, 0.3)));
    auto* end = new btBoxShape(vec(0.05, 0.08, 0.05));
    btRigidBody& head = add(of(end, 0.3), at(vec(0.42, 0, 0.3)));
    btRigidBody& tail = add(of(end, 0.3), at(vec(-0.42, 0, 0.3)));
    join(new btFixedConstraint(trunk, head, at(vec(0.35, 0, 0)), at(vec(-0.07, 0, 0))));
    join(new btFixedConstraint(trunk, tail, at(vec(-0.35, 0, 0)), at(vec(0.07, 0, 0))));
    for (double x : {-0.25, 0.0, 0.25}) {
      for (double side : {1.0, -1.0}) {
        btRigidBody& upper = add(of(coxa, 0.2), at(vec(x, side * 0.17, 0.3)));
        btRigidBody& middle = add(of(femur, 0.2), at(vec(x, side * 0.33, 0.3)));
        auto foot = of(tibia, 0.2);
        foot.m_friction = num(1);
        btRigidBody& lower = add(foot, at(vec(x, side * 0.43, 0.18)));
        legs.push_back({hip(trunk, upper, at(vec(x, side * 0.11, 0)), at(vec(0, side * -0.06, 0))),
                        knee(upper, middle, at(vec(0, side * 0.06, 0)), at(vec(0, side * -0.1, 0))),
                        knee(middle, lower, at(vec(0, side * 0.1, 0)), at(vec(0, 0, 0.12)))});
      }
    }
  }

  btGeneric6DofSpring2Constraint* hip(btRigidBody& parent, btRigidBody& child,
                                      const btTransform& in_parent, const btTransform& in_child) {
    auto* hip = new btGeneric6DofSpring2Constraint(parent, child, in_parent, in_child);
    hip->setLinearLowerLimit(vec(0, 0, 0));
    hip->setLinearUpperLimit(vec(0, 0, 0));
    hip->setAngularLowerLimit(vec(-0.3, 0, -0.5));
    hip->setAngularUpperLimit(vec(0.3, 0, 0.5));
    for (int axis : {3, 5}) {
      hip->enableMotor(axis, true);
      hip->setMaxMotorForce(axis, num(15));
      hip->enableSpring(axis, true);
      hip->setStiffness(axis, num(2));
      hip->setDamping(axis, num(0.05));
      hip->setEquilibriumPoint(axis, num(0));
    }
    return join(hip);
  }

  btSliderConstraint* knee(btRigidBody& parent, btRigidBody& child, const btTransform& in_parent,
                           const btTransform& in_child) {
    auto* knee = new btSliderConstraint(parent, child, in_parent, in_child, true);
    knee->setLowerLinLimit(num(0));
    knee->setUpperLinLimit(num(0));
    knee->setLowerAngLimit(num(-0.4));
    knee->setUpperAngLimit(num(0.4));
    knee->setParam(BT_CONSTRAINT_STOP_ERP, num(1), 3);
    knee->setParam(BT_CONSTRAINT_STOP_CFM, num(0), 3);
    knee->setPoweredAngMotor(true);
    knee->setMaxAngMotorForce(num(15));
    return join(knee);
  }

  template <typename Joint>
  Joint* join(Joint* joint) {
    world.addConstraint(joint, true);
    return joint;
  }

  // Neighbouring legs move in turns.
  void turn_motors() {
    for (int i = 0; i < 6; ++i) {
      const double turn = i % 4 == 0 || i % 4 == 3 ? 1.0 : -1.0;
      const double side = i % 2 == 0 ? 1.0 : -1.0;
      const Leg& leg = legs[static_cast<std::size_t>(i)];
      leg.hip->setTargetVelocity(3, num(-0.5 * turn * side * square(steps, 40)));
      leg.hip->setTargetVelocity(5, num(-1.0 * turn * side * square(steps + 20, 40)));
      leg.knee->setTargetAngMotorVelocity(num(-1.5 * turn * side * square(steps, 40)));
      leg.ankle->setTargetAngMotorVelocity(num(-1.0 * turn * side * square(steps + 10, 40)));
    }
  }

  void advance() {
    if (steps % 10 == 0) turn_motors();
    step();
    ++steps;
  }
};

}  // namespace

int main() {
  Walker walker;
  int count = 0;
  while (std::scanf("%d", &count) == 1) {
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < count; ++i) walker.advance();
    const std::chrono::nanoseconds elapsed = std::chrono::steady_clock::now() - start;
    std::printf("%lld", static_cast<long long>(elapsed.count()));
    walker.read([](double value) { std::printf(" %.17g", value); });
    std::printf("\n");
    std::fflush(stdout);
  }
}
