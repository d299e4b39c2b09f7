// Worlds stepped together: each begins its step, the sweep runs for all, each ends its step.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "refusal.h"
#include "world.h"
#include "lockstep/gyroscopic.h"
#include "lockstep/world_rows.h"
#include "lockstep/layout.h"
#include "lockstep/cohort.h"
#include "lockstep/packing.h"

namespace itarl {

struct LockstepCounts;
struct LockstepTimes;

// What Rust sees: the worlds are borrowed from enlist() to the end of step().
class Lockstep {
 public:
  explicit Lockstep(std::uint8_t instructions);
  ~Lockstep();

  // Makes room, so that enlist() can't fail.
  void expect(std::size_t count);
  void enlist(World& world) noexcept;
  // Steps all enlisted worlds, then forgets them. Throws if they don't match; none is then stepped.
  void step();
  // Throws what became of the world that was enlisted as the `index`th.
  void result(std::size_t index) const;
  LockstepCounts counts() const noexcept;
  LockstepTimes times() const noexcept;

 private:
  // Some worlds that are stepped together, and what they live in between steps.
  struct Home {
    std::shared_ptr<lockstep::Cohort> cohort;
    std::uint32_t age = 0;  // of the cohort, in steps
    // Steps until another one is tried, and how many these are once one fails or dies young.
    std::uint32_t wait = 0, patience = 1;
  };
  void step_some(State** states, std::optional<Refusal>* results, std::size_t count, Home& home);
  void step_cohort(State** states, std::optional<Refusal>* results, std::size_t count, Home& home);
  void step_by_bullet(State** states, std::optional<Refusal>* results, std::size_t count);
  void make_cohort(std::size_t count, Home& home);
  void end_cohort(Home& home);
  void begin_steps(State** states, std::size_t count);
  void set_up_solvers(State** states, std::size_t count);
  void sweep_all();
  void sweep_alike();
  void end_steps(State** states, std::optional<Refusal>* results, std::size_t count);
  lockstep::RowLayout& layout_for(const lockstep::WorldRows& lane, int width);
  void study(const State& state);

  lockstep::Instructions instructions_;
  std::vector<State*> states_;
  std::vector<std::optional<Refusal>> results_;
  // All structures of worlds so far, which of them the last study() found, and for it the numbers
  // of dynamic bodies by body slot.
  std::vector<std::vector<std::uint64_t>> structures_;
  std::size_t structure_ = ~std::size_t{0};
  std::vector<std::uint32_t> dynamic_ids_;
  std::vector<std::unique_ptr<lockstep::WorldRows>> lanes_;
  // Of worlds whose rows are ready, and those of them that go into one sweep.
  std::vector<lockstep::WorldRows*> waiting_, alike_;
  std::vector<std::unique_ptr<lockstep::RowLayout>> layouts_;
  std::vector<State*> live_;  // worlds in the step that aren't broken
  std::vector<Home> homes_;
  std::size_t swept_now_ = 0;  // worlds in the step
  lockstep::Gyroscopic gyroscopic_;
  lockstep::Packing packing_;
  std::uint64_t swept_ = 0, sweeps_ = 0, idle_ = 0, separate_groups_ = 0, unsupported_ = 0,
                maybe_converged_ = 0, not_finite_ = 0, bullet_rows_ = 0, bullet_moves_ = 0,
                bullet_contacts_ = 0;
  // What each part of a step took so far.
  using Clock = std::chrono::steady_clock;
  Clock::duration begin_{}, pack_{}, sweep_{}, unpack_{}, end_{};
};

std::unique_ptr<Lockstep> new_lockstep(std::uint8_t instructions);
bool has_instructions(std::uint8_t instructions) noexcept;
std::size_t lanes_of(std::uint8_t instructions) noexcept;

}  // namespace itarl
