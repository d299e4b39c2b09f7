// Sweeps for any processor of the target, and the choice of one when running.
#define ITARL_INSTRUCTIONS plain
#include "lockstep/sweep.inc"

namespace itarl::lockstep {

#ifdef __x86_64__
void sweep_avx2(Sweep& sweep);
void sweep_avx512(Sweep& sweep);
#endif

namespace {

constexpr int kWidest = 64 / sizeof(Scalar);  // lanes of AVX-512; AVX2 has half of them, SSE2 a quarter

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
  if (worlds <= 1) return {1, plain::sweep<plain::Lanes<Scalar, 1>>};
#ifdef __SSE2__
  if (worlds <= kWidest / 4 || instructions == Instructions::Plain) {
    return {kWidest / 4, plain::sweep<plain::Lanes<Scalar, kWidest / 4>>};
  }
  if (worlds <= kWidest / 2 || instructions == Instructions::Avx2) {
    return {kWidest / 2, sweep_avx2};
  }
  return {kWidest, sweep_avx512};
#else
  (void)instructions;
  return {1, plain::sweep<plain::Lanes<Scalar, 1>>};
#endif
}

}  // namespace itarl::lockstep
