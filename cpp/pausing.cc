// The calls between the cuts are those of btDiscreteDynamicsWorld.cpp and
// btSequentialImpulseConstraintSolver.cpp of Bullet 3.24.
#include "pausing.h"

namespace itarl {

void PausingSolver::set_pausing(bool pauses) {
  pauses_ = pauses;
  if (pauses) {
    waits_ = false;
    separate_groups_ = 0;
  } else {
    gyroscopic_impulses_.clear();
  }
}

btScalar PausingSolver::solveGroup(btCollisionObject** bodies, int body_count,
                               btPersistentManifold** manifolds, int manifold_count,
                               btTypedConstraint** constraints, int constraint_count,
                               const btContactSolverInfo& info, btIDebugDraw* drawer,
                               btDispatcher* dispatcher) {
  if (!pauses_) {
    return btSequentialImpulseConstraintSolver::solveGroup(bodies, body_count, manifolds,
                                                           manifold_count, constraints,
                                                           constraint_count, info, drawer,
                                                           dispatcher);
  }
  if (body_count + manifold_count + constraint_count == 0) return 0;
  if (waits_) {
    iterate();
    finish(false);
    ++separate_groups_;
  }
  group_.assign(bodies, bodies + body_count);
  manifolds_.assign(manifolds, manifolds + manifold_count);
  constraints_.assign(constraints, constraints + constraint_count);
  info_ = &info;
  solveGroupCacheFriendlySetup(bodies, body_count, manifolds, manifold_count, constraints,
                               constraint_count, info, drawer);
  // As the first iteration does: joints without rows get solver bodies, too. A body that is in the
  // pool for this alone has its velocities written back, which makes zeros positive.
  for (btTypedConstraint* const constraint : constraints_) {
    if (!constraint->isEnabled()) continue;
    getOrInitSolverBody(constraint->getRigidBodyA(), info.m_timeStep);
    getOrInitSolverBody(constraint->getRigidBodyB(), info.m_timeStep);
  }
  split_impulses();
  waits_ = true;
  return 0;
}

// As Bullet's, with impulses that are known already.
void PausingSolver::convertBodies(btCollisionObject** bodies, int count,
                              const btContactSolverInfo& info) {
  if (!pauses_ || gyroscopic_impulses_.empty()) {
    btSequentialImpulseConstraintSolver::convertBodies(bodies, count, info);
    return;
  }
  for (int i = 0; i < count; ++i) bodies[i]->setCompanionId(-1);
  m_kinematicBodyUniqueIdToSolverBodyTable.resize(0);
  m_tmpSolverBodyPool.reserve(count + 1);
  m_tmpSolverBodyPool.resizeNoInitialize(0);
  for (int i = 0; i < count; ++i) {
    const int place = getOrInitSolverBody(*bodies[i], info.m_timeStep);
    const btRigidBody* const body = btRigidBody::upcast(bodies[i]);
    if (body == nullptr || body->getInvMass() == 0) continue;
    m_tmpSolverBodyPool[place].m_externalTorqueImpulse +=
        gyroscopic_impulses_[std::size_t(body->getUserIndex())];
  }
}

void PausingSolver::split_impulses() {
  solveGroupCacheFriendlySplitImpulseIterations(
      group_.data(), int(group_.size()), manifolds_.data(), int(manifolds_.size()),
      constraints_.data(), int(constraints_.size()), *info_, nullptr);
}

void PausingSolver::leave_out(std::size_t joint, bool leaves_out) {
  if (in_lanes_.size() <= joint) in_lanes_.resize(joint + 1, false);
  in_lanes_[joint] = leaves_out;
}

void PausingSolver::iterate() {
  if (leaves_any_out_) make_all_rows(*info_);
  const int most = btMax(m_maxOverrideNumSolverIterations, info_->m_numIterations);
  for (int iteration = 0; iteration < most; ++iteration) {
    m_leastSquaresResidual = solveSingleIteration(
        iteration, group_.data(), int(group_.size()), manifolds_.data(), int(manifolds_.size()),
        constraints_.data(), int(constraints_.size()), *info_, nullptr);
    if (m_leastSquaresResidual <= info_->m_leastSquaresResidualThreshold) break;
  }
}

btScalar PausingSolver::solveGroupCacheFriendlyFinish(btCollisionObject** bodies, int body_count,
                                                  const btContactSolverInfo& info) {
  show_joints();
  return btSequentialImpulseConstraintSolver::solveGroupCacheFriendlyFinish(bodies, body_count,
                                                                            info);
}

// Bullet puts the rows of a joint one after the other.
void PausingSolver::show_joints() {
  if (observer_ == nullptr) return;
  const int all = m_tmpSolverNonContactConstraintPool.size();
  for (int row = 0, count = 0; row < all; row += count) {
    const btSolverConstraint& first = m_tmpSolverNonContactConstraintPool[row];
    count = 1;
    while (row + count < all && m_tmpSolverNonContactConstraintPool[row + count]
                                        .m_originalContactPoint == first.m_originalContactPoint) {
      ++count;
    }
    observer_->see(*static_cast<btTypedConstraint*>(first.m_originalContactPoint), &first, count,
                   m_tmpSolverBodyPool[first.m_solverBodyIdA],
                   m_tmpSolverBodyPool[first.m_solverBodyIdB]);
  }
}

void PausingSolver::finish(bool moved) {
  show_joints();
  // solveGroupCacheFriendlyFinish
  if ((info_->m_solverMode & SOLVER_USE_WARMSTARTING) != 0) {
    writeBackContacts(0, m_tmpSolverContactConstraintPool.size(), *info_);
  }
  if (has_known_arithmetic()) {
    report_joints();
  } else {
    writeBackJoints(0, m_tmpSolverNonContactConstraintPool.size(), *info_);
  }
  if (!moved) writeBackBodies(0, m_tmpSolverBodyPool.size(), *info_);
  clear();
}

void PausingSolver::abandon() {
  set_pausing(false);
  clear();
}

void PausingSolver::clear() {
  m_tmpSolverContactConstraintPool.resizeNoInitialize(0);
  m_tmpSolverNonContactConstraintPool.resizeNoInitialize(0);
  m_tmpSolverContactFrictionConstraintPool.resizeNoInitialize(0);
  m_tmpSolverContactRollingFrictionConstraintPool.resizeNoInitialize(0);
  m_tmpSolverBodyPool.resizeNoInitialize(0);
  leaves_any_out_ = false;
  waits_ = false;
}

bool PausingSolver::has_known_arithmetic() {
#ifdef __x86_64__
  return getActiveConstraintRowSolverGeneric() == getScalarConstraintRowSolverGeneric() &&
         getActiveConstraintRowSolverLowerLimit() == getScalarConstraintRowSolverLowerLimit();
#else
  return false;
#endif
}

void PausingWorld::begin_step(btScalar time_step) {
  // stepSimulation(time_step, 0)
  m_localTime = 0;
  m_fixedTimeStep = 0;
  saveKinematicState(time_step);
  applyGravity();
  // internalSingleStepSimulation
  predict_motion(time_step);
  btDispatcherInfo& dispatch = getDispatchInfo();
  dispatch.m_timeStep = time_step;
  dispatch.m_stepCount = 0;
  dispatch.m_debugDraw = nullptr;
  // No body is let have predictive contacts: createPredictiveContacts would find none.
  find_contacts();
  calculateSimulationIslands();
}

void PausingWorld::set_up_solver(btScalar time_step) {
  getSolverInfo().m_timeStep = time_step;
  solver_.set_pausing(true);
  solveConstraints(getSolverInfo());
  solver_.set_pausing(false);
}

void PausingWorld::end_step(btScalar time_step) {
  if (solver_.waits()) solver_.finish(false);
  integrateTransforms(time_step);
  updateActions(time_step);
  updateActivationState(time_step);
  // No body has a motion state to synchronise.
  clearForces();
}

void PausingWorld::end_moved_step() {
  solver_.finish(true);
  // There are no actions, and no body that could fall asleep.
}

}  // namespace itarl
