// Worlds that live in lanes: from step to step, what moves stays where lanes have it, and Bullet's
// objects are brought up to date when someone looks at them (State::settle).
//
// A cohort is made of worlds that have been stepped together by Bullet's own code, if lanes have a
// form for all that their next step does, and lasts until one of them is changed, goes with others,
// or needs something that lanes don't know; then Bullet's own code steps them again.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "lockstep/alone.h"
#include "lockstep/gatherer.h"
#include "lockstep/layout.h"
#include "lockstep/plane_pairs.h"
#include "lockstep/sweep.h"
#include "lockstep/vectors.h"
#include "lockstep/world_rows.h"

namespace itarl::lockstep {

class Cohort : public std::enable_shared_from_this<Cohort> {
 public:
  // Of worlds whose last step `lanes` tells of; null if they can't live in lanes.
  static std::shared_ptr<Cohort> of(const std::vector<WorldRows*>& lanes,
                                    const std::vector<std::uint32_t>& dynamic_ids,
                                    const SweepChoice& choice);
  // To be called once the cohort is held: the worlds live in it from then on.
  void admit();

  // Whether these are its worlds, and all still live in it.
  bool is_of(State* const* states, std::size_t count) const;

  // A step: up to the sweep, that, and what follows it. Lanes that Bullet has to step instead come
  // back as bits: those with a row that can't be swept, with a number that isn't finite, or in which
  // Bullet might stop early. They've been brought up to where they were before the step, and live in
  // lanes no more.
  void begin();
  void sweep() { choice_.run(sweep_); }
  std::uint32_t end();
  // Worlds that left the range of numbers in the last step, as bits.
  std::uint32_t left_range() const { return left_range_; }

  // Brings Bullet's objects up to date with a lane.
  void settle(std::size_t lane, State& to);
  // Of a joint, about x, y and z, in our signs; whoever asks has looked that the joint is there.
  std::array<double, 3> angles(std::size_t lane, std::uint32_t joint) const;

 private:
  explicit Cohort(const SweepChoice& choice) : choice_(choice), width_(choice.lanes) {}
  bool take(const std::vector<WorldRows*>& lanes, const std::vector<std::uint32_t>& dynamic_ids);
  bool take_pairs(const std::vector<std::uint32_t>& dynamic_ids);
  void take_bodies(const std::vector<std::uint32_t>& dynamic_ids);
  void make_layout(const WorldRows& first, const std::vector<WorldRows*>& lanes);
  void find_places();
  void make_room_for_contacts();
  void reset_bodies();
  void read_angles();
  std::uint32_t not_finite();
  Scalar* pairs_of(Vectors& numbers, std::size_t pair, std::uint32_t each) const {
    return numbers.begin() + pair * each * std::size_t(width_);
  }

  const SweepChoice choice_;
  int width_;
  std::vector<State*> states_;
  std::vector<std::vector<PlanePair>> pairs_;  // by lane
  std::vector<std::uint32_t> body_slots_;      // of those that move
  std::vector<std::uint8_t> ahead_;            // by lane: whether Bullet's objects are behind
  std::unique_ptr<RowLayout> layout_;
  Gatherer joints_;
  JointTask* joint_task_ = nullptr;
  std::vector<PairPlan> plans_;
  std::vector<std::uint32_t> most_points_;  // by pair
  std::vector<std::uint32_t> contacts_;     // by body: most_points_
  std::vector<std::uint32_t> body_places_;
  struct AnglePlace {
    std::size_t place;  // in vectors
    bool slider;
  };
  std::vector<AnglePlace> angle_places_;  // by joint
  ContactTask contact_task_{};
  std::vector<Row> rows_;
  Sweep sweep_{};
  Alone alone_;
  // Before a step, and after it.
  Vectors bodies_, next_bodies_, points_, next_points_;
  Vectors worlds_, pair_numbers_, values_, angles_;
  std::uint32_t left_range_ = 0;
  alignas(64) std::array<Scalar, 16> floors_{}, largest_k_{};  // by lane
};

}  // namespace itarl::lockstep
