// Numbers and functions of a scalar, for what runs in lanes.
#pragma once

#include <cmath>

namespace itarl::lockstep::ITARL_INSTRUCTIONS {
namespace {

// The largest and the smallest normal number, and what Bullet takes for almost nothing.
template <typename S>
struct Numbers;
template <>
struct Numbers<float> {
  static constexpr float kLargest = __FLT_MAX__, kSmallest = __FLT_MIN__,
                         kEpsilon = __FLT_EPSILON__;
};
template <>
struct Numbers<double> {
  static constexpr double kLargest = __DBL_MAX__, kSmallest = __DBL_MIN__,
                          kEpsilon = __DBL_EPSILON__;
};

template <typename S>
constexpr S kPi = S(3.1415926535897932384626433832795029);

// Functions whose bits are the C library's, a lane at a time.
inline float atan2_of(float y, float x) { return ::atan2f(y, x); }
inline double atan2_of(double y, double x) { return ::atan2(y, x); }
inline float asin_of(float x) { return ::asinf(x < -1 ? -1.f : x > 1 ? 1.f : x); }
inline double asin_of(double x) { return ::asin(x < -1 ? -1. : x > 1 ? 1. : x); }
inline float rest_of(float x, float y) { return ::fmodf(x, y); }
inline double rest_of(double x, double y) { return ::fmod(x, y); }
inline float sine_of(float x) { return ::sinf(x); }
inline double sine_of(double x) { return ::sin(x); }
inline float cosine_of(float x) { return ::cosf(x); }
inline double cosine_of(double x) { return ::cos(x); }

}  // namespace
}  // namespace itarl::lockstep::ITARL_INSTRUCTIONS
