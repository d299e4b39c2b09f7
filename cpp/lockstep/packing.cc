#include "lockstep/packing.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

#include "lockstep/residual.h"
#include "lockstep/vectors.h"
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

// A row that does nothing, for worlds that have none.
const btSolverConstraint& no_row() {
  alignas(btSolverConstraint) static const std::array<unsigned char, sizeof(btSolverConstraint)>
      zeros{};
  return *reinterpret_cast<const btSolverConstraint*>(zeros.data());
}
const btSolverBody& no_body() {
  alignas(btSolverBody) static const std::array<unsigned char, sizeof(btSolverBody)> zeros{};
  return *reinterpret_cast<const btSolverBody*>(zeros.data());
}

// One row of the layout, as each world has it.
template <int W>
struct Rows {
  std::array<const btSolverConstraint*, W> in;
  std::array<bool, W> moves_first;  // for rows with one moving body: whether it's the first of two

  Rows(const std::vector<WorldRows*>& lanes, std::size_t index, bool of_contact) {
    in.fill(&no_row());
    moves_first.fill(true);
    for (std::size_t lane = 0; lane < lanes.size(); ++lane) {
      if (lanes[lane]->row(index) == nullptr) continue;
      in[lane] = lanes[lane]->row(index);
      if (of_contact) moves_first[lane] = lanes[lane]->moves_first(index);
    }
  }
};

// Writes a row of all worlds into its places.
template <int W>
class Writer {
 public:
  Writer(Scalar* values, const PlacedRow& row, const Rows<W>& rows)
      : values_(values), row_(row), rows_(rows) {}

  // Applied impulse, coefficient of friction, k, right-hand side; then cfm and the limits.
  void numbers() {
    const bool has_cfm = !is_angular(row_.kind) && !is_full(row_.kind);
    const bool limited = target_block(row_.kind) == 3;
    const std::uint32_t target = row_.target;
    Scalar* const unused = unused_.data();
    transpose<W>({at(row_.applied), is_friction(row_.kind) ? at(target + kCoefficient) : unused,
                  row_.shares ? unused : k(), at(target)},
                 [&](int lane) { return &in(lane).m_appliedImpulse; });
    if (!has_cfm && !limited) return;
    transpose<W>({has_cfm ? k() + W : unused, limited ? at(target + kLower) : unused,
                  limited ? at(target + kUpper) : unused, unused},
                 [&](int lane) { return &in(lane).m_cfm; });
  }

  void jacobian() {
    const auto n1 = [&](int lane) -> auto& { return in(lane).m_contactNormal1; };
    const auto n2 = [&](int lane) -> auto& { return in(lane).m_contactNormal2; };
    const auto r1 = [&](int lane) -> auto& { return in(lane).m_relpos1CrossNormal; };
    const auto r2 = [&](int lane) -> auto& { return in(lane).m_relpos2CrossNormal; };
    const auto e1 = [&](int lane) -> auto& { return in(lane).m_angularComponentA; };
    const auto e2 = [&](int lane) -> auto& { return in(lane).m_angularComponentB; };
    if (is_angular(row_.kind)) {
      vectors(r1, e1, e2);
    } else if (is_full(row_.kind)) {
      vectors(n1, r1, r2, e1, e2);
    } else if (has_pair(row_.kind)) {
      vectors(n1, r1, n2, r2, e1, e2);
    } else {
      const auto either = [&](auto one, auto other) {
        return [this, one, other](int lane) -> auto& {
          return rows_.moves_first[std::size_t(lane)] ? one(lane) : other(lane);
        };
      };
      vectors(either(n1, n2), either(r1, r2), either(e1, e2));
    }
  }

  // The last number of a Jacobian but for cfm.
  Scalar* k() {
    const bool has_cfm = !is_angular(row_.kind) && !is_full(row_.kind);
    return at(row_.jacobian + jacobian_block(row_.kind) - (has_cfm ? 2 : 1));
  }

 private:
  const btSolverConstraint& in(int lane) const { return *rows_.in[std::size_t(lane)]; }
  Scalar* at(std::uint32_t place) { return values_ + std::size_t(place) * W; }

  template <typename... Members>
  void vectors(Members... members) {
    Scalar* to = at(row_.jacobian);
    const auto one = [&](auto member) {
      transpose<W>({to, to + W, to + 2 * W, unused_.data()},
                   [&](int lane) { return member(lane).m_floats; });
      to += 3 * W;
    };
    (one(members), ...);
  }

  Scalar* values_;
  const PlacedRow& row_;
  const Rows<W>& rows_;
  alignas(64) std::array<Scalar, W> unused_;
};

}  // namespace

void Packing::pack(RowLayout& layout, std::vector<WorldRows*>& lanes, const SweepChoice& choice) {
  layout_ = &layout;
  lanes_ = lanes;
  states_.clear();
  for (const WorldRows* const lane : lanes) states_.push_back(&lane->state());
  width_ = choice.lanes;
  make_room(layout);
  group_ = numbers_.enter(states_, width_);
  switch (width_) {
    case 16:
      pack_lanes<16>(layout);
      break;
    case 8:
      pack_lanes<8>(layout);
      break;
    case 4:
      pack_lanes<4>(layout);
      break;
    case 2:
      pack_lanes<2>(layout);
      break;
    default:
      pack_lanes<1>(layout);
  }
  numbers_.gather(layout);
  numbers_.gather_bodies(layout, lanes_);
  joints_ = &numbers_.task(layout, values_, largest_k_.data());
  choice.make_rows(*joints_);
  layout.rows_in_order(contacts_now_, rows_);
}

// For as many rows of joints and contacts as the worlds have now.
void Packing::make_room(RowLayout& layout) {
  contacts_now_.assign(layout.body_count(), 0);
  for (const WorldRows* lane : lanes_) {
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
}

template <int W>
void Packing::pack_lanes(RowLayout& layout) {
  do {  // a row that turns out to be less special than it was moves the others
    layout.settle();
    for (WorldRows* lane : lanes_) lane->assign_rows(layout);
  } while (!fit_forms(layout));
  storage_.make_room(std::size_t(layout.size()) * W);
  values_ = storage_.begin();
  pack_rows<W>(layout);
  pack_bodies<W>(layout);
}

// False if a row's form had to be corrected.
bool Packing::fit_forms(RowLayout& layout) const {
  bool fits = true;
  const auto fit = [&](const PlacedRow& row) {
    const Form before = layout.form(row);
    Form form = before;
    for (const WorldRows* lane : lanes_) {
      if (row.part < lane->rows(row.owner)) form = form & lane->form(row.owner, row.part);
    }
    if (form == before) return;
    layout.set_form(row, form);
    fits = false;
  };
  if (layout.fitted_to == group_) {
    for (const std::uint32_t i : layout.pool_rows()) {
      if (i < layout.joint_row_count()) fit(layout.rows()[i]);
    }
  } else {
    for (std::size_t i = 0; i < layout.joint_row_count(); ++i) fit(layout.rows()[i]);
    layout.fitted_to = group_;
  }
  return fits;
}

template <int W>
void Packing::pack_rows(const RowLayout& layout) {
  largest_k_.fill(0);
  for (const std::uint32_t i : layout.pool_rows()) {
    const PlacedRow& row = layout.rows()[i];
    const Rows<W> rows(lanes_, i, i >= layout.joint_row_count());
    Writer<W> writer(values_, row, rows);
    writer.numbers();
    if (row.shares) continue;
    writer.jacobian();
    for (std::size_t lane = 0; lane < W; ++lane) {
      largest_k_[lane] = std::max(largest_k_[lane], writer.k()[lane]);
    }
  }
}

template <int W>
void Packing::pack_bodies(const RowLayout& layout) {
  alignas(64) std::array<Scalar, W> unused;
  for (std::uint32_t body = 0; body <= layout.body_count(); ++body) {
    std::array<const btSolverBody*, W> from;
    from.fill(&no_body());
    for (std::size_t lane = 0; lane < lanes_.size() && body < layout.body_count(); ++lane) {
      if (lanes_[lane]->body(body) != nullptr) from[lane] = lanes_[lane]->body(body);
    }
    const std::uint32_t place = layout.body_place(body < layout.body_count() ? body : kNoBody);
    Scalar* const to = values_ + std::size_t(place) * W;
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
}

Sweep Packing::sweep(int iterations) {
  set_residual_floors(largest_k_, width_, floors_);
  return {rows_.data(), rows_.data() + rows_.size(), values_, iterations, floors_.data(), 0,
          &alone_};
}

std::uint32_t Packing::not_finite(const SweepChoice& choice) {
  choice.report(*joints_);
  return joints_->extreme | lanes_not_finite(*layout_, values_, width_, lanes_.size());
}

void Packing::unpack(const SweepChoice& choice, std::uint32_t lanes) {
  std::uint32_t moving = 0;
  for (std::uint32_t i = 0; i < lanes_.size(); ++i) {
    if ((lanes >> i & 1) == 0) continue;
    if (lanes_[i]->can_move()) {
      moving |= std::uint32_t{1} << i;
      lanes_[i]->set_moved();
    }
    unpack_pools(i);
  }
  for (std::uint32_t i = 0; i < lanes_.size(); ++i) {
    if ((lanes >> i & 1) != 0) numbers_.report(i, *states_[i]);
  }
  if (moving == 0) return;
  choice.move(numbers_.moves(*layout_, values_));
  numbers_.move(moving, lanes_);
}

void Packing::unpack_pools(std::uint32_t lane) {
  const WorldRows& to = *lanes_[lane];
  const auto value = [&](std::uint32_t vector) {
    return values_[std::size_t(vector) * std::size_t(width_) + lane];
  };
  for (const std::uint32_t i : layout_->pool_rows()) {
    if (to.row(i) != nullptr) to.row(i)->m_appliedImpulse = value(layout_->rows()[i].applied);
  }
  if (to.is_moved()) return;
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
