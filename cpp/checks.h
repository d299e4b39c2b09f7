// Every number that enters Bullet passes here: Bullet neither checks its arguments nor reports a
// NaN, and in single precision a finite f64 may be infinite, or zero.
#pragma once

#include <LinearMath/btTransform.h>

#include <array>
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>
#include <type_traits>

#include "refusal.h"

namespace itarl {

// Where a bounding box is larger than this from corner to corner, Bullet leaves it where it was and,
// if bodies may sleep, puts the body to sleep for good (btCollisionWorld::updateSingleAabb).
inline constexpr double kLongestLength = 1e6;
// Of the bounding box of a body that moves: leaves room below that for turning and moving.
inline constexpr double kLargestMovingDiagonal = 4e5;
// Below this, squared lengths and inertias leave the range of single precision.
inline constexpr double kShortestLength = 1e-6;
// Farther out, single precision knows places to 64 m only, and boxes soon are that long.
inline constexpr double kFarthestPlace = 1e9;
// A body that goes farther in one step would have too long a bounding box, with its own size.
inline constexpr double kLongestMove = 5e5;
// Squares of these stay finite in single precision.
inline constexpr double kLargestNumber = 1e18;

template <typename Float>
std::string to_text(Float value) {
  static_assert(std::is_floating_point_v<Float>);
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;  // shortest that round-trips
  return std::string(text, end);
}

inline std::string to_text(const btVector3& v) {
  return "(" + to_text(v.x()) + ", " + to_text(v.y()) + ", " + to_text(v.z()) + ")";
}

// Whether no component is larger; false for NaN.
inline bool within(const btVector3& v, double largest) {
  const btScalar bound = static_cast<btScalar>(largest);
  return btFabs(v.x()) <= bound && btFabs(v.y()) <= bound && btFabs(v.z()) <= bound;
}
inline bool in_range(const btVector3& v) { return within(v, kLargestNumber); }
inline bool is_near(const btVector3& place) { return within(place, kFarthestPlace); }

// The checks of one call from Rust, which they name in what they refuse.
class Call {
 public:
  explicit constexpr Call(const char* name) : name_(name) {}

  [[noreturn]] void refuse(std::string_view argument, std::string_view expected,
                           std::string_view value) const {
    refuse_argument(name_, argument, expected, value);
  }
  [[noreturn]] void refuse(std::string_view argument, std::string_view expected,
                           double value) const {
    refuse_argument(name_, argument, expected, to_text(value));
  }
  [[noreturn]] void refuse_id(std::string_view argument, std::string_view value,
                              std::string_view why) const {
    itarl::refuse_id(name_, argument, value, why);
  }

  // In [low, high]; the comparison is false for NaN.
  btScalar within(std::string_view argument, double value, double low, double high,
                  std::string_view expected) const {
    if (!(value >= low && value <= high)) refuse(argument, expected, value);
    return static_cast<btScalar>(value);
  }
  btScalar number(std::string_view argument, double value) const {
    return within(argument, value, -kLargestNumber, kLargestNumber,
                  "finite and at most 1e18 in size");
  }
  btScalar non_negative(std::string_view argument, double value) const {
    return within(argument, value, 0, kLargestNumber, "finite, at least 0 and at most 1e18");
  }
  btScalar coordinate(std::string_view argument, double value) const {
    return within(argument, value, -kLongestLength, kLongestLength,
                  "finite and within 1e6 m of the origin");
  }
  btScalar size(std::string_view argument, double value) const {
    return within(argument, value, kShortestLength, kLongestLength, "between 1e-6 and 1e6 m");
  }

  btVector3 numbers(std::string_view argument, const std::array<double, 3>& value) const {
    return each(argument, value, &Call::number);
  }
  btVector3 point(std::string_view argument, const std::array<double, 3>& value) const {
    return each(argument, value, &Call::coordinate);
  }
  btVector3 sizes(std::string_view argument, const std::array<double, 3>& value) const {
    return each(argument, value, &Call::size);
  }

  // A unit quaternion x, y, z, w; it may be off by the rounding of single precision.
  btQuaternion rotation(std::string_view argument, const std::array<double, 4>& value) const {
    double square = 0;
    for (double component : value) square += component * component;
    if (!(std::abs(square - 1) < 1e-5)) {
      refuse(argument, "a unit quaternion", "one of squared length " + to_text(square));
    }
    return btQuaternion(btScalar(value[0]), btScalar(value[1]), btScalar(value[2]),
                        btScalar(value[3]));
  }

 private:
  btVector3 each(std::string_view argument, const std::array<double, 3>& value,
                 btScalar (Call::*check)(std::string_view, double) const) const {
    btVector3 checked(0, 0, 0);
    for (int i = 0; i < 3; ++i) {
      checked[i] = (this->*check)(std::string(argument) + "." + "xyz"[i], value[i]);
    }
    return checked;
  }

  const char* name_;
};

inline std::array<double, 3> to_array(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace itarl
