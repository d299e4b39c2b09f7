// Where the rows of worlds that are built alike lie, and in which order they're swept.
//
// Worlds share a layout if the solver has their joints in the same order (Bullet's sort is
// unstable, and depends on what touches what). A joint has as many rows as in the world where it has
// most; a world that has fewer, as one that is off a hinge's stop, has zeros in the last ones, which
// change nothing. So with contacts: each moving body has as many as in its busiest world. Only worlds
// in which two moving bodies touch need the same contacts, in the same order.
#pragma once

#include <cstdint>
#include <vector>

#include "lockstep/tasks.h"
#include "lockstep/rows.h"
#include "lockstep/schedule.h"

namespace itarl::lockstep {

// Bodies are counted among those that move, in the order of their slots in the world.
struct JointKey {
  std::uint32_t joint;  // its slot in the world
  std::uint32_t a, b;   // kNoBody for what doesn't move
  JointType type;       // whose rows lanes make
  bool operator==(const JointKey& other) const {
    return joint == other.joint && a == other.a && b == other.b && type == other.type;
  }
};
struct ContactKey {
  std::uint32_t a, b;  // b is kNoBody if only one moves
  bool operator==(const ContactKey& other) const { return a == other.a && b == other.b; }
};

// What worlds must have in common to share a layout.
struct Signature {
  std::size_t structure = 0;  // of the world, among those that its Lockstep has seen
  std::vector<JointKey> joints;
  // Empty unless two moving bodies touch; else all contacts.
  std::vector<ContactKey> contacts;
  bool operator==(const Signature& other) const {
    return structure == other.structure && joints == other.joints && contacts == other.contacts;
  }
};

class RowLayout {
 public:
  // `frictions`: friction rows for each contact; `lanes`: how wide the vectors are.
  RowLayout(Signature signature, std::uint32_t bodies, int frictions, bool interleaved, int lanes);

  const Signature& signature() const { return signature_; }
  int lanes() const { return lanes_; }

  // Makes room for a joint's rows, or for a body's contacts. Places change if there was none.
  void need_rows(std::uint32_t joint, std::uint32_t count);
  void need_contacts(std::uint32_t body, std::uint32_t count);

  // What is known of a joint's row. It begins as the most special form and only becomes more
  // general, whereupon places change.
  Form form(const PlacedRow& row) const { return forms_[row.owner][row.part]; }
  void set_form(const PlacedRow& row, Form form) { set_form(row.owner, row.part, form); }
  void set_form(std::uint32_t joint, std::uint32_t part, Form form);

  // The worlds, by a number, whose forms of rows that lanes make were set last: they don't change.
  std::uint64_t fitted_to = 0;

  // Brings places and order up to date after the above.
  void settle();
  bool is_settled() const { return settled_; }

  // In Bullet's order: rows of joints, then of contacts.
  const std::vector<PlacedRow>& rows() const { return placed_; }
  std::size_t joint_row_count() const { return joint_row_count_; }
  // Those of them that Bullet makes.
  const std::vector<std::uint32_t>& pool_rows() const { return pool_rows_; }
  // Of a joint, among rows().
  std::uint32_t first_row(std::uint32_t joint) const { return first_rows_[joint]; }
  // The rows to sweep, without contacts that no world has: `contacts` is their number by body.
  void rows_in_order(const std::vector<std::uint32_t>& contacts, std::vector<Row>& out) const;

  std::uint32_t body_count() const { return bodies_; }
  std::uint32_t body_place(std::uint32_t body) const {
    return body_places_[body == kNoBody ? bodies_ : body];
  }
  // In vectors.
  std::uint32_t size() const { return size_; }
  // A body's contact in the layout; without a list of all contacts.
  std::uint32_t contact_index(std::uint32_t body, std::uint32_t number) const {
    return first_contact_[body] + number;
  }
  // The row of a contact in the layout, and its first row of friction, among rows().
  std::uint32_t contact_row(std::uint32_t contact) const {
    return std::uint32_t(joint_row_count_) + contact * contacts_apart();
  }
  // From one contact's row to the next one's.
  std::uint32_t contacts_apart() const { return std::uint32_t(interleaved_ ? 1 + frictions_ : 1); }
  std::uint32_t friction_row(std::uint32_t contact) const {
    if (interleaved_) return contact_row(contact) + 1;
    return contact_row(std::uint32_t(contacts_.size())) + contact * std::uint32_t(frictions_);
  }
  bool lists_contacts() const { return !signature_.contacts.empty(); }
  std::size_t contact_count() const { return contacts_.size(); }

 private:
  struct Slot {
    std::uint32_t a, b, number;  // number among the body's contacts
  };
  void list_rows();
  void list_joint_rows();
  void list_contact_rows();
  bool goes_on(std::uint32_t row) const;
  std::vector<Touch> touches() const;
  void place_rows();
  void order_rows(const std::vector<Touch>& touches);

  Signature signature_;
  std::uint32_t bodies_;
  int frictions_;  // rows a contact
  bool interleaved_;
  int lanes_;
  bool settled_ = false;
  std::vector<std::uint32_t> body_places_;      // the last one is of what never moves
  std::vector<std::vector<Form>> forms_;        // by joint and row
  std::vector<std::uint32_t> contacts_of_;      // by body
  std::vector<std::uint32_t> first_contact_;    // by body
  std::vector<Slot> contacts_;
  std::vector<PlacedRow> placed_;
  std::size_t joint_row_count_ = 0;
  std::vector<std::uint32_t> first_rows_;  // by joint
  std::vector<std::uint32_t> pool_rows_;
  std::vector<Row> ordered_;
  // Rows of placed_ that are swept in one go.
  struct Run {
    std::uint32_t first, count;
  };
  std::vector<Run> runs_;
  std::vector<std::uint32_t> order_;  // of runs_
  std::uint32_t size_ = 0;
};

}  // namespace itarl::lockstep
