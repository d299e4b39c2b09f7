// Memory for vectors with a world in each lane, and the way of worlds' numbers into it.
#pragma once

#ifdef __SSE2__
#include <immintrin.h>
#endif

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "lockstep/tasks.h"

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

// And back: three vectors become three numbers, and a zero, of each world. `target(lane)` points to
// where they go.
template <int W, typename Target>
inline void hand_out(const Scalar* from, Target target) {
#if defined(__SSE2__) && !defined(ITARL_FLOAT64)
  if constexpr (W % 4 == 0) {
    for (int lane = 0; lane < W; lane += 4) {
      __m128 a = _mm_load_ps(from + lane), b = _mm_load_ps(from + W + lane);
      __m128 c = _mm_load_ps(from + 2 * W + lane), d = _mm_setzero_ps();
      _MM_TRANSPOSE4_PS(a, b, c, d);
      _mm_storeu_ps(target(lane), a);
      _mm_storeu_ps(target(lane + 1), b);
      _mm_storeu_ps(target(lane + 2), c);
      _mm_storeu_ps(target(lane + 3), d);
    }
    return;
  }
#endif
  for (int lane = 0; lane < W; ++lane) {
    Scalar* const to = target(lane);
    for (int i = 0; i < 3; ++i) to[i] = from[i * W + lane];
    to[3] = 0;
  }
}

// Calls `act` with the width as a constant of its argument's type.
template <typename Act>
inline void with_width(int width, Act act) {
  switch (width) {
    case 16:
      return act(std::integral_constant<int, 16>{});
    case 8:
      return act(std::integral_constant<int, 8>{});
    case 4:
      return act(std::integral_constant<int, 4>{});
    case 2:
      return act(std::integral_constant<int, 2>{});
    default:
      return act(std::integral_constant<int, 1>{});
  }
}

}  // namespace itarl::lockstep
