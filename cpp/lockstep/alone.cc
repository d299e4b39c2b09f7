#include "lockstep/alone.h"

#include <algorithm>
#include <new>

namespace itarl::lockstep {

namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};

void copy3(Scalar* to, const Scalar* from) { std::copy(from, from + 3, to); }

void scale3(Scalar* to, const Scalar* from, Scalar by) {
  std::transform(from, from + 3, to, [by](Scalar x) { return x * by; });
}

// A motion's parts.
Scalar* angular(Scalar* motion) { return motion; }
Scalar* linear(Scalar* motion) { return motion + kMotion / 2; }

TurnNumbers turn_numbers(const Scalar* j, Scalar target) {
  TurnNumbers numbers{};
  copy3(numbers.r, j);
  copy3(numbers.change_a, j + 3);
  copy3(numbers.change_b, j + 6);
  numbers.k[0] = numbers.k[1] = j[9];
  numbers.target = target;
  return numbers;
}

PairNumbers pair_numbers(const Row& row, const Scalar* values) {
  const Scalar* j = values + row.jacobian;
  const Scalar* target = values + row.target;
  const bool full = is_full(row.kind);
  PairNumbers numbers{};
  copy3(linear(numbers.a), j);
  copy3(angular(numbers.a), j + 3);
  scale3(linear(numbers.b), full ? j : j + 6, full ? -1 : 1);
  j += full ? 6 : 9;
  copy3(angular(numbers.b), j);
  copy3(angular(numbers.change_a), j + 3);
  copy3(angular(numbers.change_b), j + 6);
  scale3(linear(numbers.change_a), linear(numbers.a), values[row.a + kInverseMass]);
  scale3(linear(numbers.change_b), linear(numbers.b), values[row.b + kInverseMass]);
  numbers.k[0] = numbers.k[1] = j[9];
  numbers.cfm = full ? 0 : j[10];
  numbers.target = target[0];
  if (is_friction(row.kind)) numbers.coefficient = target[kCoefficient];
  if (target_block(row.kind) > kUpper) {
    numbers.lower = target[kLower];
    numbers.upper = target[kUpper];
  }
  return numbers;
}

SingleNumbers single_numbers(const Row& row, const Scalar* values) {
  const Scalar* const j = values + row.jacobian;
  const Scalar* const target = values + row.target;
  SingleNumbers numbers{};
  copy3(linear(numbers.a), j);
  copy3(angular(numbers.a), j + 3);
  scale3(linear(numbers.change), j, values[row.a + kInverseMass]);
  copy3(angular(numbers.change), j + 6);
  numbers.k = j[9];
  numbers.cfm = j[10];
  numbers.target = target[0];
  if (is_friction(row.kind)) numbers.coefficient = target[kCoefficient];
  return numbers;
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
  const Scalar* const target = values + row.target;
  switch (row.kind) {
    case Kind::AngularFree:
      new (to) TurnNumbers(turn_numbers(values + row.jacobian, target[0]));
      break;
    case Kind::Angular: {
      auto* const numbers = new (to) TurnNumbers(turn_numbers(values + row.jacobian, 0));
      for (std::uint32_t i = 0; i < row.count; ++i) {
        const Scalar* const own = target + i * target_block(row.kind);
        new (reinterpret_cast<LimitNumbers*>(numbers + 1) + i)
            LimitNumbers{own[0], own[kLower], own[kUpper], 0};
      }
      break;
    }
    case Kind::Contact:
    case Kind::Friction:
      new (to) SingleNumbers(single_numbers(row, values));
      break;
    default:
      new (to) PairNumbers(pair_numbers(row, values));
  }
}

}  // namespace

void Alone::sweep(Sweep& task, AloneFunction function) {
  task.maybe_converged = 0;
  if (task.begin == task.end) return;
  read_motions(task);
  hub_ = find_hub(task);
  make_rows(task);
  AloneTask alone{rows_.data(), rows_.data() + rows_.size(), task.iterations,
                  *task.residual_floor, false};
  function(alone);
  task.maybe_converged = alone.maybe_converged ? 1 : 0;
  write_motions(task);
}

// From the bodies' blocks; of what never moves, too.
void Alone::read_motions(const Sweep& task) {
  std::uint32_t end = 0;
  for (const Row* row = task.begin; row != task.end; ++row) {
    end = std::max({end, row->a + kBodyBlock, row->b + kBodyBlock});
  }
  motions_.make_room(end);
  counts_.assign(end / kBodyBlock, 0);
  for (const Row* row = task.begin; row != task.end; ++row) {
    for (const std::uint32_t body : {row->a, row->b}) {
      const Scalar* const block = task.values + body;
      std::fill_n(motion(body), kMotion, Scalar(0));
      copy3(linear(motion(body)), block);
      copy3(angular(motion(body)), block + 3);
    }
  }
}

void Alone::write_motions(Sweep& task) const {
  for (const Row* row = task.begin; row != task.end; ++row) {
    for (const std::uint32_t body : {row->a, row->b}) {
      Scalar* const block = task.values + body;
      copy3(block, linear(motion(body)));
      copy3(block + 3, angular(motion(body)));
    }
  }
}

std::uint32_t Alone::find_hub(const Sweep& task) {
  for (const Row* row = task.begin; row != task.end; ++row) {
    ++counts_[row->a / kBodyBlock];
  }
  const auto most = std::max_element(counts_.begin(), counts_.end());
  return std::uint32_t(most - counts_.begin()) * kBodyBlock;
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
