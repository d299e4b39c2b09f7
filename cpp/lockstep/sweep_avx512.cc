// What runs in lanes, for processors with AVX-512.
#define ITARL_INSTRUCTIONS avx512
#include "lockstep/choice.inc"

namespace itarl::lockstep {

extern const SweepChoice kChoiceAvx512;
const SweepChoice kChoiceAvx512 = avx512::kChoice<avx512::Lanes<Scalar, 64 / sizeof(Scalar)>>;

}  // namespace itarl::lockstep
