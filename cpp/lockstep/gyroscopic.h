// The gyroscopic impulses of all bodies, before the solver is set up.
#pragma once

#include <cstdint>
#include <vector>

#include "lockstep/sweep.h"
#include "lockstep/vectors.h"

namespace itarl {
struct State;
}

namespace itarl::lockstep {

class Gyroscopic {
 public:
  // Works them out and hands them to the worlds' solvers. At most as many worlds as `choice` has
  // lanes; `dynamic_ids` has for each body slot the number of the body among those that move, or
  // kNoBody.
  void apply(const std::vector<State*>& worlds, const std::vector<std::uint32_t>& dynamic_ids,
             const SweepChoice& choice);

 private:
  template <int W>
  void gather(const std::vector<State*>& worlds, const std::vector<std::uint32_t>& dynamic_ids);
  template <int W>
  void hand_to_solvers(const std::vector<State*>& worlds,
                       const std::vector<std::uint32_t>& dynamic_ids) const;

  Vectors time_steps_, numbers_, impulses_;
};

}  // namespace itarl::lockstep
