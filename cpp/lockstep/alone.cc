#include "lockstep/alone.h"

#include <algorithm>

namespace itarl::lockstep {

namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};

void put3(Scalar* to, const Scalar* from) {
  to[0] = from[0];
  to[1] = from[1];
  to[2] = from[2];
  to[3] = 0;
}

void put3(Scalar* to, const Scalar* from, Scalar times) {
  to[0] = from[0] * times;
  to[1] = from[1] * times;
  to[2] = from[2] * times;
  to[3] = 0;
}

// A motion's parts.
Scalar* angular(Scalar* motion) { return motion; }
Scalar* linear(Scalar* motion) { return motion + kMotion / 2; }

void write_turn(const Row& row, const Scalar* values, TurnNumbers& numbers) {
  const Scalar* const j = values + row.jacobian;
  put3(numbers.r, j);
  put3(numbers.change_a, j + 3);
  put3(numbers.change_b, j + 6);
  numbers.k[0] = numbers.k[1] = j[9];
  numbers.target = values[row.target];
  numbers.unused = 0;
  if (row.kind == Kind::AngularFree) return;
  auto* const limits = reinterpret_cast<LimitNumbers*>(&numbers + 1);
  for (std::uint32_t i = 0; i < row.count; ++i) {
    const Scalar* const target = values + row.target + i * target_block(row.kind);
    limits[i] = {target[0], target[kLower], target[kUpper], 0};
  }
}

// n1 r1 n2 r2 eA eB k cfm, or n1 r1 r2 eA eB k.
void write_pair(const Row& row, const Scalar* values, PairNumbers& numbers) {
  const bool full = is_full(row.kind);
  const Scalar* const n1 = values + row.jacobian;
  const Scalar* const n2 = full ? n1 : n1 + 6;
  const Scalar* const rest = full ? n1 + 6 : n1 + 9;
  put3(linear(numbers.a), n1);
  put3(angular(numbers.a), n1 + 3);
  put3(linear(numbers.b), n2, full ? -1 : 1);
  put3(angular(numbers.b), rest);
  put3(linear(numbers.change_a), linear(numbers.a), values[row.a + kInverseMass]);
  put3(angular(numbers.change_a), rest + 3);
  put3(linear(numbers.change_b), linear(numbers.b), values[row.b + kInverseMass]);
  put3(angular(numbers.change_b), rest + 6);
  numbers.k[0] = numbers.k[1] = rest[9];
  numbers.cfm = full ? 0 : rest[10];
  const Scalar* const target = values + row.target;
  numbers.target = target[0];
  numbers.coefficient = is_friction(row.kind) ? target[kCoefficient] : 0;
  const bool limited = target_block(row.kind) > kUpper;
  numbers.lower = limited ? target[kLower] : 0;
  numbers.upper = limited ? target[kUpper] : 0;
}

// n r e k cfm.
void write_single(const Row& row, const Scalar* values, SingleNumbers& numbers) {
  const Scalar* const n = values + row.jacobian;
  put3(linear(numbers.a), n);
  put3(angular(numbers.a), n + 3);
  put3(linear(numbers.change), n, values[row.a + kInverseMass]);
  put3(angular(numbers.change), n + 6);
  numbers.k = n[9];
  numbers.cfm = n[10];
  const Scalar* const target = values + row.target;
  numbers.target = target[0];
  numbers.coefficient = is_friction(row.kind) ? target[kCoefficient] : 0;
}

// What a row's numbers take, in motions, so that all have a motion's alignment.
std::size_t motions_of(const Row& row) {
  switch (row.kind) {
    case Kind::AngularFree:
      return sizeof(TurnNumbers) / sizeof(Scalar) / kMotion;
    case Kind::Angular:
      return (sizeof(TurnNumbers) + row.count * sizeof(LimitNumbers)) / sizeof(Scalar) / kMotion + 1;
    case Kind::Contact:
    case Kind::Friction:
      return sizeof(SingleNumbers) / sizeof(Scalar) / kMotion;
    default:
      return sizeof(PairNumbers) / sizeof(Scalar) / kMotion;
  }
}

void write_numbers(const Row& row, const Scalar* values, Scalar* to) {
  switch (row.kind) {
    case Kind::AngularFree:
    case Kind::Angular:
      return write_turn(row, values, *reinterpret_cast<TurnNumbers*>(to));
    case Kind::Contact:
    case Kind::Friction:
      return write_single(row, values, *reinterpret_cast<SingleNumbers*>(to));
    default:
      return write_pair(row, values, *reinterpret_cast<PairNumbers*>(to));
  }
}

}  // namespace

void Alone::sweep(Sweep& task, AloneFunction function) {
  task.maybe_converged = 0;
  if (task.begin == task.end) return;
  find_bodies(task);
  for (const std::uint32_t body : bodies_) {
    put3(linear(motion(body)), task.values + body);
    put3(angular(motion(body)), task.values + body + 3);
  }
  make_rows(task);
  AloneTask alone{rows_.data(), rows_.data() + rows_.size(), task.iterations,
                  *task.residual_floor, false};
  function(alone);
  task.maybe_converged = alone.maybe_converged ? 1 : 0;
  for (const std::uint32_t body : bodies_) {
    std::copy_n(linear(motion(body)), 3, task.values + body);
    std::copy_n(angular(motion(body)), 3, task.values + body + 3);
  }
}

// All that rows are about, what never moves with them; and the hub.
void Alone::find_bodies(const Sweep& task) {
  bodies_.clear();
  rows_of_.assign(rows_of_.size(), kNone);
  hub_ = task.begin->a;
  for (const Row* row = task.begin; row != task.end; ++row) {
    ++rows_of(row->a);
    rows_of(row->b);
    if (rows_of(row->a) > rows_of(hub_)) hub_ = row->a;
  }
  motions_.make_room(rows_of_.size() * kMotion);
}

// How many rows have it as their body a, so far.
std::uint32_t& Alone::rows_of(std::uint32_t body) {
  const std::size_t index = body / kBodyBlock;
  if (index >= rows_of_.size()) rows_of_.resize(index + 1, kNone);
  if (rows_of_[index] == kNone) {
    rows_of_[index] = 0;
    bodies_.push_back(body);
  }
  return rows_of_[index];
}

void Alone::make_rows(const Sweep& task) {
  std::size_t motions = 0;
  for (const Row* row = task.begin; row != task.end; ++row) motions += motions_of(*row);
  numbers_.make_room(motions * kMotion);
  Scalar* numbers = numbers_.begin();
  rows_.clear();
  has_hub_ = false;
  partner_ = kNone;
  for (const Row* row = task.begin; row != task.end; ++row) {
    write_numbers(*row, task.values, numbers);
    rows_.push_back({row->kind, row->count, false, false, false, motion(row->a), motion(row->b),
                     task.values + row->applied, task.values + row->contact, numbers});
    place(*row, rows_.back());
    numbers += motions_of(*row) * kMotion;
  }
}

// Keeps track of who is in which register.
void Alone::place(const Row& row, AloneRow& out) {
  const bool has_b = has_pair(row.kind);
  if (row.a != hub_) {
    if (has_b && row.b == hub_) has_hub_ = false;
    if (row.a == partner_ || (has_b && row.b == partner_)) partner_ = kNone;
    return;
  }
  out.in_chain = true;
  out.loads_a = !has_hub_;
  has_hub_ = true;
  // A row of the hub alone leaves its partner as it is.
  const std::uint32_t partner = has_b || partner_ == kNone ? row.b : partner_;
  out.b = motion(partner);
  out.loads_b = partner != partner_;
  partner_ = partner;
}

}  // namespace itarl::lockstep
