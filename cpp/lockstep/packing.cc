#include "lockstep/packing.h"

#ifdef __SSE2__
#include <immintrin.h>
#endif

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "state.h"

namespace itarl::lockstep {

namespace {

static_assert(sizeof(Scalar) == sizeof(btScalar), "sweeps and Bullet in one precision");
static_assert(offsetof(btSolverConstraint, m_friction) ==
                      offsetof(btSolverConstraint, m_appliedImpulse) + sizeof(btScalar) &&
                  offsetof(btSolverConstraint, m_rhs) ==
                      offsetof(btSolverConstraint, m_appliedImpulse) + 3 * sizeof(btScalar) &&
                  offsetof(btSolverConstraint, m_upperLimit) ==
                      offsetof(btSolverConstraint, m_cfm) + 2 * sizeof(btScalar),
              "rows are read four numbers at a time");

// A row that does nothing, for worlds that have none in a slot.
const btSolverConstraint& no_row() {
  alignas(btSolverConstraint) static const std::array<unsigned char, sizeof(btSolverConstraint)>
      zeros{};
  return *reinterpret_cast<const btSolverConstraint*>(zeros.data());
}
const btSolverBody& no_body() {
  alignas(btSolverBody) static const std::array<unsigned char, sizeof(btSolverBody)> zeros{};
  return *reinterpret_cast<const btSolverBody*>(zeros.data());
}

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
bool are_same(const btVector3& a, const btVector3& b) { return all(_mm_cmpeq_ps(load(a), load(b))); }
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

// Four numbers of each world become one vector for each number.
template <int W, typename Source>
inline void transpose(const std::array<Scalar*, 4>& to, Source source) {
#if defined(__SSE2__) && !defined(ITARL_FLOAT64)
  if constexpr (W % 4 == 0) {
    for (int lane = 0; lane < W; lane += 4) {
      __m128 a = _mm_loadu_ps(source(lane)), b = _mm_loadu_ps(source(lane + 1));
      __m128 c = _mm_loadu_ps(source(lane + 2)), d = _mm_loadu_ps(source(lane + 3));
      _MM_TRANSPOSE4_PS(a, b, c, d);
      _mm_store_ps(to[0] + lane, a);
      _mm_store_ps(to[1] + lane, b);
      _mm_store_ps(to[2] + lane, c);
      _mm_store_ps(to[3] + lane, d);
    }
    return;
  }
#endif
  for (int lane = 0; lane < W; ++lane) {
    const Scalar* const from = source(lane);
    for (std::size_t i = 0; i < 4; ++i) to[i][lane] = from[i];
  }
}

}  // namespace

void Lane::read(State& state, const std::vector<std::uint32_t>& movers, std::uint64_t structure) {
  solver_ = &state.solver;
  signature_.structure = structure;
  const int mode = solver_->info().m_solverMode;
  uncovered_ = (mode & SOLVER_RANDMIZE_ORDER) != 0      ? "rows in a random order"
               : solver_->rolling_rows().size() > 0 ? "rolling friction"
                                                    : nullptr;
  if (uncovered_ != nullptr) return;
  read_bodies(movers);
  read_joints();
  read_contacts();
}

void Lane::read_bodies(const std::vector<std::uint32_t>& movers) {
  auto& pool = solver_->bodies();
  std::uint32_t count = 0;
  for (const std::uint32_t mover : movers) count += mover != kNoBody;
  bodies_.assign(count, nullptr);
  mover_of_.assign(std::size_t(pool.size()), kNoBody);
  for (int i = 0; i < pool.size(); ++i) {
    const btRigidBody* const body = pool[i].m_originalBody;
    const std::uint32_t mover = body == nullptr ? kNoBody : movers[slot_of(*body)];
    mover_of_[std::size_t(i)] = mover;
    if (mover != kNoBody) bodies_[mover] = &pool[i];
  }
}

void Lane::read_joints() {
  const auto& constraints = solver_->constraints();
  auto& pool = solver_->joint_rows();
  signature_.joints.clear();
  first_row_.clear();
  row_counts_.clear();
  int row = 0;
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    const int rows = solver_->rows_of(int(i));
    if (rows == 0) continue;
    signature_.joints.push_back({std::uint32_t(constraints[i]->getUserConstraintId()),
                                 mover(pool[row].m_solverBodyIdA),
                                 mover(pool[row].m_solverBodyIdB)});
    first_row_.push_back(std::uint32_t(row));
    row_counts_.push_back(std::uint32_t(rows));
    row += rows;
  }
  for (int i = 0; i < row; ++i) {
    if (!(pool[i].m_lowerLimit <= pool[i].m_upperLimit)) uncovered_ = "limits without a range";
    // 1 / k must be a number: Bullet's residual would be none, and its early end another.
    if (!(pool[i].m_jacDiagABInv > 0)) uncovered_ = "a row that nothing can satisfy";
  }
}

void Lane::read_contacts() {
  auto& pool = solver_->contact_rows();
  contacts_.assign(bodies_.size(), 0);
  pairs_.clear();
  bool touch = false;  // two moving bodies
  for (int i = 0; i < pool.size(); ++i) {
    const std::uint32_t a = mover(pool[i].m_solverBodyIdA), b = mover(pool[i].m_solverBodyIdB);
    pairs_.push_back(a == kNoBody ? ContactKey{b, a} : ContactKey{a, b});
    if (a != kNoBody && b != kNoBody) {
      touch = true;
    } else {
      ++contacts_[a == kNoBody ? b : a];
    }
    if (!(pool[i].m_jacDiagABInv > 0)) uncovered_ = "a row that nothing can satisfy";
  }
  auto& frictions = solver_->friction_rows();
  for (int i = 0; i < frictions.size(); ++i) {
    if (!(frictions[i].m_jacDiagABInv > 0)) uncovered_ = "a row that nothing can satisfy";
  }
  signature_.contacts.clear();
  if (touch) signature_.contacts = pairs_;
}

void Lane::assign_rows(const Layout& layout) {
  const std::vector<PlacedRow>& rows = layout.rows();
  rows_.assign(rows.size(), nullptr);
  const btSolverConstraint* const joints =
      solver_->joint_rows().size() > 0 ? &solver_->joint_rows()[0] : nullptr;
  std::size_t i = 0;
  for (std::uint32_t joint = 0; i < layout.joint_row_count(); ++joint) {
    for (; i < layout.joint_row_count() && rows[i].owner == joint; ++i) {
      if (rows[i].part < row_counts_[joint]) rows_[i] = joints + first_row_[joint] + rows[i].part;
    }
  }

  pool_contact_.assign(layout.contact_count(), -1);
  seen_.assign(bodies_.size(), 0);
  for (std::size_t contact = 0; contact < pairs_.size(); ++contact) {
    const std::uint32_t body = pairs_[contact].a;
    const std::size_t place =
        layout.lists_contacts() ? contact : layout.contact_index(body, seen_[body]++);
    pool_contact_[place] = int(contact);
  }
  for (; i < rows.size(); ++i) {
    const int contact = pool_contact_[rows[i].owner];
    if (contact < 0) continue;
    const btSolverConstraint& row = solver_->contact_rows()[contact];
    rows_[i] = rows[i].part == 0
                   ? &row
                   : &solver_->friction_rows()[row.m_frictionIndex + int(rows[i].part) - 1];
  }
}

void Packing::pack(Layout& layout, std::vector<Lane*>& lanes, int width) {
  layout_ = &layout;
  lanes_ = lanes;
  width_ = width;
  contacts_now_.assign(layout.body_count(), 0);
  for (const Lane* lane : lanes_) {
    for (std::uint32_t i = 0; i < lane->signature().joints.size(); ++i) {
      layout.need_rows(i, lane->rows(i));
    }
    for (std::uint32_t body = 0; body < layout.body_count() && !layout.lists_contacts(); ++body) {
      contacts_now_[body] = std::max(contacts_now_[body], lane->contacts(body));
    }
  }
  for (std::uint32_t body = 0; body < layout.body_count(); ++body) {
    layout.need_contacts(body, contacts_now_[body]);
  }
  const auto once = [&](auto pack_rows) {
    layout.settle();
    for (Lane* lane : lanes_) lane->assign_rows(layout);
    constexpr std::size_t kPage = 4096;
    const std::size_t needed = std::size_t(layout.size()) * std::size_t(width) + kPage;
    if (storage_.size() < needed) storage_.resize(needed);
    const auto address = reinterpret_cast<std::uintptr_t>(storage_.data());
    values_ = storage_.data() + (kPage - address % kPage) % kPage / sizeof(Scalar);
    return pack_rows();
  };
  // A row that turned out to be less special has moved the others.
  const auto until_settled = [&](auto lanes_of) {
    constexpr int W = decltype(lanes_of)::value;
    while (!once([&] { return pack_rows<W>(layout); })) {
    }
    pack_bodies<W>(layout);
  };
  switch (width) {
    case 16:
      until_settled(std::integral_constant<int, 16>{});
      break;
    case 8:
      until_settled(std::integral_constant<int, 8>{});
      break;
    case 4:
      until_settled(std::integral_constant<int, 4>{});
      break;
    case 2:
      until_settled(std::integral_constant<int, 2>{});
      break;
    default:
      until_settled(std::integral_constant<int, 1>{});
  }
  layout.rows_in_order(contacts_now_, rows_);
}

// False if a row's form didn't fit, which is then corrected.
template <int W>
bool Packing::pack_rows(Layout& layout) {
  bool fits = true;
  largest_k_.assign(W, 0);
  std::array<const btSolverConstraint*, W> from;
  std::array<const btSolverConstraint*, W> previous;
  std::array<bool, W> first;
  alignas(64) std::array<Scalar, W> unused;
  previous.fill(&no_row());
  const std::vector<PlacedRow>& rows = layout.rows();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const PlacedRow& row = rows[i];
    const bool of_joint = i < layout.joint_row_count();
    from.fill(&no_row());
    first.fill(true);
    for (std::size_t lane = 0; lane < lanes_.size(); ++lane) {
      if (lanes_[lane]->row(i) == nullptr) continue;
      from[lane] = lanes_[lane]->row(i);
      if (!of_joint) first[lane] = lanes_[lane]->moves_first(i);
    }
    if (of_joint) {
      const Layout::Form before = layout.form(row);
      Layout::Form form = before;
      for (std::size_t lane = 0; lane < lanes_.size(); ++lane) {
        const btSolverConstraint& c = *from[lane];
        const bool absent = from[lane] == &no_row();
        const bool rigid = c.m_cfm == 0;
        if (form.angular) {
          form.angular = rigid && are_zero(c.m_contactNormal1, c.m_contactNormal2) &&
                         are_opposite(c.m_relpos1CrossNormal, c.m_relpos2CrossNormal);
        }
        if (!form.angular && form.full) {
          form.full = rigid && are_opposite(c.m_contactNormal1, c.m_contactNormal2);
        }
        if (form.free) {
          form.free = absent ||
                      (c.m_lowerLimit <= -SIMD_INFINITY && c.m_upperLimit >= SIMD_INFINITY);
        }
        if (row.shares && form.shares && !absent) {
          form.shares = are_same(c.m_relpos1CrossNormal, previous[lane]->m_relpos1CrossNormal);
        }
      }
      if (form.angular != before.angular || form.full != before.full || form.free != before.free ||
          form.shares != before.shares) {
        layout.set_form(row, form);
        fits = false;
      }
    }
    previous = from;

    const auto place = [&](std::uint32_t vector) { return values_ + std::size_t(vector) * W; };
    Scalar* const sink = unused.data();
    const auto three = [&](std::uint32_t vector, auto member) {
      transpose<W>({place(vector), place(vector + 1), place(vector + 2), sink},
                   [&](int lane) { return member(std::size_t(lane)).m_floats; });
    };
    // Applied impulse, coefficient of friction, k, right-hand side; then cfm and the limits.
    const std::uint32_t j = row.jacobian, t = row.target;
    const std::uint32_t last = j + jacobian_block(row.kind) - 1;
    const bool has_cfm = !is_angular(row.kind) && !is_full(row.kind);
    Scalar* const k = place(has_cfm ? last - 1 : last);
    const bool limited = target_block(row.kind) == 3;
    transpose<W>({place(row.applied), is_friction(row.kind) ? place(t + kCoefficient) : sink,
                  row.shares ? sink : k, place(t)},
                 [&](int lane) { return &from[std::size_t(lane)]->m_appliedImpulse; });
    if (has_cfm || limited) {
      transpose<W>({has_cfm ? place(last) : sink, limited ? place(t + kLower) : sink,
                    limited ? place(t + kUpper) : sink, sink},
                   [&](int lane) { return &from[std::size_t(lane)]->m_cfm; });
    }
    if (!row.shares) {
      for (std::size_t lane = 0; lane < W; ++lane) {
        largest_k_[lane] = std::max(largest_k_[lane], k[lane]);
      }
    }
    if (row.shares) continue;
    const auto n1 = [&](std::size_t lane) -> auto& { return from[lane]->m_contactNormal1; };
    const auto n2 = [&](std::size_t lane) -> auto& { return from[lane]->m_contactNormal2; };
    const auto r1 = [&](std::size_t lane) -> auto& { return from[lane]->m_relpos1CrossNormal; };
    const auto r2 = [&](std::size_t lane) -> auto& { return from[lane]->m_relpos2CrossNormal; };
    const auto e1 = [&](std::size_t lane) -> auto& { return from[lane]->m_angularComponentA; };
    const auto e2 = [&](std::size_t lane) -> auto& { return from[lane]->m_angularComponentB; };
    if (is_angular(row.kind)) {
      three(j, r1);
      three(j + 3, e1);
      three(j + 6, e2);
    } else if (is_full(row.kind)) {
      three(j, n1);
      three(j + 3, r1);
      three(j + 6, r2);
      three(j + 9, e1);
      three(j + 12, e2);
    } else if (has_pair(row.kind)) {
      three(j, n1);
      three(j + 3, r1);
      three(j + 6, n2);
      three(j + 9, r2);
      three(j + 12, e1);
      three(j + 15, e2);
    } else {
      three(j, [&](std::size_t lane) -> auto& { return first[lane] ? n1(lane) : n2(lane); });
      three(j + 3, [&](std::size_t lane) -> auto& { return first[lane] ? r1(lane) : r2(lane); });
      three(j + 6, [&](std::size_t lane) -> auto& { return first[lane] ? e1(lane) : e2(lane); });
    }
  }
  return fits;
}

template <int W>
void Packing::pack_bodies(const Layout& layout) {
  alignas(64) std::array<Scalar, W> unused;
  for (std::uint32_t body = 0; body <= layout.body_count(); ++body) {
    std::array<const btSolverBody*, W> from;
    from.fill(&no_body());
    for (std::size_t lane = 0; lane < lanes_.size() && body < layout.body_count(); ++lane) {
      if (lanes_[lane]->body(body) != nullptr) from[lane] = lanes_[lane]->body(body);
    }
    Scalar* const to = values_ + std::size_t(layout.body_place(body < layout.body_count() ? body : kNoBody)) * W;
    const auto three = [&](int vector, auto member) {
      Scalar* const x = to + vector * W;
      transpose<W>({x, x + W, x + 2 * W, unused.data()},
                   [&](int lane) { return member(*from[std::size_t(lane)]).m_floats; });
    };
    three(0, [](auto& body) -> auto& { return body.getDeltaLinearVelocity(); });
    three(3, [](auto& body) -> auto& { return body.getDeltaAngularVelocity(); });
    for (int lane = 0; lane < W; ++lane) {
      // The same along all axes: the crate knows no linear factors.
      to[int(kInverseMass) * W + lane] = from[std::size_t(lane)]->internalGetInvMass().x();
    }
  }
  // A residual is |delta| / k. Its square isn't 0 if it is at least the square root of the smallest
  // number there is; a factor of 2^4 covers the rounding.
  const int exponent = (std::numeric_limits<Scalar>::min_exponent -
                        std::numeric_limits<Scalar>::digits) / 2 + 4;
  for (int lane = 0; lane < W; ++lane) {
    floors_[std::size_t(lane)] = std::ldexp(largest_k_[std::size_t(lane)], exponent);
  }
}

Sweep Packing::sweep(int iterations) {
  return {rows_.data(), rows_.data() + rows_.size(), values_, iterations, floors_.data(), 0};
}

std::uint32_t Packing::unfinished() const {
  // x * 0 is 0 if x is finite, and nothing else.
  std::array<Scalar, 16> sums{};
  const auto width = std::size_t(width_);
  const auto add = [&](std::uint32_t vector) {
    const Scalar* const from = values_ + std::size_t(vector) * width;
    for (std::size_t lane = 0; lane < width; ++lane) sums[lane] += from[lane] * 0;
  };
  for (std::uint32_t body = 0; body < layout_->body_count(); ++body) {
    for (std::uint32_t i = 0; i < kInverseMass; ++i) add(layout_->body_place(body) + i);
  }
  for (const PlacedRow& row : layout_->rows()) add(row.applied);
  std::uint32_t bits = 0;
  for (std::size_t lane = 0; lane < lanes_.size(); ++lane) {
    if (!(sums[lane] == 0)) bits |= std::uint32_t{1} << lane;
  }
  return bits;
}

void Packing::unpack(std::uint32_t lane) {
  const Lane& to = *lanes_[lane];
  const auto value = [&](std::uint32_t vector) {
    return values_[std::size_t(vector) * std::size_t(width_) + lane];
  };
  const std::vector<PlacedRow>& rows = layout_->rows();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (to.row(i) != nullptr) to.row(i)->m_appliedImpulse = value(rows[i].applied);
  }
  for (std::uint32_t body = 0; body < layout_->body_count(); ++body) {
    btSolverBody* const pool = to.body(body);
    if (pool == nullptr) continue;
    const std::uint32_t place = layout_->body_place(body);
    pool->internalGetDeltaLinearVelocity().setValue(value(place), value(place + 1),
                                                    value(place + 2));
    pool->internalGetDeltaAngularVelocity().setValue(value(place + 3), value(place + 4),
                                                     value(place + 5));
  }
}

}  // namespace itarl::lockstep
