// What worlds must have in common to be stepped together: the solver's iterations and mode, which
// bodies move, and the joints with the axes that give them rows. Masses, poses, shapes, limits,
// gravity and the like may differ.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "state.h"

namespace itarl {

// Equal for worlds that match.
const std::vector<std::uint64_t>& structure_of(const State& state);

// The first thing that differs between two worlds, told of the first (0) or the second (1).
std::string difference(const State& first, const State& second, int which);

}  // namespace itarl
