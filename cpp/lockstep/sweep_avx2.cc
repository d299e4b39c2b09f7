// The sweep for processors with AVX2.
#define ITARL_INSTRUCTIONS avx2
#include "lockstep/sweep.inc"

namespace itarl::lockstep {

void sweep_avx2(Sweep& task) { avx2::sweep<avx2::Lanes<Scalar, 32 / sizeof(Scalar)>>(task); }

}  // namespace itarl::lockstep
