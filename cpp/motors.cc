// A motor is one of its joint's rows, and does work on the bodies on both sides:
//
//   force = impulse / time step           in N or N m, positive where it makes the position grow
//   work  = impulse * J v                 in J
//
// with the row's Jacobian J, so that no sign or unit of Bullet's classes matters, and the velocities
// v that the solver hands to the bodies, with which they move in this step: J v times the time step
// is how far the axis moves.
//
// A hinge or a slider has one row for its motor and its stop; of what that does at the stop, no more
// than the motor's own limit is counted.
#include "motors.h"

#include <algorithm>

#include "state.h"
#include "world.h"

namespace itarl {

namespace {

constexpr int kAngularX = 3;
constexpr int kAngularY = 4;

// Which of a joint's rows is its motor's. Bullet's getInfo2 makes them in this order; a stop of a
// 6-dof joint has a row for each end, and one if it's locked.
int motor_row(const JointEntry& entry, int axis) {
  switch (entry.kind) {
    case JointKind::Hinge:
      return 5;  // after three that hold the anchor and two that hold the axis
    case JointKind::Slider: {
      auto& slider = static_cast<btSliderConstraint&>(*entry.joint);
      const int held = 4;
      const bool linear = slider.getSolveLinLimit() || slider.getPoweredLinMotor();
      return axis == 0 || !linear ? held : held + 1;
    }
    default: {
      auto& joint = static_cast<btGeneric6DofSpring2Constraint&>(*entry.joint);
      const btTranslationalLimitMotor2& linear = *joint.getTranslationalLimitMotor();
      int row = 0;
      for (const int i : {3, 4, 5, 0, 1, 2}) {
        const btRotationalLimitMotor2* const angular =
            i < kAngularX ? nullptr : joint.getRotationalLimitMotor(i - kAngularX);
        const int limit = angular ? angular->m_currentLimit : linear.m_currentLimit[i];
        row += limit == 4 ? 2 : limit != 0 ? 1 : 0;
        if (i == axis) break;
        row += (angular ? angular->m_enableMotor : linear.m_enableMotor[i]) ? 1 : 0;
        row += (angular ? angular->m_enableSpring : linear.m_enableSpring[i]) ? 1 : 0;
      }
      return row;
    }
  }
}

// The most that the motor may do in a step.
btScalar motor_limit(const JointEntry& entry, int axis, btScalar time_step) {
  switch (entry.kind) {
    case JointKind::Hinge:
      return static_cast<btHingeConstraint&>(*entry.joint).getMaxMotorImpulse();
    case JointKind::Slider: {
      auto& slider = static_cast<btSliderConstraint&>(*entry.joint);
      return time_step * (axis == 0 ? slider.getMaxLinMotorForce() : slider.getMaxAngMotorForce());
    }
    default:
      return SIMD_INFINITY;  // its row has no other limits
  }
}

// The direction in which the child moves, or about which it turns, as the position of an axis grows.
btVector3 direction_of(const JointEntry& entry, int axis) {
  const btMatrix3x3 parent =
      entry.parent->body->getWorldTransform().getBasis() * entry.frame_in_parent.getBasis();
  const btMatrix3x3 child =
      entry.child->body->getWorldTransform().getBasis() * entry.frame_in_child.getBasis();
  if (axis < kAngularX) return parent.getColumn(axis);
  if (axis == kAngularX) return child.getColumn(0);
  if (axis == kAngularY) return parent.getColumn(2).cross(child.getColumn(0));
  return parent.getColumn(2);
}

double dot(const btVector3& a, const btVector3& b) {
  return double(a.x()) * b.x() + double(a.y()) * b.y() + double(a.z()) * b.z();
}

// Of one side of a row, with the sums that writeBackBodies makes.
double speed(const btVector3& linear, const btVector3& angular, const btSolverBody& body) {
  return dot(linear, body.m_linearVelocity + body.m_deltaLinearVelocity +
                         body.m_externalForceImpulse) +
         dot(angular, body.m_angularVelocity + body.m_deltaAngularVelocity +
                          body.m_externalTorqueImpulse);
}

}  // namespace

void MotorMeter::begin(btScalar time_step) {
  time_step_ = time_step;
  for (const auto& entry : joints_) {
    if (entry) entry->motors = MotorState{};
  }
}

void MotorMeter::see(const btTypedConstraint& joint, const btSolverConstraint* rows, int count,
                     const btSolverBody& a, const btSolverBody& b) {
  JointEntry& entry = *joints_[std::size_t(joint.getUserConstraintId())];
  for (int axis = 0; axis < 6; ++axis) {
    if (!entry.has_motor[std::size_t(axis)]) continue;
    const int place = motor_row(entry, axis);
    if (place >= count) continue;
    const btSolverConstraint& row = rows[place];
    const btScalar most = motor_limit(entry, axis, time_step_);
    const double impulse = std::clamp(btScalar(row.m_appliedImpulse), -most, most);
    const btVector3& child = axis < kAngularX ? row.m_contactNormal2 : row.m_relpos2CrossNormal;
    const bool grows = dot(direction_of(entry, axis), child) > 0;
    entry.motors.force[std::size_t(axis)] = (grows ? impulse : -impulse) / double(time_step_);
    entry.motors.work[std::size_t(axis)] =
        impulse * (speed(row.m_contactNormal1, row.m_relpos1CrossNormal, a) +
                   speed(row.m_contactNormal2, row.m_relpos2CrossNormal, b));
  }
}

void World::measure_motors(bool measure) noexcept {
  State& state = changing();
  state.solver.set_observer(measure ? &state.motors : nullptr);
  state.motors.begin(state.time_step);
}

void World::read_motors_of(rust::Slice<const JointId> ids, rust::Slice<MotorState> out) const {
  const Call call{"read_motors_of"};
  if (out.size() != ids.size()) {
    call.refuse("out", std::to_string(ids.size()) + " entries long", std::to_string(out.size()));
  }
  if (!state_->solver.is_observed()) {
    call.refuse("the world", "one that measures its motors", "one that doesn't");
  }
  const auto& joints = state_->joints;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (ids[i].slot >= joints.size() || !joints[ids[i].slot]) {
      state_->joint(call, "ids[" + std::to_string(i) + "]", ids[i]);
    }
    out[i] = joints[ids[i].slot]->motors;
  }
}

}  // namespace itarl
