// How small deltas may be before Bullet might stop, and which lanes went astray.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "lockstep/layout.h"

namespace itarl::lockstep {

// A residual is |delta| / k. Its square isn't 0 if it is at least the square root of the smallest
// number there is; a factor of 2^4 covers the rounding.
inline void set_residual_floors(const std::array<Scalar, 16>& largest_k, int lanes,
                                std::array<Scalar, 16>& floors) {
  const int exponent =
      (std::numeric_limits<Scalar>::min_exponent - std::numeric_limits<Scalar>::digits) / 2 + 4;
  for (std::size_t lane = 0; lane < std::size_t(lanes); ++lane) {
    floors[lane] = std::ldexp(largest_k[lane], exponent);
  }
}

// Lanes with a velocity or an impulse that isn't finite, as bits.
inline std::uint32_t lanes_not_finite(const RowLayout& layout, const Scalar* values, int lanes,
                                      std::size_t worlds) {
  // x * 0 is 0 if x is finite, and nothing else.
  std::array<Scalar, 16> sums{};
  const auto width = std::size_t(lanes);
  const auto add = [&](std::uint32_t vector) {
    const Scalar* const from = values + std::size_t(vector) * width;
    for (std::size_t lane = 0; lane < width; ++lane) sums[lane] += from[lane] * 0;
  };
  for (std::uint32_t body = 0; body < layout.body_count(); ++body) {
    for (std::uint32_t i = 0; i < kInverseMass; ++i) add(layout.body_place(body) + i);
  }
  for (const PlacedRow& row : layout.rows()) add(row.applied);
  std::uint32_t bits = 0;
  for (std::size_t lane = 0; lane < worlds; ++lane) {
    if (!(sums[lane] == 0)) bits |= std::uint32_t{1} << lane;
  }
  return bits;
}

}  // namespace itarl::lockstep
