// The solver's rows of joints, made in fewer steps than Bullet makes them.
//
// btSequentialImpulseConstraintSolver::convertJoint multiplies each row by the bodies' inertia
// twice, and does so again for every row about one axis. Here each product is made once. What is
// left is done in Bullet's order, so that all numbers have the same bits; the factors that bodies
// may have on velocities are 1, since the crate doesn't set them, and a product with 1 is exact.
#include <cmath>
#include <cstring>

#include "pausing.h"

namespace itarl {

namespace {

// A vector or a column of a matrix, in one register.
typedef btScalar Four __attribute__((vector_size(4 * sizeof(btScalar))));

// btVector3 has a fourth number, which nobody reads.
Four load(const btVector3& v) {
  Four four;
  std::memcpy(&four, v.m_floats, sizeof four);
  return four;
}
void store(btVector3& to, Four four) { std::memcpy(to.m_floats, &four, sizeof four); }

// What all rows of a joint need of a body.
struct Side {
  Four columns[3];  // of the inverse inertia
  btScalar inverse_mass;
  btVector3 linear, angular;  // velocities, with what forces add in this step

  Side(const btRigidBody& body, const btSolverBody& solver) : inverse_mass(body.getInvMass()) {
    const btMatrix3x3& inertia = body.getInvInertiaTensorWorld();
    for (int i = 0; i < 3; ++i) columns[i] = load(inertia.getColumn(i));
    const bool moves = solver.m_originalBody != nullptr;
    const btVector3 none(0, 0, 0);
    linear = body.getLinearVelocity() + (moves ? solver.m_externalForceImpulse : none);
    angular = body.getAngularVelocity() + (moves ? solver.m_externalTorqueImpulse : none);
  }

  Four inertia_times(const btVector3& v) const {
    return columns[0] * v.x() + columns[1] * v.y() + columns[2] * v.z();
  }
};

bool is_same(const btVector3& a, const btVector3& b) {
  return std::memcmp(a.m_floats, b.m_floats, 3 * sizeof(btScalar)) == 0;
}

bool has_same_jacobian(const btSolverConstraint& a, const btSolverConstraint& b) {
  return is_same(a.m_relpos1CrossNormal, b.m_relpos1CrossNormal) &&
         is_same(a.m_relpos2CrossNormal, b.m_relpos2CrossNormal) &&
         is_same(a.m_contactNormal1, b.m_contactNormal1) &&
         is_same(a.m_contactNormal2, b.m_contactNormal2);
}

}  // namespace

void PausingSolver::convertJoints(btTypedConstraint** constraints, int count,
                              const btContactSolverInfo& info) {
  left_out_.assign(std::size_t(count), false);
  leaves_any_out_ = false;
  if (!pauses_ || !has_known_arithmetic()) {
    btSequentialImpulseConstraintSolver::convertJoints(constraints, count, info);
    return;
  }
  for (int i = 0; i < count; ++i) {
    const auto joint = std::size_t(constraints[i]->getUserConstraintId());
    if (is_observed()) break;  // an observer looks at all of them
    if (joint >= in_lanes_.size() || !in_lanes_[joint] || !constraints[i]->isEnabled()) continue;
    left_out_[std::size_t(i)] = true;
    leaves_any_out_ = true;
  }
  prepare_joints(constraints, count, info);
}

// Of all joints whose rows aren't left out.
void PausingSolver::prepare_joints(btTypedConstraint** constraints, int count,
                               const btContactSolverInfo& info) {
  m_tmpConstraintSizesPool.resizeNoInitialize(count);
  int total = 0;
  for (int i = 0; i < count; ++i) {
    btTypedConstraint& constraint = *constraints[i];
    btTypedConstraint::btConstraintInfo1& size = m_tmpConstraintSizesPool[i];
    size.m_numConstraintRows = 0;
    size.nub = 0;
    if (is_left_out(i)) continue;
    constraint.buildJacobian();
    constraint.internalSetAppliedImpulse(0);
    if (btJointFeedback* const feedback = constraint.getJointFeedback()) {
      feedback->m_appliedForceBodyA.setZero();
      feedback->m_appliedTorqueBodyA.setZero();
      feedback->m_appliedForceBodyB.setZero();
      feedback->m_appliedTorqueBodyB.setZero();
    }
    if (constraint.isEnabled()) constraint.getInfo1(&size);
    total += size.m_numConstraintRows;
  }
  m_tmpSolverNonContactConstraintPool.resizeNoInitialize(total);
  int row = 0;
  for (int i = 0; i < count; ++i) {
    const int rows = m_tmpConstraintSizesPool[i].m_numConstraintRows;
    if (rows > 0) make_rows(*constraints[i], row, rows, info);
    row += rows;
  }
}

// With the rows that were left out. Nothing has moved since, so that they're what they would have
// been; and the order of the pool's rows is Bullet's.
void PausingSolver::make_all_rows(const btContactSolverInfo& info) {
  left_out_.assign(left_out_.size(), false);
  leaves_any_out_ = false;
  prepare_joints(constraints_.data(), int(constraints_.size()), info);
  const int total = m_tmpSolverNonContactConstraintPool.size();
  m_orderNonContactConstraintPool.resizeNoInitialize(total);
  for (int i = 0; i < total; ++i) m_orderNonContactConstraintPool[i] = i;
}

namespace {

// Has a constraint write its Jacobians, limits and errors into its rows; the damping of their speeds.
btScalar ask(btTypedConstraint& constraint, btSolverConstraint* rows,
             const btContactSolverInfo& info) {
  btTypedConstraint::btConstraintInfo2 to;
  to.fps = 1.f / info.m_timeStep;
  to.erp = info.m_erp;
  to.m_J1linearAxis = rows->m_contactNormal1;
  to.m_J1angularAxis = rows->m_relpos1CrossNormal;
  to.m_J2linearAxis = rows->m_contactNormal2;
  to.m_J2angularAxis = rows->m_relpos2CrossNormal;
  to.rowskip = sizeof(btSolverConstraint) / sizeof(btScalar);
  to.m_constraintError = &rows->m_rhs;
  rows->m_cfm = info.m_globalCfm;
  to.m_damping = info.m_damping;
  to.cfm = &rows->m_cfm;
  to.m_lowerLimit = &rows->m_lowerLimit;
  to.m_upperLimit = &rows->m_upperLimit;
  to.m_numIterations = info.m_numIterations;
  constraint.getInfo2(&to);
  return to.m_damping;
}

}  // namespace

void PausingSolver::make_rows(btTypedConstraint& constraint, int first, int count,
                          const btContactSolverInfo& info) {
  const int a = getOrInitSolverBody(constraint.getRigidBodyA(), info.m_timeStep);
  const int b = getOrInitSolverBody(constraint.getRigidBodyB(), info.m_timeStep);
  const int asked = constraint.getOverrideNumSolverIterations();
  const int iterations = asked > 0 ? asked : info.m_numIterations;
  m_maxOverrideNumSolverIterations = btMax(m_maxOverrideNumSolverIterations, iterations);

  btSolverConstraint* const rows = &m_tmpSolverNonContactConstraintPool[first];
  std::memset(static_cast<void*>(rows), 0, sizeof(btSolverConstraint) * std::size_t(count));
  for (int i = 0; i < count; ++i) {
    rows[i].m_lowerLimit = -SIMD_INFINITY;
    rows[i].m_upperLimit = SIMD_INFINITY;
    rows[i].m_solverBodyIdA = a;
    rows[i].m_solverBodyIdB = b;
    rows[i].m_overrideNumSolverIterations = iterations;
  }

  const btScalar damping = ask(constraint, rows, info);

  const Side first_side(constraint.getRigidBodyA(), m_tmpSolverBodyPool[a]);
  const Side second_side(constraint.getRigidBodyB(), m_tmpSolverBodyPool[b]);
  const btScalar most = constraint.getBreakingImpulseThreshold();
  btScalar speed = 0;
  for (int i = 0; i < count; ++i) {
    btSolverConstraint& row = rows[i];
    if (row.m_upperLimit >= most) row.m_upperLimit = most;
    if (row.m_lowerLimit <= -most) row.m_lowerLimit = -most;
    row.m_originalContactPoint = &constraint;
    const btVector3 &n1 = row.m_contactNormal1, &n2 = row.m_contactNormal2;
    const btVector3 &r1 = row.m_relpos1CrossNormal, &r2 = row.m_relpos2CrossNormal;
    if (i > 0 && has_same_jacobian(row, rows[i - 1])) {
      row.m_angularComponentA = rows[i - 1].m_angularComponentA;
      row.m_angularComponentB = rows[i - 1].m_angularComponentB;
      row.m_jacDiagABInv = rows[i - 1].m_jacDiagABInv;
    } else {
      store(row.m_angularComponentA, first_side.inertia_times(r1));
      store(row.m_angularComponentB, second_side.inertia_times(r2));
      btScalar sum = (n1 * first_side.inverse_mass).dot(n1);
      sum += row.m_angularComponentA.dot(r1);
      sum += (n2 * second_side.inverse_mass).dot(n2);
      sum += row.m_angularComponentB.dot(r2);
      row.m_jacDiagABInv = btFabs(sum) > SIMD_EPSILON ? btScalar(1) / sum : 0;
      const btScalar first_speed = n1.dot(first_side.linear) + r1.dot(first_side.angular);
      const btScalar second_speed = n2.dot(second_side.linear) + r2.dot(second_side.angular);
      speed = first_speed + second_speed;
    }
    const btScalar position_error = row.m_rhs;  // from getInfo2
    const btScalar speed_error = btScalar(0) - speed * damping;
    row.m_rhs = position_error * row.m_jacDiagABInv + speed_error * row.m_jacDiagABInv;
  }
}

// As writeBackJoints, but for terms that are zero; sums that begin at +0 don't notice those.
void PausingSolver::report_joints() {
  const btScalar per_second = btScalar(1) / info_->m_timeStep;
  const auto add = [per_second](btVector3& to, const btVector3& direction, btScalar impulse) {
    store(to, load(to) + load(direction) * impulse * per_second);
  };
  for (int i = 0; i < m_tmpSolverNonContactConstraintPool.size(); ++i) {
    const btSolverConstraint& row = m_tmpSolverNonContactConstraintPool[i];
    auto& constraint = *static_cast<btTypedConstraint*>(row.m_originalContactPoint);
    const btScalar impulse = row.m_appliedImpulse;
    btJointFeedback* const feedback = constraint.getJointFeedback();
    if (feedback != nullptr && impulse != 0) {
      const bool moves = !row.m_contactNormal1.isZero() || !row.m_contactNormal2.isZero();
      if (moves || !std::isfinite(impulse)) {  // infinity times zero isn't zero
        add(feedback->m_appliedForceBodyA, row.m_contactNormal1, impulse);
        add(feedback->m_appliedForceBodyB, row.m_contactNormal2, impulse);
      }
      add(feedback->m_appliedTorqueBodyA, row.m_relpos1CrossNormal, impulse);
      add(feedback->m_appliedTorqueBodyB, row.m_relpos2CrossNormal, impulse);
    }
    constraint.internalSetAppliedImpulse(impulse);
    if (btFabs(impulse) >= constraint.getBreakingImpulseThreshold()) constraint.setEnabled(false);
  }
}

}  // namespace itarl
