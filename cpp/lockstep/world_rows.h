// A world in a lane: what its solver's pools hold, in the layout's words.
#pragma once

#include <cstdint>
#include <vector>

#include "pausing.h"
#include "lockstep/layout.h"

namespace itarl {
struct State;
}

namespace itarl::lockstep {

class WorldRows {
 public:
  // Reads the pools of a world whose solver waits. `dynamic_ids` has for each body slot the number
  // of the body among those that move, or kNoBody.
  void read(State& state, const std::vector<std::uint32_t>& dynamic_ids, std::size_t structure);

  // Whether this world's rows can be swept in lanes.
  bool is_covered() const { return covered_; }
  // Whether its bodies can be moved in lanes, too: all of them are in the pool and never sleep, and
  // none is pushed out of another.
  bool can_move() const { return can_move_; }
  // Whether they were.
  bool is_moved() const { return moved_; }
  void set_moved() { moved_ = true; }
  const Signature& signature() const { return signature_; }
  State& state() const { return *state_; }
  PausingSolver& solver() const { return *solver_; }
  std::uint32_t rows(std::uint32_t joint) const { return row_counts_[joint]; }
  // Of a joint's row that is there.
  Form form(std::uint32_t joint, std::uint32_t number) const {
    const JointKey& key = signature_.joints[joint];
    return key.type.kind() == JointType::FromPools ? forms_[first_row_[joint] + number]
                                                   : form_in_lanes(key.joint, number);
  }
  // How many contacts a body has, if no two moving bodies touch.
  std::uint32_t contacts(std::uint32_t body) const { return contacts_[body]; }

  btSolverBody* body(std::uint32_t body) const { return bodies_[body]; }

  // Finds the rows that a layout has.
  void assign_rows(const RowLayout& layout);
  // By index in the layout; null if there is none in the pools.
  const btSolverConstraint* row(std::size_t index) const { return rows_[index]; }
  // Whether a contact row's one moving body is the first of its two.
  bool moves_first(std::size_t index) const {
    return dynamic_id(rows_[index]->m_solverBodyIdA) != kNoBody;
  }

 private:
  void read_bodies(const std::vector<std::uint32_t>& dynamic_ids);
  void read_joints();
  void read_contacts();
  Form form_in_lanes(std::uint32_t joint, std::uint32_t number) const;
  std::uint32_t dynamic_id(int solver_body) const {
    return dynamic_id_of_[std::size_t(solver_body)];
  }

  State* state_ = nullptr;
  PausingSolver* solver_ = nullptr;
  bool covered_ = false, can_move_ = false, moved_ = false;
  Signature signature_;
  std::vector<btSolverBody*> bodies_;            // by dynamic_id; null if not in the pool
  std::vector<std::uint32_t> dynamic_id_of_;     // by solver body
  std::vector<std::uint32_t> first_row_;         // by joint, in joint_rows(), if its rows are there
  std::vector<std::uint32_t> row_counts_;        // by joint
  std::vector<Form> forms_;                      // by row in joint_rows()
  std::vector<std::uint32_t> contacts_;          // by dynamic_id
  std::vector<ContactKey> pairs_;                // by contact of the pool
  std::vector<std::uint32_t> seen_;              // contacts by dynamic_id, while they're assigned
  std::vector<int> pool_contact_;                // by contact of the layout; -1 if there is none
  std::vector<const btSolverConstraint*> rows_;  // by row of the layout
};

}  // namespace itarl::lockstep
