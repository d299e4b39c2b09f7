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
  void read_motions(const Sweep& task);
  void write_motions(Sweep& task) const;
  std::uint32_t find_hub(const Sweep& task);
  void make_rows(const Sweep& task);
  void place(const Row& row, AloneRow& out);
  Scalar* motion(std::uint32_t body) const { return motions_.begin() + body; }

  std::vector<AloneRow> rows_;
  Vectors motions_, numbers_;          // motions lie at their bodies' places
  std::vector<std::uint32_t> counts_;  // of rows, by body
  std::uint32_t hub_ = 0;
  // While rows are made: whether the hub is in its register, and who is its partner.
  bool has_hub_ = false;
  std::uint32_t partner_ = 0;
};

}  // namespace itarl::lockstep
