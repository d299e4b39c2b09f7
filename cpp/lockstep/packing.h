// From Bullet's pools into lanes, and back.
//
// The pools stay as they are until the results are written into them, so that any world can go back
// to Bullet's own loop.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lockstep/lane.h"
#include "lockstep/layout.h"
#include "lockstep/sweep.h"

namespace itarl::lockstep {

// Packs lanes into values for a sweep, unpacks what came out.
class Packing {
 public:
  // Brings `layout` up to what the lanes need, and fills in the sweep's rows and values. At most
  // `width` lanes; the others stay zero.
  void pack(Layout& layout, std::vector<Lane*>& lanes, int width);

  // To be swept; valid until the next pack().
  Sweep sweep(int iterations);

  // Lanes with a number that isn't finite, as bits.
  std::uint32_t unfinished() const;
  // Writes the results of a lane into its pools.
  void unpack(std::uint32_t lane);

 private:
  void make_room(Layout& layout);
  template <int W>
  void pack_lanes(Layout& layout);
  bool fit_forms(Layout& layout) const;
  template <int W>
  void pack_rows(const Layout& layout);
  template <int W>
  void pack_bodies(const Layout& layout);

  std::vector<Lane*> lanes_;
  Layout* layout_ = nullptr;
  int width_ = 1;
  std::vector<std::uint32_t> contacts_now_;  // by mover
  std::vector<Row> rows_;
  std::vector<Scalar> storage_;  // with room to align
  Scalar* values_ = nullptr;
  alignas(64) std::array<Scalar, 16> floors_{};
  std::vector<Scalar> largest_k_;  // by lane
};

}  // namespace itarl::lockstep
