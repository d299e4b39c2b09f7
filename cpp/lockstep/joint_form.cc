#include "lockstep/joint_form.h"

#include "state.h"

namespace itarl::lockstep {

namespace {

// Bullet has no accessor; a derived class may name it.
struct SixAxes : btGeneric6DofSpring2Constraint {
  static int flags(const btGeneric6DofSpring2Constraint& joint, int axis) {
    return joint.*(&SixAxes::m_flags) >> (axis * BT_6DOF_FLAGS_AXIS_SHIFT2);
  }
};

// The order of the solver's rows.
constexpr int kAxisOrder[] = {3, 4, 5, 0, 1, 2};

// A joint's axis, linear or not.
struct Axis {
  btScalar lower, upper, bounce, erp, motor_erp, stiffness, damping, equilibrium, cfm, motor_cfm;
  bool motor, spring;
  JointType::Limit limit() const {
    return lower > upper ? JointType::Free : lower == upper ? JointType::Locked : JointType::Range;
  }
};

Axis axis_of(btGeneric6DofSpring2Constraint& joint, int i) {
  if (i >= 3) {
    const btRotationalLimitMotor2& of = *joint.getRotationalLimitMotor(i - 3);
    return {of.m_loLimit,  of.m_hiLimit,         of.m_bounce,        of.m_stopERP,
            of.m_motorERP, of.m_springStiffness, of.m_springDamping, of.m_equilibriumPoint,
            of.m_stopCFM,  of.m_motorCFM,        of.m_enableMotor,   of.m_enableSpring};
  }
  const btTranslationalLimitMotor2& of = *joint.getTranslationalLimitMotor();
  return {of.m_lowerLimit[i],    of.m_upperLimit[i],       of.m_bounce[i],
          of.m_stopERP[i],       of.m_motorERP[i],         of.m_springStiffness[i],
          of.m_springDamping[i], of.m_equilibriumPoint[i], of.m_stopCFM[i],
          of.m_motorCFM[i],      of.m_enableMotor[i],      of.m_enableSpring[i]};
}

// All axes as the solver will see them. What isn't set is the world's, but that Bullet takes for
// the softness what its first row has, once that is written.
std::array<Axis, 6> axes_of(btGeneric6DofSpring2Constraint& joint,
                            const btContactSolverInfo& info) {
  std::array<Axis, 6> axes;
  btScalar cfm = info.m_globalCfm;
  bool is_first = true;
  for (const int i : kAxisOrder) {
    Axis& axis = axes[std::size_t(i)];
    axis = axis_of(joint, i);
    const int flags = SixAxes::flags(joint, i);
    if ((flags & BT_6DOF_FLAGS_CFM_STOP2) == 0) axis.cfm = cfm;
    if ((flags & BT_6DOF_FLAGS_CFM_MOTO2) == 0) axis.motor_cfm = cfm;
    if ((flags & BT_6DOF_FLAGS_ERP_STOP2) == 0) axis.erp = info.m_erp;
    if ((flags & BT_6DOF_FLAGS_ERP_MOTO2) == 0) axis.motor_erp = info.m_erp;
    const bool limited = axis.limit() != JointType::Free;
    if (is_first && (limited || axis.motor || axis.spring)) {
      cfm = limited ? axis.cfm : axis.motor ? axis.motor_cfm : btScalar(0);
      is_first = false;
    }
  }
  return axes;
}

JointForm form_of_six_axes(btGeneric6DofSpring2Constraint& joint, const btContactSolverInfo& info) {
  JointForm form{JointType::of(JointType::SixAxes), {}};
  const std::array<Axis, 6> axes = axes_of(joint, info);
  for (const int i : kAxisOrder) {
    const Axis& axis = axes[std::size_t(i)];
    form.type.set_axis(i, axis.limit(), axis.motor, axis.spring);
    bool shares = false;
    const auto add = [&](btScalar cfm, bool free) {
      const bool rigid = cfm == 0;
      form.rows.push_back({rigid && i >= 3, rigid, free, shares});
      shares = i >= 3;
    };
    if (axis.limit() == JointType::Locked) add(axis.cfm, true);
    if (axis.limit() == JointType::Range) add(axis.cfm, false);
    if (axis.limit() == JointType::Range) add(axis.cfm, false);
    if (axis.motor) add(axis.motor_cfm, false);
    if (axis.spring) add(0, false);
  }
  return form;
}

// Of a slider's row, by its place. The last two are softer only where a stop holds.
btScalar slider_cfm(const btSliderConstraint& slider, int row, const btContactSolverInfo& info) {
  const int flags = slider.getFlags();
  const auto stop_cfm = [&](int axis) { return slider.getParam(BT_CONSTRAINT_STOP_CFM, axis); };
  if (row < 2 && (flags & BT_SLIDER_FLAGS_CFM_ORTANG) != 0) return stop_cfm(4);
  if (row == 0) return info.m_globalCfm;
  if ((row == 2 || row == 3) && (flags & BT_SLIDER_FLAGS_CFM_ORTLIN) != 0) return stop_cfm(1);
  if (row == 4 && (flags & BT_SLIDER_FLAGS_CFM_LIMLIN) != 0) return stop_cfm(0);
  if (row == 5 && (flags & BT_SLIDER_FLAGS_CFM_LIMANG) != 0) return stop_cfm(3);
  return 0;
}

JointForm form_of_slider(btSliderConstraint& slider, const btContactSolverInfo& info) {
  JointForm form{JointType::of(JointType::Slider), {}};
  const auto limit = [](btScalar lower, btScalar upper) {
    return lower > upper ? JointType::Free : lower == upper ? JointType::Locked : JointType::Range;
  };
  const auto along = limit(slider.getLowerLinLimit(), slider.getUpperLinLimit());
  const auto about = limit(slider.getLowerAngLimit(), slider.getUpperAngLimit());
  const bool slides = slider.getPoweredLinMotor(), turns = slider.getPoweredAngMotor();
  form.type.set_axis(0, along, slides, false);
  form.type.set_axis(3, about, turns, false);
  const auto add = [&](int row, bool angular, bool free) {
    const bool rigid = slider_cfm(slider, row, info) == 0;
    form.rows.push_back({rigid && angular, rigid, free, false});
  };
  add(0, true, true);
  add(1, true, true);
  add(2, false, true);
  add(3, false, true);
  if (along != JointType::Free || slides) add(4, false, along == JointType::Locked && !slides);
  if (about != JointType::Free || turns) add(5, true, about == JointType::Locked && !turns);
  return form;
}

void put_transform(const btTransform& transform, std::uint32_t place, const Put& put) {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) put(place++, transform.getBasis()[row][column]);
  }
  for (int i = 0; i < 3; ++i) put(place++, transform.getOrigin()[i]);
}

void put_slider(btSliderConstraint& slider, btScalar fps, const btContactSolverInfo& info,
                const Put& put) {
  put_transform(slider.getFrameOffsetA(), kSliderFrameA, put);
  put_transform(slider.getFrameOffsetB(), kSliderFrameB, put);
  const btScalar mass_a = slider.getRigidBodyA().getInvMass();
  const btScalar mass_b = slider.getRigidBodyB().getInvMass();
  const btScalar factor = mass_b / (mass_a + mass_b);
  put(kFactorA, factor);
  put(kFactorB, btScalar(1) - factor);
  const int flags = slider.getFlags();
  const auto held_rate = [&](bool own, btScalar softness) {
    return fps * (own ? softness : softness * info.m_erp);
  };
  put(kHeldAngularRate,
      held_rate((flags & BT_SLIDER_FLAGS_ERP_ORTANG) != 0, slider.getSoftnessOrthoAng()));
  put(kHeldLinearRate,
      held_rate((flags & BT_SLIDER_FLAGS_ERP_ORTLIN) != 0, slider.getSoftnessOrthoLin()));
  const auto stop = [&](std::uint32_t at, btScalar lower, btScalar upper, bool own,
                        btScalar softness, btScalar damping) {
    put(at + kStopLower, lower);
    put(at + kStopUpper, upper);
    put(at + kStopRate, fps * (own ? softness : info.m_erp));
    put(at + kStopSoftness, softness);
    put(at + kStopBounce, btFabs(btScalar(1) - damping));
  };
  stop(kLinearStop, slider.getLowerLinLimit(), slider.getUpperLinLimit(),
       (flags & BT_SLIDER_FLAGS_ERP_LIMLIN) != 0, slider.getSoftnessLimLin(),
       slider.getDampingLimLin());
  stop(kAngularStop, slider.getLowerAngLimit(), slider.getUpperAngLimit(),
       (flags & BT_SLIDER_FLAGS_ERP_LIMANG) != 0, slider.getSoftnessLimAng(),
       slider.getDampingLimAng());
  for (int row = 0; row < 6; ++row) {
    put(kSliderCfm + std::uint32_t(row), slider_cfm(slider, row, info));
  }
}

void put_six_axes(btGeneric6DofSpring2Constraint& joint, btScalar fps,
                  const btContactSolverInfo& info, const Put& put) {
  put_transform(joint.getFrameOffsetA(), kSixFrameA, put);
  put_transform(joint.getFrameOffsetB(), kSixFrameB, put);
  put(kMassA, btScalar(1) / joint.getRigidBodyA().getInvMass());
  put(kMassB, btScalar(1) / joint.getRigidBodyB().getInvMass());
  // The flag that an axis of rotation about y has a softness of its own is this one, too.
  put(kEndless, btScalar((SixAxes::flags(joint, 0) & BT_6DOF_FLAGS_USE_INFINITE_ERROR) != 0));
  const std::array<Axis, 6> axes = axes_of(joint, info);
  for (std::uint32_t i = 0; i < 6; ++i) {
    const Axis& axis = axes[i];
    const auto set = [&](std::uint32_t which, btScalar number) {
      put(kAxes + i * kAxisNumbers + which, number);
    };
    set(kAxisLower, axis.lower);
    set(kAxisUpper, axis.upper);
    set(kAxisErp, axis.erp);
    set(kAxisRate, fps * axis.erp);
    set(kAxisBounce, axis.bounce);
    set(kAxisMotorRate, fps * axis.motor_erp);
    set(kAxisStiffness, axis.stiffness);
    set(kAxisDamping, axis.damping);
    set(kAxisEquilibrium, axis.equilibrium);
    set(kAxisStopCfm, axis.cfm);
    set(kAxisMotorCfm, axis.motor_cfm);
  }
}

}  // namespace

JointForm form_of(btTypedConstraint& joint, JointKind kind, const btContactSolverInfo& info) {
  // Bullet treats heavier ones like what doesn't move.
  const auto moves = [](const btRigidBody& body) {
    return !body.isStaticOrKinematicObject() && body.getInvMass() >= SIMD_EPSILON;
  };
  if (!moves(joint.getRigidBodyA()) || !moves(joint.getRigidBodyB())) return {};
  JointForm form;
  if (kind == JointKind::Slider) {
    form = form_of_slider(static_cast<btSliderConstraint&>(joint), info);
  } else if (kind == JointKind::Fixed || kind == JointKind::SixDofSpring) {
    form = form_of_six_axes(static_cast<btGeneric6DofSpring2Constraint&>(joint), info);
  }
  // All of whose axes are free.
  if (form.rows.empty()) return {};
  return form;
}

std::uint32_t numbers_of(JointType type) {
  switch (type.kind()) {
    case JointType::Slider:
      return kSliderNumbers;
    case JointType::SixAxes:
      return kSixAxesNumbers;
    default:
      return 0;
  }
}

void put_numbers(btTypedConstraint& joint, JointType type, btScalar time_step,
                 const btContactSolverInfo& info, const Put& put) {
  const btScalar fps = 1.f / time_step;
  if (type.kind() == JointType::Slider) {
    put_slider(static_cast<btSliderConstraint&>(joint), fps, info, put);
  } else {
    put_six_axes(static_cast<btGeneric6DofSpring2Constraint&>(joint), fps, info, put);
  }
}

}  // namespace itarl::lockstep
