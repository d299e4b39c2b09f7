// The rows of a sweep: what packing.cc fills in, schedule.cc puts in order and sweep.inc works off.
//
// A row holds two bodies to one condition on their velocities. One update of it is, in Bullet
// (gResolveSingleConstraintRowGeneric_scalar_reference) and here,
//
//   delta    = rhs - applied cfm - (n1.vA + r1.wA) k - (n2.vB + r2.wB) k      k = 1 / (J M^-1 J^T)
//   applied' = applied + delta, held within lower and upper;  delta = what that changed
//   vA += n1 mA delta    wA += eA delta    vB += n2 mB delta    wB += eB delta
//
// with v and w the changes of linear and angular velocity so far, m inverse masses, and e the
// inverse inertia times r. Each number is a vector of as many worlds as there are lanes.
//
// No Bullet header is included here or in a sweep: inline functions of theirs, compiled for newer
// processors, could be the copies that the linker keeps for all.
#pragma once

#include <cstdint>

namespace itarl::lockstep {

// Special forms leave out what is zero or known: exact, since a sum that began at +0 only becomes
// -0 by adding -0 to -0, so that a term of either zero changes no velocity.
enum class Kind : std::uint8_t {
  AngularFree,  // n1 = n2 = 0, r2 = -r1, cfm = 0, no limits
  Angular,      // the same with limits: one row, or more with the same r1
  FullFree,     // n2 = -n1, cfm = 0, no limits: one row, or more of a joint
  Full,         // the same with limits
  General,      // anything
  Contact,      // one moving body; the impulse is at least 0; from here on rows of contacts
  Friction,     // one moving body; limits follow the contact's impulse
  PairContact,  // two moving bodies
  PairFriction,
};

// Places are counted in vectors of all lanes.
struct Row {
  Kind kind;
  std::uint8_t count;      // 1, or how many rows a run has
  std::uint32_t a, b;      // of the bodies' blocks
  std::uint32_t jacobian;  // of what doesn't change, and what a run of Angular rows shares
  std::uint32_t target;    // of the right-hand side and what goes with it; those of a run follow each other
  std::uint32_t applied;   // of the impulse so far, the one thing in a row that changes
  std::uint32_t contact;   // of the impulse of a friction row's contact
};

// A body's block: v (3), w (3), inverse mass, unused.
inline constexpr std::uint32_t kBodyBlock = 8;
inline constexpr std::uint32_t kInverseMass = 6;

// A row's Jacobian block.
//   Angular            r1 eA eB k
//   Full               n1 r1 r2 eA eB k
//   General, Pair...   n1 r1 n2 r2 eA eB k cfm
//   Contact, Friction  n r e k cfm
inline constexpr std::uint32_t jacobian_block(Kind kind) {
  switch (kind) {
    case Kind::AngularFree:
    case Kind::Angular:
      return 10;
    case Kind::FullFree:
    case Kind::Full:
      return 16;
    case Kind::Contact:
    case Kind::Friction:
      return 11;
    default:
      return 20;
  }
}

// A row's target block: rhs; then lower and upper limit, or the coefficient of friction.
inline constexpr std::uint32_t kLower = 1;
inline constexpr std::uint32_t kUpper = 2;
inline constexpr std::uint32_t kCoefficient = 1;
inline constexpr std::uint32_t target_block(Kind kind) {
  switch (kind) {
    case Kind::AngularFree:
    case Kind::FullFree:
    case Kind::Contact:
    case Kind::PairContact:
      return 1;
    case Kind::Friction:
    case Kind::PairFriction:
      return 2;
    default:
      return 3;
  }
}

// What is special about a joint's row.
struct Form {
  bool angular = true;  // n1 = n2 = 0, r2 = -r1, cfm = 0
  bool full = true;     // n2 = -n1, cfm = 0
  bool free = true;     // no limits
  bool shares = true;   // r1 of the row before it
  bool operator==(const Form& other) const {
    return angular == other.angular && full == other.full && free == other.free &&
           shares == other.shares;
  }
  Form operator&(const Form& other) const {
    return {angular && other.angular, full && other.full, free && other.free,
            shares && other.shares};
  }
};

// A row as packing sees it.
struct PlacedRow {
  Kind kind;
  std::uint32_t owner;        // index of its joint, or of its contact
  std::uint32_t part;         // number in its joint; 0 for a contact, else 1 + which friction row
  std::uint32_t jacobian;     // places, as in Row
  std::uint32_t target;
  std::uint32_t applied;
  bool shares;                // the Jacobian of the row before it
};

inline constexpr bool is_angular(Kind kind) {
  return kind == Kind::AngularFree || kind == Kind::Angular;
}
inline constexpr bool is_full(Kind kind) { return kind == Kind::FullFree || kind == Kind::Full; }
inline constexpr bool is_contact(Kind kind) { return kind >= Kind::Contact; }
inline constexpr bool is_friction(Kind kind) {
  return kind == Kind::Friction || kind == Kind::PairFriction;
}
// Rows with one moving body have it in `a`.
inline constexpr bool has_pair(Kind kind) { return kind != Kind::Contact && kind != Kind::Friction; }

}  // namespace itarl::lockstep
