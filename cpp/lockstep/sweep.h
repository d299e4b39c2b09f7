// The sweep: Bullet's Gauss-Seidel iterations over all rows, a world in each lane.
#pragma once

#include <cstdint>

#include "lockstep/tasks.h"
#include "lockstep/rows.h"

namespace itarl::lockstep {

// Whether rows of a joint that all act are swept in one go. That saves reading and writing
// velocities, which counts where vectors are wide; with few lanes it pays more to fill the waits in
// between with other rows.
constexpr bool sweeps_runs(int lanes) { return lanes * int(sizeof(Scalar)) >= 32; }

// Whether one world alone has a sweep of its own (alone.h).
#if defined(__SSE2__) && !defined(ITARL_FLOAT64)
#define ITARL_ALONE
#endif
constexpr bool sweeps_alone([[maybe_unused]] int lanes) {
#ifdef ITARL_ALONE
  return lanes == 1;
#else
  return false;
#endif
}
class Alone;

struct Sweep {
  const Row* begin;
  const Row* end;
  Scalar* values;  // the blocks of bodies and rows
  int iterations;
  // For each lane, how large the largest |delta| of an iteration has to be for the iteration's
  // squared residual, by which Bullet stops early, to be above 0 for sure.
  const Scalar* residual_floor;
  // Set: bit i if lane i had an iteration whose deltas were neither all 0, after which nothing
  // changes any more, nor surely above the floor. Bullet may have stopped there.
  std::uint32_t maybe_converged;
  Alone* alone;  // where one world has its form
};

using SweepFunction = void (*)(Sweep&);

enum class Instructions : std::uint8_t { Plain, Avx2, Avx512 };

// The widest that these instructions have.
int most_lanes(Instructions instructions);

// What this processor has.
bool is_supported(Instructions instructions);

struct SweepChoice {
  int lanes;
  SweepFunction run;
  JointFunction make_rows, report;
  MoveFunction move;
  GyroscopicFunction gyrate;
  // For worlds that live in lanes (cohort.h).
  TwistFunction twist;
  ContactFunction find_contacts, make_contact_rows, report_contacts;
  RangeFunction leave_range;
  AngleFunction read_angles;
};

// The narrowest one with room for `worlds`, or the widest there is.
SweepChoice choose_sweep(Instructions instructions, int worlds);

}  // namespace itarl::lockstep
