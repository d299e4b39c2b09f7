// What runs in lanes, for processors with AVX2.
#define ITARL_INSTRUCTIONS avx2
#include "lockstep/choice.inc"
#ifdef ITARL_ALONE
#include "lockstep/alone.inc"
#endif

namespace itarl::lockstep {

extern const SweepChoice kChoiceAvx2;
const SweepChoice kChoiceAvx2 = avx2::kChoice<avx2::Lanes<Scalar, 32 / sizeof(Scalar)>>;

#ifdef ITARL_ALONE
extern const AloneFunction kAloneAvx2;
const AloneFunction kAloneAvx2 = avx2::sweep_alone;
#endif

}  // namespace itarl::lockstep
