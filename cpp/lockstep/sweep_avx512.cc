// The sweep for processors with AVX-512.
#define ITARL_INSTRUCTIONS avx512
#include "lockstep/joint_rows.inc"
#include "lockstep/gyroscopic.inc"
#include "lockstep/sweep.inc"

namespace itarl::lockstep {

namespace {
using Widest = avx512::Lanes<Scalar, 64 / sizeof(Scalar)>;
}

extern const SweepChoice kChoiceAvx512;
const SweepChoice kChoiceAvx512{Widest::kWidth, avx512::sweep<Widest>, avx512::make_rows<Widest>,
                              avx512::report<Widest>, avx512::move<Widest>,
                              avx512::gyrate<Widest>};

}  // namespace itarl::lockstep
