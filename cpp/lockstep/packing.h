// From Bullet's pools into lanes, and back.
//
// The pools stay as they are until the results are written into them, so that any world can go back
// to Bullet's own loop.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lockstep/alone.h"
#include "lockstep/world_rows.h"
#include "lockstep/layout.h"
#include "lockstep/gatherer.h"
#include "lockstep/sweep.h"
#include "lockstep/vectors.h"

namespace itarl::lockstep {

// Packs lanes into values for a sweep, unpacks what came out.
class Packing {
 public:
  // Brings `layout` up to what the lanes need, and fills in the sweep's rows and values. At most as
  // many lanes as `choice` has.
  void pack(RowLayout& layout, std::vector<WorldRows*>& lanes, const SweepChoice& choice);
  // Lanes with a row that can't be swept, as bits; what the sweep makes of them means nothing.
  std::uint32_t unsound() const { return joints_->unsound; }

  // To be swept; valid until the next pack().
  Sweep sweep(int iterations);

  // To be called after the sweep: lanes with a number that isn't finite, or so large that Bullet
  // would switch a joint off, as bits.
  std::uint32_t not_finite(const SweepChoice& choice);
  // Writes the results of these lanes into their pools and joints, and moves bodies where it can.
  void unpack(const SweepChoice& choice, std::uint32_t lanes);

 private:
  void make_room(RowLayout& layout);
  template <int W>
  void pack_lanes(RowLayout& layout);
  void unpack_pools(std::uint32_t lane);
  bool fit_forms(RowLayout& layout) const;
  template <int W>
  void pack_rows(const RowLayout& layout);
  template <int W>
  void pack_bodies(const RowLayout& layout);

  std::vector<WorldRows*> lanes_;
  std::vector<State*> states_;  // theirs
  RowLayout* layout_ = nullptr;
  int width_ = 1;
  std::vector<std::uint32_t> contacts_now_;  // by dynamic_id
  std::vector<Row> rows_;
  Vectors storage_;
  Scalar* values_ = nullptr;
  Alone alone_;
  Gatherer numbers_;
  std::uint64_t group_ = 0;  // of the lanes, as numbers_ has it
  JointTask* joints_ = nullptr;
  alignas(64) std::array<Scalar, 16> floors_{}, largest_k_{};  // by lane
};

}  // namespace itarl::lockstep
