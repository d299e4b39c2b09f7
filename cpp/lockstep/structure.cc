#include "lockstep/structure.h"

#include <string_view>
#include <vector>

namespace itarl {

namespace {

const char* name_of(Motion motion) {
  switch (motion) {
    case Motion::Static:
      return "static";
    case Motion::Dynamic:
      return "dynamic";
    default:
      return "kinematic";
  }
}

const char* name_of(JointKind kind) {
  switch (kind) {
    case JointKind::Fixed:
      return "fixed";
    case JointKind::PointToPoint:
      return "point-to-point";
    case JointKind::Hinge:
      return "hinge";
    case JointKind::Slider:
      return "slider";
    default:
      return "6-dof spring";
  }
}

// Three bits for each of up to 12 letters.
std::uint64_t number_of(const std::string& axes) {
  std::uint64_t number = 0;
  for (const char letter : axes) {
    number = number * 8 + 1 + std::string_view("flrFLR+").find(letter);
  }
  return number;
}

// All that is compared, in order, each in words and as a number.
struct Fact {
  std::string words;
  std::uint64_t number;
};

// `tell(words, number)` for each; words is a function, since it's only needed for a refusal.
template <typename Tell>
void list_facts(const State& state, Tell tell) {
  const btContactSolverInfo& info = const_cast<State&>(state).world.getSolverInfo();
  const auto count = [](auto n, const char* what) { return std::to_string(n) + " " + what; };
  const auto number = [](auto n) { return std::uint64_t(n); };
  tell([&] { return count(info.m_numIterations, "iterations"); }, number(info.m_numIterations));
  tell([&] { return count(info.m_solverMode, "as solver mode"); }, number(info.m_solverMode));
  tell([&] { return count(state.bodies.size(), "bodies"); }, number(state.bodies.size()));
  tell([&] { return count(state.joints.size(), "joints"); }, number(state.joints.size()));
  for (std::size_t i = 0; i < state.bodies.size(); ++i) {
    const auto& body = state.bodies[i];
    tell(
        [&] {
          return "body " + std::to_string(i) + " " + (body ? name_of(body->motion) : "removed");
        },
        body ? 1 + number(body->motion) : 0);
  }
  for (std::size_t i = 0; i < state.joints.size(); ++i) {
    const auto& joint = state.joints[i];
    const auto name = "joint " + std::to_string(i);
    tell([&] { return name + " " + (joint ? name_of(joint->kind) : "removed"); },
         joint ? 1 + number(joint->kind) : 0);
    if (!joint) continue;
    const auto parent = slot_of(*joint->parent->body), child = slot_of(*joint->child->body);
    tell(
        [&] {
          return name + " between bodies " + std::to_string(parent) + " and " +
                 std::to_string(child);
        },
        std::uint64_t(parent) << 32 | child);
    tell([&] { return name + " with axes " + joint->axes; }, number_of(joint->axes));
  }
}

}  // namespace

const std::vector<std::uint64_t>& structure_of(const State& state) {
  if (state.structure.empty()) {
    list_facts(state,
               [&](auto, std::uint64_t number) { state.structure.push_back(number); });
  }
  return state.structure;
}

std::string difference(const State& first, const State& second, int which) {
  std::vector<Fact> facts;
  list_facts(first, [&](auto words, std::uint64_t number) { facts.push_back({words(), number}); });
  std::size_t i = 0;
  std::string found;
  list_facts(second, [&](auto words, std::uint64_t number) {
    if (found.empty() && (i >= facts.size() || facts[i].number != number)) {
      found = which == 1 ? words() : i < facts.size() ? facts[i].words : "without more";
    }
    ++i;
  });
  return found.empty() ? "of another structure" : found;
}

}  // namespace itarl
