// From worlds into lanes what rows of joints and motions are made of, and back what comes of them.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "lockstep/tasks.h"
#include "lockstep/world_rows.h"
#include "lockstep/layout.h"
#include "lockstep/vectors.h"

namespace itarl {
struct State;
}

namespace itarl::lockstep {

class Gatherer {
 public:
  // Worlds that are about to be swept. Gives a number, above 0, that stands for them as long as
  // they're built as they are.
  std::uint64_t enter(const std::vector<State*>& worlds, int width);
  // Reads what the rows of a layout's joints need.
  void gather(const RowLayout& layout);
  // The same piece by piece: where rows are, what is a world's, what joints' motors are to do.
  void plan(const RowLayout& layout);
  void gather_worlds();
  void gather_motors();
  // What they need of the joints' bodies, as the worlds' solvers have them.
  void gather_bodies(const RowLayout& layout, const std::vector<WorldRows*>& lanes);
  // The rows to make in `values`, the sweep's. Valid until the next gather().
  JointTask& task(const RowLayout& layout, Scalar* values, Scalar* largest_k);
  // Once the task is done and reported of: hands their reports to the joints of the world in a lane.
  void report(std::uint32_t lane, State& to) const;
  // Lanes with a report that isn't finite, as bits.
  std::uint32_t not_finite() const;
  const Scalar* worlds() const { return worlds_.begin(); }
  // Which of the task's plans are of which joints.
  const std::vector<std::uint32_t>& joints() const { return joints_; }
  // The bodies to move, once they're swept.
  MoveTask moves(const RowLayout& layout, const Scalar* values);
  // Once they're moved: hands these lanes' worlds where their bodies are, and how fast.
  void move(std::uint32_t lanes, const std::vector<WorldRows*>& to) const;

 private:
  // What doesn't change from step to step, of joints by their ids.
  struct Copy {
    std::vector<std::shared_ptr<const int>> builds;  // by lane: what it's a copy of
    int width = 0;
    std::uint64_t number = 0;
    std::vector<std::uint32_t> places;  // of each joint's numbers
    Vectors numbers;
  };
  Copy& copy_for(int width);
  void fill(Copy& copy) const;
  template <int W>
  void gather_bodies(std::uint32_t bodies, const std::vector<WorldRows*>& lanes);
  // Empty lanes do what the last one does: no number is a surprise there.
  State& lane(std::size_t i) const { return *lanes_[i < lanes_.size() ? i : lanes_.size() - 1]; }

  std::vector<State*> lanes_;
  int width_ = 1;
  std::vector<std::unique_ptr<Copy>> copies_;
  std::size_t next_copy_ = 0;  // the one to give up when there are too many
  std::uint64_t made_ = 0;     // how many so far
  Copy* copy_ = nullptr;
  std::vector<JointPlan> plans_;
  std::vector<std::uint32_t> joints_;  // their ids
  Vectors worlds_, bodies_, reports_, moved_;
  std::vector<std::uint32_t> body_places_;
  JointTask task_{};
};

}  // namespace itarl::lockstep
