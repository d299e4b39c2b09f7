#include "lockstep/world_rows.h"

#include <limits>

#ifdef __SSE2__
#include <immintrin.h>
#endif

#include "state.h"

namespace itarl::lockstep {

namespace {

// Of the three numbers of each vector; zeros of either sign are alike.
#if defined(__SSE2__) && !defined(ITARL_FLOAT64)
__m128 load(const btVector3& v) { return _mm_load_ps(v.m_floats); }
bool all(__m128 mask) { return (_mm_movemask_ps(mask) & 7) == 7; }
bool are_zero(const btVector3& a, const btVector3& b) {
  const __m128 zero = _mm_setzero_ps();
  return all(_mm_and_ps(_mm_cmpeq_ps(load(a), zero), _mm_cmpeq_ps(load(b), zero)));
}
bool are_opposite(const btVector3& a, const btVector3& b) {
  return all(_mm_cmpeq_ps(load(a), _mm_xor_ps(load(b), _mm_set1_ps(-0.f))));
}
bool are_same(const btVector3& a, const btVector3& b) {
  return all(_mm_cmpeq_ps(load(a), load(b)));
}
#else
bool are_same(const btVector3& a, const btVector3& b) {
  return a.x() == b.x() && a.y() == b.y() && a.z() == b.z();
}
bool are_zero(const btVector3& a, const btVector3& b) {
  const btVector3 zero(0, 0, 0);
  return are_same(a, zero) && are_same(b, zero);
}
bool are_opposite(const btVector3& a, const btVector3& b) { return are_same(a, -b); }
#endif

// What a joint's row is; `before` is the joint's row before it.
Form form_of(const btSolverConstraint& row, const btSolverConstraint* before) {
  const bool rigid = row.m_cfm == 0;
  Form form;
  form.angular = rigid && are_zero(row.m_contactNormal1, row.m_contactNormal2) &&
                 are_opposite(row.m_relpos1CrossNormal, row.m_relpos2CrossNormal);
  form.full = rigid && are_opposite(row.m_contactNormal1, row.m_contactNormal2);
  form.free = row.m_lowerLimit <= -SIMD_INFINITY && row.m_upperLimit >= SIMD_INFINITY;
  form.shares =
      before != nullptr && are_same(row.m_relpos1CrossNormal, before->m_relpos1CrossNormal);
  return form;
}

// Whether a row can be swept: 1 / k must be a number, since Bullet's residual would be none, and
// its early end another; and the limits must leave something between them.
bool is_sound(const btSolverConstraint& row) {
  const btScalar k = row.m_jacDiagABInv;
  return k >= std::numeric_limits<btScalar>::min() && k <= std::numeric_limits<btScalar>::max() &&
         row.m_lowerLimit <= row.m_upperLimit;
}

}  // namespace

void WorldRows::read(State& state, const std::vector<std::uint32_t>& dynamic_ids,
                     std::size_t structure) {
  state_ = &state;
  solver_ = &state.solver;
  signature_.structure = structure;
  const int mode = solver_->info().m_solverMode;
  covered_ = solver_->has_known_arithmetic() && (mode & SOLVER_RANDMIZE_ORDER) == 0 &&
             solver_->rolling_rows().size() == 0;
  moved_ = false;
  if (!covered_) return;
  read_bodies(dynamic_ids);
  read_joints();
  read_contacts();
}

void WorldRows::read_bodies(const std::vector<std::uint32_t>& dynamic_ids) {
  auto& pool = solver_->bodies();
  std::uint32_t count = 0;
  for (const std::uint32_t dynamic_id : dynamic_ids) count += dynamic_id != kNoBody;
  bodies_.assign(count, nullptr);
  dynamic_id_of_.assign(std::size_t(pool.size()), kNoBody);
  for (int i = 0; i < pool.size(); ++i) {
    const btRigidBody* const body = pool[i].m_originalBody;
    const std::uint32_t dynamic_id = body == nullptr ? kNoBody : dynamic_ids[slot_of(*body)];
    dynamic_id_of_[std::size_t(i)] = dynamic_id;
    if (dynamic_id != kNoBody) bodies_[dynamic_id] = &pool[i];
  }
  const auto is_zero = [](const btVector3& v) { return v.x() == 0 && v.y() == 0 && v.z() == 0; };
  // An observer of rows looks at the solver's bodies, too.
  can_move_ = !solver_->is_observed() && state_->world.moving_bodies() == int(count);
  for (btSolverBody* const body : bodies_) {
    can_move_ = can_move_ && body != nullptr &&
                body->m_originalBody->getActivationState() == DISABLE_DEACTIVATION &&
                is_zero(body->internalGetPushVelocity()) &&
                is_zero(body->internalGetTurnVelocity());
  }
}

void WorldRows::read_joints() {
  const auto& constraints = solver_->constraints();
  auto& pool = solver_->joint_rows();
  signature_.joints.clear();
  first_row_.clear();
  row_counts_.clear();
  forms_.clear();
  int row = 0;
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    const bool left_out = solver_->is_left_out(int(i));
    const int rows = solver_->rows_of(int(i));
    if (rows == 0 && !left_out) continue;
    btTypedConstraint& constraint = *constraints[i];
    const auto joint = std::uint32_t(constraint.getUserConstraintId());
    first_row_.push_back(std::uint32_t(row));
    if (left_out) {
      const JointForm& form = state_->joints[joint]->form;
      signature_.joints.push_back({joint, dynamic_id(constraint.getRigidBodyA().getCompanionId()),
                                   dynamic_id(constraint.getRigidBodyB().getCompanionId()),
                                   form.type});
      row_counts_.push_back(std::uint32_t(form.rows.size()));
      continue;
    }
    signature_.joints.push_back(
        {joint, dynamic_id(pool[row].m_solverBodyIdA), dynamic_id(pool[row].m_solverBodyIdB), {}});
    row_counts_.push_back(std::uint32_t(rows));
    for (int k = row; k < row + rows; ++k) {
      forms_.push_back(form_of(pool[k], k > row ? &pool[k - 1] : nullptr));
      if (!is_sound(pool[k])) covered_ = false;
    }
    row += rows;
  }
}

Form WorldRows::form_in_lanes(std::uint32_t joint, std::uint32_t number) const {
  return state_->joints[joint]->form.rows[number];
}

void WorldRows::read_contacts() {
  auto& pool = solver_->contact_rows();
  contacts_.assign(bodies_.size(), 0);
  pairs_.clear();
  bool touch = false;  // two moving bodies
  for (int i = 0; i < pool.size(); ++i) {
    const std::uint32_t a = dynamic_id(pool[i].m_solverBodyIdA),
                        b = dynamic_id(pool[i].m_solverBodyIdB);
    pairs_.push_back(a == kNoBody ? ContactKey{b, a} : ContactKey{a, b});
    if (a != kNoBody && b != kNoBody) {
      touch = true;
    } else {
      ++contacts_[a == kNoBody ? b : a];
    }
    if (!is_sound(pool[i])) covered_ = false;
  }
  auto& frictions = solver_->friction_rows();
  for (int i = 0; i < frictions.size(); ++i) {
    if (!is_sound(frictions[i])) covered_ = false;
  }
  signature_.contacts.clear();
  if (touch) signature_.contacts = pairs_;
}

void WorldRows::assign_rows(const RowLayout& layout) {
  const std::vector<PlacedRow>& rows = layout.rows();
  rows_.assign(rows.size(), nullptr);
  const btSolverConstraint* const joints =
      solver_->joint_rows().size() > 0 ? &solver_->joint_rows()[0] : nullptr;
  pool_contact_.assign(layout.contact_count(), -1);
  seen_.assign(bodies_.size(), 0);
  for (std::size_t contact = 0; contact < pairs_.size(); ++contact) {
    const std::uint32_t body = pairs_[contact].a;
    const std::size_t place =
        layout.lists_contacts() ? contact : layout.contact_index(body, seen_[body]++);
    pool_contact_[place] = int(contact);
  }
  for (const std::uint32_t i : layout.pool_rows()) {
    if (i < layout.joint_row_count()) {
      const std::uint32_t joint = rows[i].owner;
      if (rows[i].part < row_counts_[joint]) rows_[i] = joints + first_row_[joint] + rows[i].part;
      continue;
    }
    const int contact = pool_contact_[rows[i].owner];
    if (contact < 0) continue;
    const btSolverConstraint& row = solver_->contact_rows()[contact];
    rows_[i] = rows[i].part == 0
                   ? &row
                   : &solver_->friction_rows()[row.m_frictionIndex + int(rows[i].part) - 1];
  }
}

}  // namespace itarl::lockstep
