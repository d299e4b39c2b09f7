// What runs in lanes, for any processor of the target; and the choice of instructions when running.
#define ITARL_INSTRUCTIONS plain
#include "lockstep/choice.inc"
#ifdef ITARL_ALONE
#include "lockstep/alone.h"
#include "lockstep/alone.inc"
#endif

namespace itarl::lockstep {

#ifdef __x86_64__
extern const SweepChoice kChoiceAvx2, kChoiceAvx512;
#endif
#ifdef ITARL_ALONE
extern const AloneFunction kAloneAvx2;
#endif

namespace {

constexpr int kWidest = 64 / sizeof(Scalar);  // lanes of AVX-512; AVX2 has half of them, SSE2 a quarter

template <int W>
constexpr const SweepChoice& kChoicePlain = plain::kChoice<plain::Lanes<Scalar, W>>;

SweepChoice choose_alone([[maybe_unused]] Instructions instructions) {
  SweepChoice choice = kChoicePlain<1>;
#ifdef ITARL_ALONE
  if (instructions == Instructions::Plain) {
    choice.run = [](Sweep& task) { task.alone->sweep(task, plain::sweep_alone); };
  } else {
    choice.run = [](Sweep& task) { task.alone->sweep(task, kAloneAvx2); };
  }
#endif
  return choice;
}

}  // namespace

int most_lanes(Instructions instructions) {
  switch (instructions) {
    case Instructions::Avx512:
      return kWidest;
    case Instructions::Avx2:
      return kWidest / 2;
    default:
#ifdef __SSE2__
      return kWidest / 4;
#else
      return 1;
#endif
  }
}

bool is_supported(Instructions instructions) {
#ifdef __x86_64__
  switch (instructions) {
    case Instructions::Avx512:
      return __builtin_cpu_supports("avx512f");
    case Instructions::Avx2:
      return __builtin_cpu_supports("avx2");
    default:
      return true;
  }
#else
  return instructions == Instructions::Plain;
#endif
}

SweepChoice choose_sweep(Instructions instructions, int worlds) {
  if (worlds <= 1) return choose_alone(instructions);
#ifdef __SSE2__
  if (worlds <= kWidest / 4 || instructions == Instructions::Plain) {
    return kChoicePlain<kWidest / 4>;
  }
  if (worlds <= kWidest / 2 || instructions == Instructions::Avx2) return kChoiceAvx2;
  return kChoiceAvx512;
#else
  (void)instructions;
  return kChoicePlain<1>;
#endif
}

}  // namespace itarl::lockstep
