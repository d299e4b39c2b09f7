// Memory for vectors with a world in each lane, and the way of worlds' numbers into it.
#pragma once

#ifdef __SSE2__
#include <immintrin.h>
#endif

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "lockstep/joint_numbers.h"

namespace itarl::lockstep {

// Begins where a page of memory does.
class Vectors {
 public:
  // Makes room for as many numbers; what was there may be lost.
  void make_room(std::size_t numbers) {
    constexpr std::size_t kPage = 4096;
    if (storage_.size() < numbers + kPage) storage_.resize(numbers + kPage);
    const auto address = reinterpret_cast<std::uintptr_t>(storage_.data());
    begin_ = storage_.data() + (kPage - address % kPage) % kPage / sizeof(Scalar);
  }
  Scalar* begin() const { return begin_; }

 private:
  std::vector<Scalar> storage_;
  Scalar* begin_ = nullptr;
};

// Four numbers of each world become one vector for each number. `source(lane)` points to them.
template <int W, typename Source>
inline void transpose(const std::array<Scalar*, 4>& to, Source source) {
#if defined(__SSE2__) && !defined(ITARL_FLOAT64)
  if constexpr (W % 4 == 0) {
    for (int lane = 0; lane < W; lane += 4) {
      __m128 a = _mm_loadu_ps(source(lane)), b = _mm_loadu_ps(source(lane + 1));
      __m128 c = _mm_loadu_ps(source(lane + 2)), d = _mm_loadu_ps(source(lane + 3));
      _MM_TRANSPOSE4_PS(a, b, c, d);
      _mm_store_ps(to[0] + lane, a);
      _mm_store_ps(to[1] + lane, b);
      _mm_store_ps(to[2] + lane, c);
      _mm_store_ps(to[3] + lane, d);
    }
    return;
  }
#endif
  for (int lane = 0; lane < W; ++lane) {
    const Scalar* const from = source(lane);
    for (std::size_t i = 0; i < 4; ++i) to[i][lane] = from[i];
  }
}

}  // namespace itarl::lockstep
