// From Bullet's pools into lanes, and back.
//
// The pools stay as they are until the results are written into them, so that any world can go back
// to Bullet's own loop.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "cut.h"
#include "lockstep/layout.h"
#include "lockstep/sweep.h"

namespace itarl {
struct State;
}

namespace itarl::lockstep {

// A world in a lane, and what its pools hold.
class Lane {
 public:
  // Reads the pools of a world whose solver waits. `movers` has for each body slot the number of
  // the body among those that move, or kNoBody.
  void read(State& state, const std::vector<std::uint32_t>& movers, std::uint64_t structure);

  // Why lanes don't cover this world's rows, or nullptr.
  const char* uncovered() const { return uncovered_; }
  const Signature& signature() const { return signature_; }
  CutSolver& solver() const { return *solver_; }
  std::uint32_t rows(std::uint32_t joint) const { return row_counts_[joint]; }
  // How many contacts a body has, if no two moving bodies touch.
  std::uint32_t contacts(std::uint32_t body) const { return contacts_[body]; }

  btSolverBody* body(std::uint32_t body) const { return bodies_[body]; }

  // Finds the rows that a layout has.
  void assign_rows(const Layout& layout);
  // By index in the layout; null if there is none.
  const btSolverConstraint* row(std::size_t index) const { return rows_[index]; }
  // Whether a contact row's one moving body is the first of its two.
  bool moves_first(std::size_t index) const {
    return mover(rows_[index]->m_solverBodyIdA) != kNoBody;
  }

 private:
  void read_bodies(const std::vector<std::uint32_t>& movers);
  void read_joints();
  void read_contacts();
  std::uint32_t mover(int solver_body) const { return mover_of_[std::size_t(solver_body)]; }

  CutSolver* solver_ = nullptr;
  const char* uncovered_ = nullptr;
  Signature signature_;
  std::vector<btSolverBody*> bodies_;       // by mover; null if not in the pool
  std::vector<std::uint32_t> mover_of_;     // by solver body
  std::vector<std::uint32_t> first_row_;    // by joint, in joint_rows()
  std::vector<std::uint32_t> row_counts_;   // by joint
  std::vector<std::uint32_t> contacts_;     // by mover
  std::vector<ContactKey> pairs_;           // by contact of the pool
  std::vector<std::uint32_t> seen_;         // contacts by mover, while they're assigned
  std::vector<int> pool_contact_;           // by contact of the layout; -1 if there is none
  std::vector<const btSolverConstraint*> rows_;  // by row of the layout
};

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
  template <int W>
  bool pack_rows(Layout& layout);
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
