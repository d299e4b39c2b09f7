// Joints, in one convention: an axis' position is the child's frame seen from the parent's frame,
// right-handed, and a positive motor velocity makes it grow. Bullet's classes differ:
//
//   class                            joint axis   its angle               its motor limit
//   btHingeConstraint                z            right-handed, if built  impulse, N m s
//                                                 with frame A as the
//                                                 reference
//   btSliderConstraint               x            right-handed, but a     N, N m
//                                                 positive motor velocity
//                                                 turns it down
//   btGeneric6DofSpring2Constraint   x, y, z      minus right-handed; a   N, N m
//                                                 positive linear motor
//                                                 velocity moves it down
//
// Angles of joints with three rotations: the child's frame is the parent's, turned about z, then
// about the new y, then about the newest x (Bullet's RO_XYZ).
#include <algorithm>

#include "state.h"
#include "world.h"

namespace itarl {

namespace {

constexpr int kAngularX = 3;
// Of a slider: stands for y and z, in whose settings Bullet makes no difference.
constexpr int kHeldLinear = 1;
constexpr int kHeldAngular = 4;
constexpr int kAngularZ = 5;
constexpr std::array<const char*, 6> kAxisNames = {"linear x",  "linear y",  "linear z",
                                                   "angular x", "angular y", "angular z"};

// An axis' settings in Bullet's precision, still in our signs.
struct CheckedAxis {
  bool free;
  btScalar lower, upper;
  std::optional<btScalar> erp, cfm, bounce;
  bool has_motor, has_spring;
  btScalar motor_velocity, motor_force;
  btScalar stiffness, damping, equilibrium;
};

std::optional<btScalar> check_maybe(const Call& call, const std::string& name, const Maybe& maybe,
                                    double high) {
  if (!maybe.given) return std::nullopt;
  return call.within(name, maybe.value, 0, high, "between 0 and " + to_text(high));
}

CheckedAxis check_axis(const Call& call, const AxisSpec& spec, int axis, JointKind kind) {
  const bool held = kind == JointKind::Slider && axis == kHeldLinear;
  const std::string name = held ? "held" : kAxisNames[axis];
  // Past half a turn an angle comes back from the other side; the middle one of three angles
  // only reaches a quarter.
  const double farthest = axis < 3 ? kLongestLength : axis == 4 ? SIMD_HALF_PI : SIMD_PI;
  const std::string range = axis < 3    ? "within 1e6 m"
                            : axis == 4 ? "within a quarter turn"
                                        : "within half a turn";
  CheckedAxis to{};
  to.free = spec.free;
  if (!to.free) {
    to.lower = call.within(name + " lower limit", spec.lower, -farthest, farthest, range);
    to.upper = call.within(name + " upper limit", spec.upper, -farthest, farthest, range);
    // Reversed limits mean free to Bullet, too.
    if (to.lower > to.upper) {
      call.refuse(name + " lower limit", "at most the upper one, " + to_text(spec.upper),
                  spec.lower);
    }
  }
  to.erp = check_maybe(call, name + " stop erp", spec.stop_erp, 1);
  to.cfm = check_maybe(call, name + " stop cfm", spec.stop_cfm, kLargestNumber);
  to.bounce = check_maybe(call, name + " stop bounce", spec.stop_bounce, 1);
  if (held && to.bounce.value_or(0) > 0) {
    call.refuse("held stop bounce", "0: what is held doesn't move", spec.stop_bounce.value);
  }
  if (kind == JointKind::Slider && axis < 3 && to.bounce.value_or(0) > 0) {
    call.refuse(name + " stop bounce", "0: Bullet's slider tests the wrong sign, and never bounces",
                spec.stop_bounce.value);
  }
  to.has_motor = spec.has_motor;
  to.motor_velocity = call.number(name + " motor target velocity", spec.motor_velocity);
  to.motor_force = call.non_negative(name + " motor max force", spec.motor_force);
  to.has_spring = spec.has_spring;
  if (to.has_spring && kind != JointKind::SixDofSpring) {
    call.refuse(name + " spring", "absent: only a 6-dof spring joint has springs", "one");
  }
  to.stiffness = call.non_negative(name + " spring stiffness", spec.spring_stiffness);
  to.damping = call.non_negative(name + " spring damping", spec.spring_damping);
  to.equilibrium = call.within(name + " spring equilibrium", spec.spring_equilibrium, -farthest,
                               farthest, range);
  return to;
}

// 0 - x, which unlike -x keeps zeros positive.
btScalar negated(btScalar x) { return btScalar(0) - x; }

std::unique_ptr<btTypedConstraint> make_hinge(btRigidBody& parent, btRigidBody& child,
                                              const btTransform& in_parent,
                                              const btTransform& in_child, const CheckedAxis& axis,
                                              btScalar time_step) {
  auto hinge = std::make_unique<btHingeConstraint>(parent, child, in_parent, in_child, true);
  if (axis.free) {
    hinge->setLimit(1, -1);
  } else {
    // Bullet multiplies a hinge's stop erp and its bounce by a bias. By itself it has a bias of .3f
    // (in double precision, too) and a bounce of 1; what is asked for must mean what it says.
    const btScalar softness = btScalar(.9f);
    const btScalar own_bias = btScalar(.3f);
    const btScalar bias = axis.erp ? btScalar(1) : own_bias;
    hinge->setLimit(axis.lower, axis.upper, softness, bias, axis.bounce.value_or(own_bias) / bias);
  }
  if (axis.erp) hinge->setParam(BT_CONSTRAINT_STOP_ERP, *axis.erp, 5);
  if (axis.cfm) hinge->setParam(BT_CONSTRAINT_STOP_CFM, *axis.cfm, 5);
  if (axis.has_motor) {
    hinge->enableAngularMotor(true, axis.motor_velocity, axis.motor_force * time_step);
  }
  return hinge;
}

// Bullet multiplies the error at a slider's stop by fps * erp and again by a softness, and
// setParam sets both to its argument: what it is given acts as its square.
btScalar slider_erp(btScalar erp) { return btSqrt(erp); }

std::unique_ptr<btTypedConstraint> make_slider(btRigidBody& parent, btRigidBody& child,
                                               const btTransform& in_parent,
                                               const btTransform& in_child,
                                               const CheckedAxis& linear,
                                               const CheckedAxis& angular,
                                               const CheckedAxis& held) {
  auto slider = std::make_unique<btSliderConstraint>(parent, child, in_parent, in_child, true);
  slider->setLowerLinLimit(linear.free ? btScalar(1) : linear.lower);
  slider->setUpperLinLimit(linear.free ? btScalar(-1) : linear.upper);
  slider->setLowerAngLimit(angular.free ? btScalar(1) : angular.lower);
  slider->setUpperAngLimit(angular.free ? btScalar(-1) : angular.upper);
  if (linear.erp) slider->setParam(BT_CONSTRAINT_STOP_ERP, slider_erp(*linear.erp), 0);
  if (linear.cfm) slider->setParam(BT_CONSTRAINT_STOP_CFM, *linear.cfm, 0);
  if (angular.erp) slider->setParam(BT_CONSTRAINT_STOP_ERP, slider_erp(*angular.erp), kAngularX);
  if (angular.cfm) slider->setParam(BT_CONSTRAINT_STOP_CFM, *angular.cfm, kAngularX);
  if (angular.bounce) {
    // What comes back, |1 - damping| of the speed, is multiplied by the softness as well.
    const btScalar softness = angular.erp ? slider_erp(*angular.erp) : btScalar(1);
    if (softness > 0) slider->setDampingLimAng(1 - *angular.bounce / softness);
  }
  // Not multiplied by anything.
  for (const int axis : {kHeldLinear, kHeldAngular}) {
    if (held.erp) slider->setParam(BT_CONSTRAINT_STOP_ERP, *held.erp, axis);
    if (held.cfm) slider->setParam(BT_CONSTRAINT_STOP_CFM, *held.cfm, axis);
  }
  if (linear.has_motor) {
    slider->setPoweredLinMotor(true);
    slider->setTargetLinMotorVelocity(linear.motor_velocity);
    slider->setMaxLinMotorForce(linear.motor_force);
  }
  if (angular.has_motor) {
    slider->setPoweredAngMotor(true);
    slider->setTargetAngMotorVelocity(negated(angular.motor_velocity));
    slider->setMaxAngMotorForce(angular.motor_force);
  }
  return slider;
}

std::unique_ptr<btTypedConstraint> make_six_dof(btRigidBody& parent, btRigidBody& child,
                                                const btTransform& in_parent,
                                                const btTransform& in_child,
                                                const std::array<CheckedAxis, 6>& axes) {
  auto joint = std::make_unique<btGeneric6DofSpring2Constraint>(parent, child, in_parent, in_child,
                                                                RO_XYZ);
  for (int i = 0; i < 6; ++i) {
    const CheckedAxis& axis = axes[i];
    const bool angular = i >= 3;
    if (axis.free) {
      joint->setLimit(i, 1, -1);
    } else if (angular) {
      joint->setLimit(i, negated(axis.upper), negated(axis.lower));
    } else {
      joint->setLimit(i, axis.lower, axis.upper);
    }
    if (axis.erp) joint->setParam(BT_CONSTRAINT_STOP_ERP, *axis.erp, i);
    if (axis.cfm) joint->setParam(BT_CONSTRAINT_STOP_CFM, *axis.cfm, i);
    if (axis.bounce) joint->setBounce(i, *axis.bounce);
    if (axis.has_motor) {
      joint->enableMotor(i, true);
      joint->setTargetVelocity(i, negated(axis.motor_velocity));
      joint->setMaxMotorForce(i, axis.motor_force);
    }
    if (axis.has_spring) {
      joint->enableSpring(i, true);
      joint->setStiffness(i, axis.stiffness);
      joint->setDamping(i, axis.damping);
      joint->setEquilibriumPoint(i, angular ? negated(axis.equilibrium) : axis.equilibrium);
    }
  }
  return joint;
}

// Which axes of a kind the caller sets.
bool is_open(JointKind kind, int axis) {
  switch (kind) {
    case JointKind::Hinge:
      return axis == kAngularZ;
    case JointKind::Slider:
      return axis == 0 || axis == kAngularX || axis == kHeldLinear;
    case JointKind::SixDofSpring:
      return true;
    default:
      return false;
  }
}

// f, l or r: free, locked or a range; in capitals with a motor; + with a spring.
std::string letter_of(const CheckedAxis& axis) {
  const char letter = axis.free ? 'f' : axis.lower == axis.upper ? 'l' : 'r';
  return std::string(1, axis.has_motor ? char(letter - 'a' + 'A') : letter) +
         (axis.has_spring ? "+" : "");
}

void set_motor(const JointEntry& entry, int axis, btScalar velocity, btScalar force,
               btScalar time_step) {
  switch (entry.kind) {
    case JointKind::Hinge: {
      auto& hinge = static_cast<btHingeConstraint&>(*entry.joint);
      hinge.enableAngularMotor(true, velocity, force * time_step);
      return;
    }
    case JointKind::Slider: {
      auto& slider = static_cast<btSliderConstraint&>(*entry.joint);
      if (axis == 0) {
        slider.setTargetLinMotorVelocity(velocity);
        slider.setMaxLinMotorForce(force);
      } else {
        slider.setTargetAngMotorVelocity(negated(velocity));
        slider.setMaxAngMotorForce(force);
      }
      return;
    }
    default: {
      auto& joint = static_cast<btGeneric6DofSpring2Constraint&>(*entry.joint);
      joint.setTargetVelocity(axis, negated(velocity));
      joint.setMaxMotorForce(axis, force);
      return;
    }
  }
}

// The axis that a joint with one rotation turns about, 0 to 2; -1 for joints with three.
int only_rotation(JointKind kind) {
  return kind == JointKind::Hinge ? 2 : kind == JointKind::Slider ? 0 : -1;
}

// Of the matrix a * b.
btVector3 column_of(const btMatrix3x3& a, const btMatrix3x3& b, int i) {
  const btVector3 column = b.getColumn(i);
  return btVector3(column.dot(a[0]), column.dot(a[1]), column.dot(a[2]));
}

// Of the child's frame in the parent's frame, by the bodies' rotations: the one rotation, from the
// frames' axes p and q that follow the joint's axis; or the three rotations z, y', x''.
std::array<double, 3> angles_of(const JointEntry& entry, const btMatrix3x3& parent,
                                const btMatrix3x3& child) {
  const btMatrix3x3& in_parent = entry.frame_in_parent.getBasis();
  const btMatrix3x3& in_child = entry.frame_in_child.getBasis();
  const int axis = only_rotation(entry.kind);
  std::array<double, 3> angles{};
  if (axis >= 0) {
    const btVector3 p = column_of(parent, in_parent, (axis + 1) % 3);
    const btVector3 q = column_of(parent, in_parent, (axis + 2) % 3);
    const btVector3 turned = column_of(child, in_child, (axis + 1) % 3);
    angles[std::size_t(axis)] = btAtan2(turned.dot(q), turned.dot(p));
  } else {
    btVector3 minus;
    const btMatrix3x3 a = parent * in_parent, b = child * in_child;
    btGeneric6DofSpring2Constraint::matrixToEulerXYZ(a.inverse() * b, minus);
    for (int i = 0; i < 3; ++i) angles[std::size_t(i)] = negated(minus[i]);
  }
  return angles;
}

// The rates of three rotations z, y', x'': spin = z' * z + y' * y + x' * x, solved by the dual basis.
btVector3 rates_of(const btMatrix3x3& a, const btMatrix3x3& b, const btVector3& spin) {
  const btVector3 x = b.getColumn(0);
  const btVector3 z = a.getColumn(2);
  const btVector3 y = z.cross(x);
  const btScalar square = y.length2();  // cos^2 of the middle angle
  if (!(square > SIMD_EPSILON)) return btVector3(0, 0, 0);
  return btVector3(spin.dot(y.cross(z)) / square, spin.dot(y) / btSqrt(square),
                   spin.dot(x.cross(y)) / square);
}

JointState read_joint(const JointEntry& entry) {
  JointState to{};
  const btRigidBody& parent = *entry.parent->body;
  const btRigidBody& child = *entry.child->body;
  const btTransform a = parent.getWorldTransform() * entry.frame_in_parent;
  const btTransform b = child.getWorldTransform() * entry.frame_in_child;

  // The child's anchor in the parent's frame, and its velocity there.
  const btVector3 offset = b.getOrigin() - a.getOrigin();
  const btVector3 velocity =
      child.getVelocityInLocalPoint(b.getOrigin() - child.getCenterOfMassPosition()) -
      parent.getVelocityInLocalPoint(b.getOrigin() - parent.getCenterOfMassPosition());
  for (int i = 0; i < 3; ++i) {
    const btVector3 axis = a.getBasis().getColumn(i);
    to.position[i] = axis.dot(offset);
    to.velocity[i] = axis.dot(velocity);
  }

  const btMatrix3x3 &from = a.getBasis(), &turned = b.getBasis();
  const btVector3 spin = child.getAngularVelocity() - parent.getAngularVelocity();
  const std::array<double, 3> angles = angles_of(entry, parent.getWorldTransform().getBasis(),
                                                 child.getWorldTransform().getBasis());
  const int axis = only_rotation(entry.kind);
  const btVector3 rates = axis < 0 ? rates_of(from, turned, spin) : btVector3(0, 0, 0);
  for (int i = 0; i < 3; ++i) {
    to.position[kAngularX + i] = angles[std::size_t(i)];
    to.velocity[kAngularX + i] = i == axis ? spin.dot(from.getColumn(i)) : rates[i];
  }
  to.force = to_array(entry.feedback.m_appliedForceBodyB);
  to.torque = to_array(entry.feedback.m_appliedTorqueBodyB);
  to.exists = true;
  return to;
}

// Bullet's constraint of a kind of joint between two bodies.
std::unique_ptr<btTypedConstraint> make_joint(const Call& call, JointKind kind, btRigidBody& a,
                                              btRigidBody& b, const btTransform& in_a,
                                              const btTransform& in_b,
                                              const std::array<CheckedAxis, 6>& axes,
                                              btScalar time_step) {
  switch (kind) {
    case JointKind::Fixed:
      return std::make_unique<btFixedConstraint>(a, b, in_a, in_b);
    case JointKind::PointToPoint:
      return std::make_unique<btPoint2PointConstraint>(a, b, in_a.getOrigin(), in_b.getOrigin());
    case JointKind::Hinge:
      return make_hinge(a, b, in_a, in_b, axes[kAngularZ], time_step);
    case JointKind::Slider:
      return make_slider(a, b, in_a, in_b, axes[0], axes[kAngularX], axes[kHeldLinear]);
    case JointKind::SixDofSpring:
      return make_six_dof(a, b, in_a, in_b, axes);
    default:
      call.refuse("kind", "a kind of joint", std::to_string(int(kind)));
  }
}

}  // namespace

JointId World::add_joint(const JointSpec& spec) {
  const Call call{"add_joint"};
  State& state = changing();
  BodyEntry& parent = state.body(call, "parent", spec.parent);
  BodyEntry& child = state.body(call, "child", spec.child);
  if (&parent == &child) {
    call.refuse("child", "another body than the parent", "body " + std::to_string(spec.child.slot));
  }
  if (parent.motion != Motion::Dynamic && child.motion != Motion::Dynamic) {
    call.refuse("child", "dynamic, unless its parent is", "two bodies that nothing moves");
  }
  const btTransform in_parent = to_transform(call, "frame_in_parent", spec.frame_in_parent);
  const btTransform in_child = to_transform(call, "frame_in_child", spec.frame_in_child);
  std::array<CheckedAxis, 6> axes{};
  for (int i = 0; i < 6; ++i) {
    if (!is_open(spec.kind, i)) continue;
    axes[i] = check_axis(call, spec.axes[i], i, spec.kind);
  }

  auto entry = std::make_unique<JointEntry>();
  btRigidBody& a = *parent.body;
  btRigidBody& b = *child.body;
  entry->joint = make_joint(call, spec.kind, a, b, in_parent, in_child, axes, state.time_step);
  entry->kind = spec.kind;
  entry->frame_in_parent = in_parent;
  entry->frame_in_child = in_child;
  entry->parent = &parent;
  entry->child = &child;
  for (int i = 0; i < 6; ++i) {
    entry->has_motor[i] = axes[i].has_motor;
    if (is_open(spec.kind, i)) entry->axes += letter_of(axes[i]);
  }
  entry->joint->setJointFeedback(&entry->feedback);
  entry->joint->setUserConstraintId(static_cast<int>(state.joints.size()));
  entry->form = lockstep::form_of(*entry->joint, spec.kind, state.world.getSolverInfo());
  state.solver.leave_out(state.joints.size(),
                         entry->form.type.kind() != lockstep::JointType::FromPools);

  state.restructure();
  state.joints.push_back(std::move(entry));
  state.world.addConstraint(state.joints.back()->joint.get(), !spec.collide_connected);
  if (!spec.collide_connected) forget_contacts(state, a, b);
  ++parent.joints;
  ++child.joints;
  return JointId{static_cast<std::uint32_t>(state.joints.size() - 1)};
}

void World::remove_joint(JointId id) {
  State& state = changing();
  JointEntry& entry = state.joint(Call{"remove_joint"}, "id", id);
  entry.parent->body->activate();
  entry.child->body->activate();
  state.world.removeConstraint(entry.joint.get());
  --entry.parent->joints;
  --entry.child->joints;
  state.joints[id.slot].reset();
  state.restructure();
}

void World::set_motors(rust::Slice<const MotorCommand> commands) {
  const Call call{"set_motors"};
  State& state = *state_;
  // All are checked before any is carried out.
  for (std::size_t i = 0; i < commands.size(); ++i) {
    const MotorCommand& command = commands[i];
    const auto name = [&](const char* field) {
      return "commands[" + std::to_string(i) + "]." + field;
    };
    if (command.joint.slot >= state.joints.size() || !state.joints[command.joint.slot]) {
      state.joint(call, name("joint"), command.joint);
    }
    const auto axis = static_cast<std::size_t>(command.axis);
    if (axis >= 6 || !state.joints[command.joint.slot]->has_motor[axis]) {
      call.refuse(name("axis"), "one that was built with a motor",
                  axis < 6 ? kAxisNames[axis] : std::to_string(axis));
    }
    const bool fine = std::abs(command.target_velocity) <= kLargestNumber &&
                      command.max_force >= 0 && command.max_force <= kLargestNumber;
    if (!fine) {
      call.number(name("target_velocity"), command.target_velocity);
      call.non_negative(name("max_force"), command.max_force);
    }
  }
  for (const MotorCommand& command : commands) {
    const JointEntry& entry = *state.joints[command.joint.slot];
    set_motor(entry, int(command.axis), btScalar(command.target_velocity),
              btScalar(command.max_force), state.time_step);
    if (state.cohort) continue;  // where nobody sleeps
    entry.parent->body->activate();
    entry.child->body->activate();
  }
}

std::size_t World::joint_slots() const noexcept { return state_->joints.size(); }

void World::read_joints(rust::Slice<JointState> out) const {
  const State& state = settled();
  if (out.size() != state.joints.size()) {
    Call{"read_joints"}.refuse("out", std::to_string(state.joints.size()) + " entries long",
                               std::to_string(out.size()));
  }
  for (std::size_t slot = 0; slot < out.size(); ++slot) {
    const auto& entry = state.joints[slot];
    out[slot] = entry ? read_joint(*entry) : JointState{};
  }
}

void World::read_angles_of(rust::Slice<const JointId> ids, rust::Slice<double> out) const {
  const Call call{"read_angles_of"};
  if (out.size() != 3 * ids.size()) {
    call.refuse("out", std::to_string(3 * ids.size()) + " entries long",
                std::to_string(out.size()));
  }
  const auto& joints = state_->joints;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (ids[i].slot >= joints.size() || !joints[ids[i].slot]) {
      state_->joint(call, "ids[" + std::to_string(i) + "]", ids[i]);
    }
    const JointEntry& entry = *joints[ids[i].slot];
    const auto angles =
        state_->cohort ? state_->cohort->angles(state_->lane, ids[i].slot)
                       : angles_of(entry, entry.parent->body->getWorldTransform().getBasis(),
                                   entry.child->body->getWorldTransform().getBasis());
    std::copy(angles.begin(), angles.end(), out.begin() + std::ptrdiff_t(3 * i));
  }
}

}  // namespace itarl
