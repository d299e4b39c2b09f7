// Bullet's step, cut in two around the solver's iterations.
//
// Until told to pause, both classes are Bullet's own. A step in two halves makes the calls of
// stepSimulation(time_step, 0) in their order, but for those that would change nothing, so that one
// whose middle is done by the solver's own loop has the bits of an uncut one.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <vector>

#include "broadphase.h"

namespace itarl {

// Sees a joint's rows once they're solved, before Bullet forgets them.
class JointRowObserver {
 public:
  virtual void see(const btTypedConstraint& joint, const btSolverConstraint* rows, int count,
                   const btSolverBody& a, const btSolverBody& b) = 0;

 protected:
  ~JointRowObserver() = default;
};

class PausingSolver final : public btSequentialImpulseConstraintSolver {
 public:
  // Stops after setting up, if pausing, and leaves the rows in the pools.
  //
  // Bullet may call this several times in a step, with groups of bodies that share no row; all but
  // the last are then solved here, on the spot, as Bullet would.
  btScalar solveGroup(btCollisionObject** bodies, int body_count, btPersistentManifold** manifolds,
                      int manifold_count, btTypedConstraint** constraints, int constraint_count,
                      const btContactSolverInfo& info, btIDebugDraw* drawer,
                      btDispatcher* dispatcher) override;

  // Null for none, as in the beginning.
  void set_observer(JointRowObserver* observer) { observer_ = observer; }
  bool is_observed() const { return observer_ != nullptr; }

  void set_pausing(bool pauses);
  // Whether rows wait in the pools.
  bool waits() const { return waits_; }
  // Groups that were solved on the spot since pausing was switched on.
  int separate_groups() const { return separate_groups_; }
  // The part of Bullet's iterations that resolves deep penetrations, apart from the velocities.
  void split_impulses();
  // Bullet's own iterations over all rows.
  void iterate();
  // Forgets the rows, after something that went wrong half way.
  void abandon();
  // Whether Bullet's rows are swept by the scalar code that lanes repeat, without fused multiply-add:
  // on x86-64, unless Bullet was built with vector rows, which Debian's isn't.
  bool has_known_arithmetic();
  // Hands impulses from the pools to contacts and joints, and velocities to bodies unless these have
  // been moved already.
  void finish(bool moved);

  // Leaves out a joint's rows when setting up, if pausing: lanes make them (lockstep/gatherer.h).
  // iterate() makes up for it.
  void leave_out(std::size_t joint, bool leaves_out);
  // By constraint, whether its rows were left out.
  bool is_left_out(int constraint) const { return left_out_[std::size_t(constraint)]; }

  // By body slot, if lanes have worked them out for this step (lockstep/gyroscopic.h).
  std::vector<btVector3>& gyroscopic_impulses() { return gyroscopic_impulses_; }

  // What waits, for lockstep/packing.cc.
  btAlignedObjectArray<btSolverBody>& bodies() { return m_tmpSolverBodyPool; }
  btConstraintArray& joint_rows() { return m_tmpSolverNonContactConstraintPool; }
  btConstraintArray& contact_rows() { return m_tmpSolverContactConstraintPool; }
  btConstraintArray& friction_rows() { return m_tmpSolverContactFrictionConstraintPool; }
  const btConstraintArray& rolling_rows() const {
    return m_tmpSolverContactRollingFrictionConstraintPool;
  }
  // By constraint, how many rows it has in joint_rows().
  int rows_of(int constraint) const {
    return m_tmpConstraintSizesPool[constraint].m_numConstraintRows;
  }
  const std::vector<btTypedConstraint*>& constraints() const { return constraints_; }
  const btContactSolverInfo& info() const { return *info_; }

 protected:
  btScalar solveGroupCacheFriendlyFinish(btCollisionObject** bodies, int body_count,
                                         const btContactSolverInfo& info) override;
  void convertBodies(btCollisionObject** bodies, int count,
                     const btContactSolverInfo& info) override;
  // joint_rows.cc
  void convertJoints(btTypedConstraint** constraints, int count,
                     const btContactSolverInfo& info) override;

 private:
  void clear();
  void show_joints();
  void report_joints();
  void prepare_joints(btTypedConstraint** constraints, int count, const btContactSolverInfo& info);
  void make_all_rows(const btContactSolverInfo& info);
  void make_rows(btTypedConstraint& constraint, int first, int count,
                 const btContactSolverInfo& info);

  JointRowObserver* observer_ = nullptr;
  bool pauses_ = false;
  bool waits_ = false;
  int separate_groups_ = 0;
  std::vector<btVector3> gyroscopic_impulses_;
  std::vector<bool> in_lanes_;  // by joint
  std::vector<bool> left_out_;  // by constraint of the group
  bool leaves_any_out_ = false;
  // The arguments of the group that waits.
  std::vector<btCollisionObject*> group_;
  std::vector<btPersistentManifold*> manifolds_;
  std::vector<btTypedConstraint*> constraints_;
  const btContactSolverInfo* info_ = nullptr;
};

class PausingWorld final : public btDiscreteDynamicsWorld {
 public:
  PausingWorld(btCollisionDispatcher* dispatcher, Broadphase* broadphase, PausingSolver* solver,
           btCollisionConfiguration* configuration)
      : btDiscreteDynamicsWorld(dispatcher, broadphase, solver, configuration),
        dispatcher_(*dispatcher),
        broadphase_(*broadphase),
        solver_(*solver) {}

  // Up to where the solver is set up.
  void begin_step(btScalar time_step);
  // Up to its iterations.
  void set_up_solver(btScalar time_step);
  // What comes after them.
  void end_step(btScalar time_step);
  // The same where the bodies have been moved already.
  void end_moved_step();
  // Those that aren't static, kinematic ones among them.
  int moving_bodies() const { return m_nonStaticRigidBodies.size(); }

 private:
  // collisions.cc
  void predict_motion(btScalar time_step);
  void find_contacts();
  bool needs_box(const btCollisionObject& object);
  bool stays_apart(const btBroadphasePair& pair);

  btCollisionDispatcher& dispatcher_;
  Broadphase& broadphase_;
  PausingSolver& solver_;
  btManifoldArray found_;  // of one pair
};

}  // namespace itarl
