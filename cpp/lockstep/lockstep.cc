#include "lockstep/lockstep.h"

#include <algorithm>
#include <string>

#include "state.h"
#include "lockstep/structure.h"

namespace itarl {

using lockstep::Instructions;
using lockstep::WorldRows;
using lockstep::RowLayout;

namespace {

// Orders of joints, and touching pairs of bodies, for which a layout is kept.
constexpr std::size_t kMostLayouts = 64;

// Making a cohort costs as much as some steps: it pays if that lasts for longer than these.
constexpr std::uint32_t kYoung = 5;
// Steps after which worlds that can't live in lanes are tried again, at most.
constexpr std::uint32_t kMostPatience = 1024;

Instructions instructions_of(std::uint8_t number) {
  return number >= 2   ? Instructions::Avx512
         : number == 1 ? Instructions::Avx2
                       : Instructions::Plain;
}

}  // namespace

Lockstep::Lockstep(std::uint8_t instructions) : instructions_(instructions_of(instructions)) {
  if (!lockstep::is_supported(instructions_)) {
    refuse_argument("Lockstep::new", "instructions", "some that this processor has",
                    instructions_ == Instructions::Avx512 ? "AVX-512" : "AVX2");
  }
}
Lockstep::~Lockstep() = default;

std::unique_ptr<Lockstep> new_lockstep(std::uint8_t instructions) {
  return std::make_unique<Lockstep>(instructions);
}
bool has_instructions(std::uint8_t instructions) noexcept {
  return lockstep::is_supported(instructions_of(instructions));
}
std::size_t lanes_of(std::uint8_t instructions) noexcept {
  return std::size_t(lockstep::most_lanes(instructions_of(instructions)));
}

void Lockstep::expect(std::size_t count) {
  states_.clear();
  states_.reserve(count);
}

void Lockstep::enlist(World& world) noexcept {
  if (states_.size() < states_.capacity()) states_.push_back(&world.state());
}

void Lockstep::step() {
  std::vector<State*> states;
  states.swap(states_);  // forgotten, whatever happens
  results_.assign(states.size(), std::nullopt);
  if (states.empty()) return;
  for (std::size_t i = 1; i < states.size(); ++i) {
    if (structure_of(*states[i]) == structure_of(*states[0])) continue;
    refuse_argument("Lockstep::step", "worlds[" + std::to_string(i) + "]",
                    "built like worlds[0], " + difference(*states[0], *states[i], 0),
                    difference(*states[0], *states[i], 1));
  }
  study(*states[0]);
  const std::size_t most = std::size_t(lockstep::most_lanes(instructions_));
  homes_.resize((states.size() + most - 1) / most);
  for (std::size_t i = 0; i < states.size(); i += most) {
    const std::size_t count = std::min(most, states.size() - i);
    try {
      step_some(&states[i], &results_[i], count, homes_[i / most]);
    } catch (...) {  // out of memory, say, in the middle of a step
      for (std::size_t k = i; k < i + count; ++k) {
        states[k]->solver.abandon();
        if (!states[k]->broken) states[k]->broken = Refusal('I', {"a step was left half done"});
      }
      throw;
    }
  }
  states.swap(states_);
  states_.clear();  // keeps its memory
}

void Lockstep::result(std::size_t index) const {
  if (index < results_.size() && results_[index]) throw *results_[index];
}

// Which bodies move.
void Lockstep::study(const State& state) {
  const std::vector<std::uint64_t>& structure = structure_of(state);
  if (structure_ < structures_.size() && structures_[structure_] == structure) return;
  const auto known = std::find(structures_.begin(), structures_.end(), structure);
  structure_ = std::size_t(known - structures_.begin());
  if (known == structures_.end()) structures_.push_back(structure);
  dynamic_ids_.assign(state.bodies.size(), lockstep::kNoBody);
  std::uint32_t next = 0;
  for (std::size_t slot = 0; slot < state.bodies.size(); ++slot) {
    const auto& body = state.bodies[slot];
    if (body && body->motion == Motion::Dynamic) dynamic_ids_[slot] = next++;
  }
}

void Lockstep::step_some(State** states, std::optional<Refusal>* results, std::size_t count,
                         Home& home) {
  if (home.cohort && home.cohort->is_of(states, count)) {
    step_cohort(states, results, count, home);
    return;
  }
  if (home.cohort) end_cohort(home);
  for (std::size_t i = 0; i < count; ++i) states[i]->leave_lanes();
  step_by_bullet(states, results, count);
  if (home.wait > 0) {
    --home.wait;
  } else {
    make_cohort(count, home);
  }
}

// The next steps are made in lanes alone, if they can be.
void Lockstep::make_cohort(std::size_t count, Home& home) {
  alike_.clear();
  for (std::size_t i = 0; i < count; ++i) alike_.push_back(lanes_[i].get());
  const bool all_swept = swept_now_ == count;
  if (all_swept) {
    home.cohort = lockstep::Cohort::of(alike_, dynamic_ids_,
                                       lockstep::choose_sweep(instructions_, int(count)));
  }
  home.age = 0;
  if (home.cohort) {
    home.cohort->admit();
  } else {
    end_cohort(home);
  }
}

// Where cohorts can't be, or don't last, they're tried ever more rarely.
void Lockstep::end_cohort(Home& home) {
  home.cohort.reset();
  home.patience = home.age < kYoung ? std::min(2 * home.patience, kMostPatience) : 1;
  home.wait = home.age < kYoung ? home.patience : 0;
}

void Lockstep::step_cohort(State** states, std::optional<Refusal>* results, std::size_t count,
                           Home& home) {
  lockstep::Cohort& cohort = *home.cohort;
  const auto start = Clock::now();
  cohort.begin();
  const auto begun = Clock::now();
  cohort.sweep();
  const auto swept = Clock::now();
  const std::uint32_t left = cohort.end(), broken = cohort.left_range();
  ++sweeps_;
  for (std::size_t i = 0; i < count; ++i) {
    if ((left >> i & 1) != 0) continue;
    ++swept_;
    if ((broken >> i & 1) == 0) {
      ++states[i]->steps;
      continue;
    }
    states[i]->leave_lanes();
    try {
      check_step(*states[i]);
    } catch (const Refusal& refusal) {
      results[i] = refusal;
    }
  }
  begin_ += begun - start;
  sweep_ += swept - begun;
  end_ += Clock::now() - swept;
  for (std::size_t i = 0; i < count; ++i) {
    if ((left >> i & 1) != 0) step_by_bullet(&states[i], &results[i], 1);
  }
  ++home.age;
  if (left != 0) end_cohort(home);
}

// With the rest of Bullet's step done by Bullet, world by world.
void Lockstep::step_by_bullet(State** states, std::optional<Refusal>* results, std::size_t count) {
  swept_now_ = 0;
  const auto start = Clock::now();
  begin_steps(states, count);
  set_up_solvers(states, count);
  begin_ += Clock::now() - start;
  sweep_all();
  const auto swept = Clock::now();
  end_steps(states, results, count);
  end_ += Clock::now() - swept;
}

// Forces, contacts, islands of each world; gyroscopic impulses of all together.
void Lockstep::begin_steps(State** states, std::size_t count) {
  live_.clear();
  for (std::size_t i = 0; i < count; ++i) {
    if (states[i]->broken) continue;
    states[i]->begin_step();
    states[i]->world.begin_step(states[i]->time_step);
    if (states[i]->solver.has_known_arithmetic()) live_.push_back(states[i]);
  }
  if (!live_.empty()) {
    gyroscopic_.apply(live_, dynamic_ids_,
                      lockstep::choose_sweep(instructions_, int(live_.size())));
  }
}

// Solver bodies and rows. What lanes don't cover is solved at once, the others wait.
void Lockstep::set_up_solvers(State** states, std::size_t count) {
  while (lanes_.size() < count) lanes_.push_back(std::make_unique<WorldRows>());
  waiting_.clear();
  for (std::size_t i = 0; i < count; ++i) {
    State& state = *states[i];
    if (state.broken) continue;
    state.world.set_up_solver(state.time_step);
    separate_groups_ += std::uint64_t(state.solver.separate_groups());
    if (!state.solver.waits()) {
      ++idle_;
      continue;
    }
    lanes_[i]->read(state, dynamic_ids_, structure_);
    if (!lanes_[i]->is_covered()) {
      ++unsupported_;
      state.solver.iterate();
    } else {
      waiting_.push_back(lanes_[i].get());
    }
  }
}

// Worlds that wait, those that are alike together.
void Lockstep::sweep_all() {
  while (!waiting_.empty()) {
    const WorldRows& first = *waiting_.front();
    alike_.clear();
    std::size_t others = 0;
    for (WorldRows* const lane : waiting_) {
      if (lane->signature() == first.signature()) {
        alike_.push_back(lane);
      } else {
        waiting_[others++] = lane;
      }
    }
    waiting_.resize(others);
    sweep_alike();
  }
}

void Lockstep::end_steps(State** states, std::optional<Refusal>* results, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    State& state = *states[i];
    try {
      if (state.broken) throw *state.broken;
      if (state.solver.waits() && lanes_[i]->is_moved()) {
        state.world.end_moved_step();
      } else {
        state.world.end_step(state.time_step);
      }
      check_step(state);
    } catch (const Refusal& refusal) {
      results[i] = refusal;
    }
  }
}

void Lockstep::sweep_alike() {
  std::vector<WorldRows*>& lanes = alike_;
  const auto start = Clock::now();
  const lockstep::SweepChoice choice = lockstep::choose_sweep(instructions_, int(lanes.size()));
  RowLayout& layout = layout_for(*lanes.front(), choice.lanes);
  packing_.pack(layout, lanes, choice);
  lockstep::Sweep sweep = packing_.sweep(lanes.front()->solver().info().m_numIterations);
  const auto packed = Clock::now();
  choice.run(sweep);
  const auto swept = Clock::now();
  const std::uint32_t not_finite = packing_.not_finite(choice);
  ++sweeps_;
  std::uint32_t fine = 0;
  for (std::uint32_t i = 0; i < lanes.size(); ++i) {
    if (packing_.unsound() >> i & 1) {
      ++unsupported_;
      lanes[i]->solver().iterate();
    } else if (not_finite >> i & 1) {
      ++not_finite_;
      lanes[i]->solver().iterate();
    } else if (sweep.maybe_converged >> i & 1) {
      ++maybe_converged_;
      lanes[i]->solver().iterate();
    } else {
      ++swept_;
      ++swept_now_;
      ++bullet_contacts_;
      bullet_rows_ += lanes[i]->solver().joint_rows().size() > 0;
      bullet_moves_ += !lanes[i]->can_move();
      fine |= std::uint32_t{1} << i;
    }
  }
  packing_.unpack(choice, fine);
  pack_ += packed - start;
  sweep_ += swept - packed;
  unpack_ += Clock::now() - swept;
}

RowLayout& Lockstep::layout_for(const WorldRows& lane, int width) {
  for (const auto& layout : layouts_) {
    if (layout->lanes() == width && layout->signature() == lane.signature()) return *layout;
  }
  if (layouts_.size() == kMostLayouts) layouts_.erase(layouts_.begin());
  const int mode = lane.solver().info().m_solverMode;
  std::uint32_t bodies = 0;
  for (const std::uint32_t dynamic_id : dynamic_ids_) bodies += dynamic_id != lockstep::kNoBody;
  layouts_.push_back(std::make_unique<RowLayout>(
      lane.signature(), bodies, (mode & SOLVER_USE_2_FRICTION_DIRECTIONS) != 0 ? 2 : 1,
      (mode & SOLVER_INTERLEAVE_CONTACT_AND_FRICTION_CONSTRAINTS) != 0, width));
  return *layouts_.back();
}

LockstepCounts Lockstep::counts() const noexcept {
  return {swept_,           sweeps_,     idle_,        separate_groups_, unsupported_,
          maybe_converged_, not_finite_, bullet_rows_, bullet_moves_,    bullet_contacts_};
}

LockstepTimes Lockstep::times() const noexcept {
  const auto seconds = [](Clock::duration time) {
    return std::chrono::duration<double>(time).count();
  };
  return {seconds(begin_), seconds(pack_), seconds(sweep_), seconds(unpack_), seconds(end_)};
}

}  // namespace itarl
