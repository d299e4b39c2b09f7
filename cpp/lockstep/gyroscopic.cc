#include "lockstep/gyroscopic.h"

#include <algorithm>

#include "lockstep/schedule.h"
#include "state.h"

namespace itarl::lockstep {

void Gyroscopic::apply(const std::vector<State*>& worlds,
                       const std::vector<std::uint32_t>& dynamic_ids, const SweepChoice& choice) {
  const auto width = std::size_t(choice.lanes);
  const auto bodies =
      std::size_t(std::count_if(dynamic_ids.begin(), dynamic_ids.end(),
                                [](auto dynamic_id) { return dynamic_id != kNoBody; }));
  time_steps_.make_room(width);
  numbers_.make_room(bodies * kGyroscopicNumbers * width);
  impulses_.make_room(bodies * 3 * width);
  with_width(choice.lanes, [&](auto w) { gather<w.value>(worlds, dynamic_ids); });
  choice.gyrate({std::uint32_t(bodies), time_steps_.begin(), numbers_.begin(), impulses_.begin()});
  with_width(choice.lanes, [&](auto w) { hand_to_solvers<w.value>(worlds, dynamic_ids); });
}

template <int W>
void Gyroscopic::gather(const std::vector<State*>& worlds,
                        const std::vector<std::uint32_t>& dynamic_ids) {
  // Empty lanes do what the last one does: no number is a surprise there.
  const auto world = [&](int lane) -> const State& {
    return *worlds[std::min(std::size_t(lane), worlds.size() - 1)];
  };
  for (int lane = 0; lane < W; ++lane) time_steps_.begin()[lane] = world(lane).time_step;
  alignas(64) std::array<Scalar, W> unused;
  for (std::size_t slot = 0; slot < dynamic_ids.size(); ++slot) {
    if (dynamic_ids[slot] == kNoBody) continue;
    Scalar* to = numbers_.begin() + std::size_t(dynamic_ids[slot]) * kGyroscopicNumbers * W;
    const auto three = [&](auto member) {
      transpose<W>({to, to + W, to + 2 * W, unused.data()},
                   [&](int lane) { return member(*world(lane).bodies[slot]->body).m_floats; });
      to += 3 * W;
    };
    for (int row = 0; row < 3; ++row) {
      three([row](const btRigidBody& body) -> const btVector3& {
        return body.getWorldTransform().getBasis()[row];
      });
    }
    three([](const btRigidBody& body) -> const btVector3& { return body.getAngularVelocity(); });
    three(
        [](const btRigidBody& body) -> const btVector3& { return body.getInvInertiaDiagLocal(); });
  }
}

template <int W>
void Gyroscopic::hand_to_solvers(const std::vector<State*>& worlds,
                                 const std::vector<std::uint32_t>& dynamic_ids) const {
  btVector3 nowhere;
  for (State* const state : worlds) state->solver.gyroscopic_impulses().resize(dynamic_ids.size());
  for (std::size_t slot = 0; slot < dynamic_ids.size(); ++slot) {
    if (dynamic_ids[slot] == kNoBody) continue;
    hand_out<W>(impulses_.begin() + std::size_t(dynamic_ids[slot]) * 3 * W, [&](int lane) {
      const auto i = std::size_t(lane);
      return (i < worlds.size() ? worlds[i]->solver.gyroscopic_impulses()[slot] : nowhere).m_floats;
    });
  }
}

}  // namespace itarl::lockstep
