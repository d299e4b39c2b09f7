// The rows of one world swept alone: what alone.cc fills in and alone.inc works off.
//
// Where a world has no others beside it, the three numbers of a vector lie beside each other instead,
// and a body's two velocities: its motion is one register of AVX2, or two of SSE2. No Bullet header
// is included here (see rows.h).
#pragma once

#include <cstdint>

#include "lockstep/rows.h"
#include "lockstep/tasks.h"

namespace itarl::lockstep {

// Angular velocity and a zero, linear velocity and a zero; or what these are multiplied with.
inline constexpr std::size_t kMotion = 8;
static_assert(kMotion == kBodyBlock, "a motion has its body's place");

// Of Angular rows; k is there for either body. Limits of each row of a run come after it.
struct alignas(8 * sizeof(Scalar)) TurnNumbers {
  Scalar r[4], change_a[4], change_b[4];
  Scalar k[2], target, unused;
};
struct LimitNumbers {
  Scalar target, lower, upper, unused;
};

// Of rows of two bodies; masses are multiplied in.
struct alignas(8 * sizeof(Scalar)) PairNumbers {
  Scalar a[kMotion], b[kMotion], change_a[kMotion], change_b[kMotion];
  Scalar k[2], target, cfm, lower, upper, coefficient, unused;
};

// Of rows of one body.
struct alignas(8 * sizeof(Scalar)) SingleNumbers {
  Scalar a[kMotion], change[kMotion];
  Scalar k, target, cfm, coefficient, unused[4];
};

// The longest chain of rows that wait for each other is, as a rule, that of the body that most rows
// are about, a robot's trunk. This hub and its partner, the other body of the chain's row before, are
// kept in registers besides memory, so that the chain doesn't wait for that, too.
struct AloneRow {
  Kind kind;
  std::uint8_t count;     // 1, or how many rows a run has
  bool in_chain;          // its body a is the hub
  bool loads_a, loads_b;  // in the chain: it isn't in its register, or was changed outside since
  Scalar *a, *b;          // motions, never the same
  Scalar* applied;        // of the first; those of a run follow each other
  const Scalar* contact;  // the impulse of a friction row's contact
  const void* numbers;    // by kind, as above
};

// Has one row at least.
struct AloneTask {
  const AloneRow* begin;
  const AloneRow* end;
  int iterations;
  Scalar residual_floor;  // as in Sweep
  bool maybe_converged;   // set, as in Sweep
};

using AloneFunction = void (*)(AloneTask&);

}  // namespace itarl::lockstep
