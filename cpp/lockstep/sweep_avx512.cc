// The sweep for processors with AVX-512.
#define ITARL_INSTRUCTIONS avx512
#include "lockstep/sweep.inc"

namespace itarl::lockstep {

void sweep_avx512(Sweep& task) { avx512::sweep<avx512::Lanes<Scalar, 64 / sizeof(Scalar)>>(task); }

}  // namespace itarl::lockstep
