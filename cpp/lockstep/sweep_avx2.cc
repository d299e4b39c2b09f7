// The sweep for processors with AVX2.
#define ITARL_INSTRUCTIONS avx2
#include "lockstep/joint_rows.inc"
#include "lockstep/gyroscopic.inc"
#include "lockstep/sweep.inc"
#ifdef ITARL_ALONE
#include "lockstep/alone.inc"
#endif

namespace itarl::lockstep {

namespace {
using Widest = avx2::Lanes<Scalar, 32 / sizeof(Scalar)>;
}

extern const SweepChoice kChoiceAvx2;
const SweepChoice kChoiceAvx2{Widest::kWidth, avx2::sweep<Widest>, avx2::make_rows<Widest>,
                              avx2::report<Widest>, avx2::move<Widest>,
                              avx2::gyrate<Widest>};

#ifdef ITARL_ALONE
extern const AloneFunction kAloneAvx2;
const AloneFunction kAloneAvx2 = avx2::sweep_alone;
#endif

}  // namespace itarl::lockstep
