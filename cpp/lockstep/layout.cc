#include "lockstep/layout.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "lockstep/sweep.h"

namespace itarl::lockstep {

namespace {

Kind kind_of(const Form& form) {
  if (form.angular) return form.free ? Kind::AngularFree : Kind::Angular;
  if (form.full) return form.free ? Kind::FullFree : Kind::Full;
  return Kind::General;
}

// Hands out places within one part of each page of memory, which must be as long as what is taken.
class Shelf {
 public:
  Shelf(std::uint32_t page, std::uint32_t begin, std::uint32_t end)
      : page_(page), begin_(begin), end_(end), next_(begin) {}

  std::uint32_t take(std::uint32_t vectors) {
    if (next_ % page_ + vectors > end_) next_ += page_ - next_ % page_ + begin_;
    const std::uint32_t place = next_;
    next_ += vectors;
    // A full page ends where the next one begins.
    if (next_ % page_ == 0) next_ += begin_;
    return place;
  }
  std::uint32_t size() const { return next_; }

 private:
  std::uint32_t page_, begin_, end_, next_;
};

// Half a page of memory, in vectors: 32 at least.
std::uint32_t page_part(int lanes) {
  return std::uint32_t(2048 / (sizeof(Scalar) * std::size_t(lanes)));
}

}  // namespace

RowLayout::RowLayout(Signature signature, std::uint32_t bodies, int frictions, bool interleaved,
               int lanes)
    : signature_(std::move(signature)),
      bodies_(bodies),
      frictions_(frictions),
      interleaved_(interleaved),
      lanes_(lanes),
      forms_(signature_.joints.size()),
      contacts_of_(bodies, 0),
      first_contact_(bodies, 0) {}

void RowLayout::need_rows(std::uint32_t joint, std::uint32_t count) {
  if (count <= forms_[joint].size()) return;
  forms_[joint].resize(count);
  settled_ = false;
}

void RowLayout::need_contacts(std::uint32_t body, std::uint32_t count) {
  if (count <= contacts_of_[body]) return;
  contacts_of_[body] = count;
  settled_ = false;
}

void RowLayout::set_form(std::uint32_t joint, std::uint32_t part, Form form) {
  forms_[joint][part] = form;
  settled_ = false;
}

void RowLayout::settle() {
  if (settled_) return;
  list_rows();
  runs_.clear();
  for (std::uint32_t i = 0; i < placed_.size(); ++i) {
    if (placed_[i].shares || goes_on(i)) {
      ++runs_.back().count;
    } else {
      runs_.push_back({i, 1});
    }
  }
  const std::vector<Touch> bodies = touches();
  order_ = schedule(bodies, sweeps_alone(lanes_));
  place_rows();
  order_rows(bodies);
  settled_ = true;
}

void RowLayout::list_rows() {
  placed_.clear();
  list_joint_rows();
  joint_row_count_ = placed_.size();
  list_contact_rows();
  pool_rows_.clear();
  for (std::uint32_t i = 0; i < placed_.size(); ++i) {
    const bool of_lanes =
        i < joint_row_count_ &&
        signature_.joints[placed_[i].owner].type.kind() != JointType::FromPools;
    if (!of_lanes) pool_rows_.push_back(i);
  }
}

void RowLayout::list_joint_rows() {
  first_rows_.clear();
  // The targets of a run must fit into their part of a page.
  const std::uint32_t longest = page_part(lanes_) / target_block(Kind::Angular);
  for (std::uint32_t joint = 0; joint < forms_.size(); ++joint) {
    first_rows_.push_back(std::uint32_t(placed_.size()));
    bool shares = false;  // whether a row could share with the one before
    std::uint32_t length = 0;  // of the run so far
    for (std::uint32_t i = 0; i < forms_[joint].size(); ++i) {
      const Form& form = forms_[joint][i];
      shares = shares && form.angular && form.shares && length < longest;
      length = shares ? length + 1 : 1;
      placed_.push_back({kind_of(form), joint, i, 0, 0, 0, shares});
      if (shares) {
        // A run is limited as a whole: what has no limits has some that are never reached.
        placed_.back().kind = Kind::Angular;
        for (auto row = placed_.rbegin() + 1;; ++row) {
          row->kind = Kind::Angular;
          if (!row->shares) break;
        }
      }
      shares = form.angular;
    }
  }
}

void RowLayout::list_contact_rows() {
  contacts_.clear();
  for (const ContactKey& key : signature_.contacts) contacts_.push_back({key.a, key.b, 0});
  for (std::uint32_t body = 0; body < bodies_ && !lists_contacts(); ++body) {
    first_contact_[body] = std::uint32_t(contacts_.size());
    for (std::uint32_t i = 0; i < contacts_of_[body]; ++i) contacts_.push_back({body, kNoBody, i});
  }
  const auto push = [&](std::uint32_t contact, std::uint32_t part) {
    const bool pair = contacts_[contact].b != kNoBody;
    const Kind kind = part == 0 ? (pair ? Kind::PairContact : Kind::Contact)
                                : (pair ? Kind::PairFriction : Kind::Friction);
    placed_.push_back({kind, contact, part, 0, 0, 0, false});
  };
  const auto frictions = [&](std::uint32_t contact) {
    for (int i = 1; i <= frictions_; ++i) push(contact, std::uint32_t(i));
  };
  for (std::uint32_t contact = 0; contact < contacts_.size(); ++contact) {
    push(contact, 0);
    if (interleaved_) frictions(contact);
  }
  for (std::uint32_t contact = 0; contact < contacts_.size() && !interleaved_; ++contact) {
    frictions(contact);
  }
}

// Whether a row without limits is swept in one go with the one before.
bool RowLayout::goes_on(std::uint32_t row) const {
  if (!sweeps_runs(lanes_) || row == 0 || row >= joint_row_count_) return false;
  // A run's Jacobians must fit into their part of a page.
  if (runs_.back().count == page_part(lanes_) / jacobian_block(Kind::FullFree)) return false;
  const PlacedRow &one = placed_[row - 1], &other = placed_[row];
  return one.kind == Kind::FullFree && other.kind == Kind::FullFree && one.owner == other.owner;
}

// Nothing may come between the rows of a run, so a run counts as one.
std::vector<Touch> RowLayout::touches() const {
  std::vector<Touch> touches;
  for (const Run& run : runs_) {
    const PlacedRow& row = placed_[run.first];
    if (run.first < joint_row_count_) {
      const JointKey& joint = signature_.joints[row.owner];
      touches.push_back({row.kind, run.count, joint.a, joint.b});
    } else {
      touches.push_back({row.kind, 1, contacts_[row.owner].a, contacts_[row.owner].b});
    }
  }
  return touches;
}

// In the order of the sweep, so that it goes through memory from one end to the other. What is
// written lies in the first half of memory's pages, what is only read in the second: processors
// take a read for one of what was just written if the two have the same place in a page, and wait.
// And since that place is also the place in the nearest cache, what is read once an iteration
// doesn't drive out there what is read all the time.
void RowLayout::place_rows() {
  const std::uint32_t part = page_part(lanes_);
  Shelf written(2 * part, 0, part);
  Shelf read(2 * part, part, 2 * part);
  body_places_.clear();
  for (std::uint32_t body = 0; body <= bodies_; ++body) {
    body_places_.push_back(written.take(kBodyBlock));
  }
  for (const std::uint32_t i : order_) {
    const Run& run = runs_[i];
    const Kind kind = placed_[run.first].kind;
    // Rows about one axis share a Jacobian; others have each its own.
    const std::uint32_t each = is_angular(kind) ? 0 : jacobian_block(kind);
    const std::uint32_t jacobian = read.take(jacobian_block(kind) + each * (run.count - 1));
    const std::uint32_t target = read.take(target_block(kind) * run.count);
    const std::uint32_t applied = written.take(run.count);
    for (std::uint32_t k = 0; k < run.count; ++k) {
      PlacedRow& row = placed_[run.first + k];
      row.jacobian = jacobian + k * each;
      row.target = target + k * target_block(kind);
      row.applied = applied + k;
    }
  }
  size_ = std::max(written.size(), read.size());
}

void RowLayout::order_rows(const std::vector<Touch>& touches) {
  std::vector<std::uint32_t> impulses(contacts_.size(), 0);
  for (std::size_t i = joint_row_count_; i < placed_.size(); ++i) {
    if (placed_[i].part == 0) impulses[placed_[i].owner] = placed_[i].applied;
  }
  ordered_.clear();
  for (const std::uint32_t i : order_) {
    const PlacedRow& row = placed_[runs_[i].first];
    ordered_.push_back({row.kind, std::uint8_t(runs_[i].count), body_place(touches[i].a),
                        body_place(touches[i].b), row.jacobian, row.target, row.applied,
                        is_friction(row.kind) ? impulses[row.owner] : 0});
  }
}

void RowLayout::rows_in_order(const std::vector<std::uint32_t>& contacts,
                           std::vector<Row>& out) const {
  out.clear();
  for (std::size_t i = 0; i < order_.size(); ++i) {
    const std::uint32_t first = runs_[order_[i]].first;
    const PlacedRow& row = placed_[first];
    if (first >= joint_row_count_ && !lists_contacts()) {
      const Slot& slot = contacts_[row.owner];
      if (slot.number >= contacts[slot.a]) continue;
    }
    out.push_back(ordered_[i]);
  }
}

}  // namespace itarl::lockstep
