// The order in which a sweep takes its rows.
//
// Bullet takes them as they are in its pools: a joint's rows one after the other, each waiting for
// the velocities that the one before left, some 50 cycles a row. Two rows may change places if they
// share no moving body, since neither then reads what the other writes: the results have the same
// bits. So rows of joints far apart are taken in turns, and one's wait is filled with another's work.
#pragma once

#include <cstdint>
#include <vector>

#include "lockstep/rows.h"

namespace itarl::lockstep {

// What the schedule knows of a row, or of a run of rows that stay together: its kind, and its moving
// bodies or kNoBody.
inline constexpr std::uint32_t kNoBody = ~std::uint32_t{0};
struct Touch {
  Kind kind;
  std::uint32_t count;
  std::uint32_t a, b;
};

// A legal order of `rows`, given in Bullet's order: the indices of rows, first to last. `alone`: for
// the sweep of one world alone.
std::vector<std::uint32_t> schedule(const std::vector<Touch>& rows, bool alone);

// Whether every body is touched in Bullet's order. All of `order`'s entries are indices of rows.
bool is_legal(const std::vector<Touch>& rows, const std::vector<std::uint32_t>& order);

}  // namespace itarl::lockstep
