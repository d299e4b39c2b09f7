// The scene of tests/fidelity.rs in Bullet's own conventions: a chain of every kind of joint is
// dropped on the ground and dragged about between loose bodies, its motors turning to and fro.
// Makes 2,000 steps and prints the state of all bodies after each, as doubles in the machine's
// own byte order.
#include <cstdio>

#include "plain.h"

namespace {

constexpr int kSteps = 2000;
constexpr double kHalfSqrt = 0.7071067811865476;

// They turn z to y, x to z, and z to x.
const btQuaternion kZToY = quat(-kHalfSqrt, 0, 0, kHalfSqrt);
const btQuaternion kXToZ = quat(0, -kHalfSqrt, 0, kHalfSqrt);
const btQuaternion kZToX = quat(0, kHalfSqrt, 0, kHalfSqrt);

btConvexHullShape* make_hull() {
  const btVector3 corners[] = {vec(0.12, 0, -0.03),      vec(-0.06, 0.09, -0.03),
                               vec(-0.06, -0.09, -0.03), vec(0.04, 0.02, 0.07),
                               vec(-0.04, 0.05, 0.06),   vec(-0.05, -0.04, 0.05)};
  auto* hull = new btConvexHullShape(&corners[0][0], 6, sizeof(btVector3));
  hull->setMargin(num(0.01));
  hull->recalcLocalAabb();
  return hull;
}

// Without its tree of children, which would give the contacts another order.
btCompoundShape* make_compound() {
  auto* compound = new btCompoundShape(false);
  compound->addChildShape(at(vec(-0.04, 0, 0), quat(0, 0, 0.6, 0.8)),
                          new btBoxShape(vec(0.07, 0.05, 0.04)));
  compound->addChildShape(at(vec(0.07, 0.02, -0.01)), new btSphereShape(num(0.06)));
  return compound;
}

struct Chain : PlainWorld {
  btHingeConstraint* elbow;
  btSliderConstraint* piston;
  btSliderConstraint* knee;
  btGeneric6DofSpring2Constraint* hip;
  btHingeConstraint* wheel;

  Chain() {
    add_bodies();
    add_joints();
  }

  void add_bodies() {
    auto info = of(new btStaticPlaneShape(vec(0, 0, 1), num(0)), 0);
    info.m_friction = num(0.8);
    info.m_restitution = num(0.5);
    add(info, at(vec(0, 0, 0)));

    info = of(new btBoxShape(vec(0.12, 0.1, 0.08)), 1.0);
    info.m_localInertia = vec(0.006, 0.008, 0.01);
    info.m_friction = num(0.7);
    add(info, at(vec(0, 0, 0.4)));

    info = of(new btSphereShape(num(0.08)), 0.6);
    info.m_restitution = num(0.4);
    info.m_rollingFriction = num(0.01);
    info.m_spinningFriction = num(0.02);
    add(info, at(vec(0.3, 0, 0.4)));

    info = of(new btCapsuleShapeX(num(0.05), num(0.14)), 0.5);
    info.m_linearDamping = num(0.05);
    info.m_angularDamping = num(0.1);
    add(info, at(vec(0.6, 0, 0.4)));

    add(of(new btCylinderShapeX(vec(0.09, 0.06, 0.06)), 0.8), at(vec(0.9, 0, 0.4)));
    add(of(make_hull(), 0.7), at(vec(1.2, 0, 0.4)));
    add(of(make_compound(), 0.9), at(vec(1.5, 0, 0.4)));
    add(of(new btBoxShape(vec(0.1, 0.07, 0.05)), 0.4), at(vec(1.8, 0, 0.4)));
    add(of(new btCapsuleShapeZ(num(0.06), num(0.1)), 0.6), at(vec(2.1, 0, 0.4), kZToX));

    info = of(new btCylinderShape(vec(0.12, 0.04, 0.12)), 0.5);
    info.m_friction = num(1.2);
    add(info, at(vec(2.25, 0.1, 0.4)));

    // The loose ones.
    add(of(new btBoxShape(vec(0.1, 0.1, 0.1)), 0.5), at(vec(0.4, 0.12, 0.1)));
    info = of(new btSphereShape(num(0.1)), 0.3);
    info.m_restitution = num(0.9);
    info.m_rollingFriction = num(0.02);
    add(info, at(vec(1.2, 0.05, 0.8)));
    add(of(new btCylinderShapeZ(vec(0.08, 0.08, 0.12)), 0.5),
        at(vec(1.9, -0.35, 0.3), quat(0.6, 0, 0, 0.8)));
  }

  void add_joints() {
    const btVector3 before = vec(-0.15, 0, 0);
    const btVector3 behind = vec(0.15, 0, 0);
    const auto& b = bodies;

    join(new btFixedConstraint(*b[1], *b[2], at(behind), at(before)));
    join(new btPoint2PointConstraint(*b[2], *b[3], behind, before));

    // With frame A as the reference, so that angles are right-handed.
    elbow = new btHingeConstraint(*b[3], *b[4], at(behind, kZToY), at(before, kZToY), true);
    elbow->setLimit(num(-0.7), num(0.4));
    elbow->enableAngularMotor(true, num(0), num(1.5) * kTimeStep);
    join(elbow);

    piston = new btSliderConstraint(*b[4], *b[5], at(behind), at(before), true);
    piston->setLowerLinLimit(num(-0.05));
    piston->setUpperLinLimit(num(0.08));
    piston->setLowerAngLimit(num(0));
    piston->setUpperAngLimit(num(0));
    piston->setParam(BT_CONSTRAINT_STOP_ERP, num(0.5), 0);  // acts as its square
    piston->setParam(BT_CONSTRAINT_STOP_CFM, num(0.001), 0);
    piston->setPoweredLinMotor(true);
    piston->setMaxLinMotorForce(num(12));
    join(piston);

    // A slider that can't slide is a hinge about x.
    knee = new btSliderConstraint(*b[5], *b[6], at(behind, kXToZ), at(before, kXToZ), true);
    knee->setLowerLinLimit(num(0));
    knee->setUpperLinLimit(num(0));
    knee->setLowerAngLimit(num(-0.5));
    knee->setUpperAngLimit(num(0.9));
    knee->setParam(BT_CONSTRAINT_STOP_ERP, num(1), 3);
    knee->setParam(BT_CONSTRAINT_STOP_CFM, num(0), 3);
    for (const int axis : {1, 4}) {  // what it holds: along y and z, about y and z
      knee->setParam(BT_CONSTRAINT_STOP_ERP, num(0.6), axis);
      knee->setParam(BT_CONSTRAINT_STOP_CFM, num(0.0005), axis);
    }
    knee->setPoweredAngMotor(true);
    knee->setMaxAngMotorForce(num(2.5));
    join(knee);

    // Its angles are minus right-handed. Lower above upper is free: the turn about x.
    const btQuaternion tilt = quat(0, 0.28, 0, 0.96);
    hip = new btGeneric6DofSpring2Constraint(*b[6], *b[7], at(behind, tilt), at(before, tilt));
    hip->setLinearLowerLimit(vec(0, 0, -0.04));
    hip->setLinearUpperLimit(vec(0, 0, 0.06));
    hip->setAngularLowerLimit(vec(1, -0.6, -0.7));
    hip->setAngularUpperLimit(vec(-1, 0.4, 0.3));
    hip->setParam(BT_CONSTRAINT_STOP_ERP, num(0.7), 5);
    hip->setParam(BT_CONSTRAINT_STOP_CFM, num(0.0001), 5);
    hip->setBounce(5, num(0.2));
    for (int axis : {2, 3, 5}) hip->enableMotor(axis, true);
    hip->setMaxMotorForce(2, num(20));
    hip->setMaxMotorForce(3, num(0.5));
    hip->setMaxMotorForce(5, num(2));
    hip->enableSpring(2, true);
    hip->setStiffness(2, num(60));
    hip->setDamping(2, num(2));
    hip->setEquilibriumPoint(2, num(0.01));
    hip->enableSpring(4, true);
    hip->setStiffness(4, num(1.5));
    hip->setDamping(4, num(0.02));
    hip->setEquilibriumPoint(4, num(-0.2));
    join(hip);

    // About z; the capsule's own z lies along x. No motor.
    auto* tail = new btHingeConstraint(*b[7], *b[8], at(behind), at(vec(0, 0, -0.15), kXToZ), true);
    tail->setLimit(num(-0.8), num(0.6), num(0.9), num(1), num(0.3));  // bias 1, bounce 0.3
    tail->setParam(BT_CONSTRAINT_STOP_ERP, num(0.8), 5);
    tail->setParam(BT_CONSTRAINT_STOP_CFM, num(0.0002), 5);
    join(tail);

    // Turns without end. The two may touch.
    wheel = new btHingeConstraint(*b[8], *b[9], at(vec(0, 0.1, 0.15), quat(-0.5, -0.5, -0.5, 0.5)),
                                  at(vec(0, 0, 0), kZToY), true);
    wheel->enableAngularMotor(true, num(0), num(1) * kTimeStep);
    world.addConstraint(wheel);
  }

  // The two bodies don't collide.
  void join(btTypedConstraint* joint) { world.addConstraint(joint, true); }

  void turn_motors(int step) {
    elbow->setMotorTargetVelocity(num(2.5 * square(step, 70)));
    piston->setTargetLinMotorVelocity(num(0.6 * square(step, 45)));
    // A slider's angular motor, and all motors of the 6-dof joint, count backwards.
    knee->setTargetAngMotorVelocity(num(-3.0 * square(step, 110)));
    hip->setTargetVelocity(2, num(-0.4 * square(step, 35)));
    hip->setTargetVelocity(3, num(-2.0 * square(step, 150)));
    hip->setTargetVelocity(5, num(-1.5 * square(step, 60)));
    wheel->setMotorTargetVelocity(num(8.0 * square(step, 240)));
    // A hinge's limit is an impulse.
    wheel->setMaxMotorImpulse(num(1.25 + 0.75 * square(step, 130)) * kTimeStep);
  }

  void push(int step) {
    if (step % 200 < 90) {
      const double along = 45 * square(step, 400);
      const double across = 45 * square(step, 800);
      btRigidBody& head = *bodies[1];
      const btVector3& centre = head.getCenterOfMassPosition();
      const btVector3 point = vec(centre.x() + 0.02, centre.y(), centre.z() + 0.05);
      head.applyForce(step / 200 % 2 == 0 ? vec(along, 0, 6) : vec(0, across, 6), point - centre);
    }
    if (step % 170 < 5) bodies[6]->applyTorque(vec(4, -3, 5));
    if (step % 230 == 100) bodies[9]->applyCentralImpulse(vec(-0.5, 0.3, 2.5));
    if (step % 310 == 200) bodies[4]->applyTorqueImpulse(vec(0.1, -0.05, 0.15));
  }
};

}  // namespace

int main() {
  Chain chain;
  for (int step = 0; step < kSteps; ++step) {
    chain.turn_motors(step);
    chain.push(step);
    chain.step();
    chain.read([](double value) { std::fwrite(&value, sizeof value, 1, stdout); });
  }
}
