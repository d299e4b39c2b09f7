// One world swept alone, its rows in a form of their own (alone_rows.h).
#pragma once

#include <cstdint>
#include <vector>

#include "lockstep/alone_rows.h"
#include "lockstep/sweep.h"
#include "lockstep/vectors.h"

namespace itarl::lockstep {

class Alone {
 public:
  // Does the sweep of a single lane with `function`.
  void sweep(Sweep& task, AloneFunction function);

 private:
  void find_bodies(const Sweep& task);
  std::uint32_t& rows_of(std::uint32_t body);
  void make_rows(const Sweep& task);
  void place(const Row& row, AloneRow& out);
  Scalar* motion(std::uint32_t body) const { return motions_.begin() + body; }

  // Bodies go by their places in the sweep, and their motions have the same.
  std::vector<std::uint32_t> bodies_, rows_of_;
  std::vector<AloneRow> rows_;
  Vectors motions_, numbers_;
  std::uint32_t hub_ = 0;
  // While rows are made: whether the hub is in its register, and who is its partner.
  bool has_hub_ = false;
  std::uint32_t partner_ = 0;
};

}  // namespace itarl::lockstep
