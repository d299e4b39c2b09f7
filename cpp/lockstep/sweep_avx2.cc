// What runs in lanes, for processors with AVX2.
#define ITARL_INSTRUCTIONS avx2
#include "lockstep/choice.inc"

namespace itarl::lockstep {

extern const SweepChoice kChoiceAvx2;
const SweepChoice kChoiceAvx2 = avx2::kChoice<avx2::Lanes<Scalar, 32 / sizeof(Scalar)>>;

}  // namespace itarl::lockstep
