// What the rows of joints are made of, and which joints' rows are made in lanes.
//
// Worlds hand over numbers; all that is computed from them is computed in lanes: sliders in
// slider.inc, joints of six axes (fixed ones, too) in six_axes.inc. Each number here is a vector
// with a world in each lane. No Bullet header is included here (see rows.h).
#pragma once

#include <cstdint>

#include "lockstep/rows.h"

namespace itarl::lockstep {

#ifdef ITARL_FLOAT64
using Scalar = double;
#else
using Scalar = float;
#endif

// What decides which rows a joint has, as one number. 0: Bullet makes its rows, in its pools.
struct JointType {
  enum Class : std::uint32_t { FromPools, Slider, SixAxes };
  enum Limit : std::uint32_t { Free, Locked, Range };

  std::uint32_t bits = 0;

  // Axes are x, y, z, then the rotations about them; of a slider, 0 and 3 count.
  static JointType of(Class kind) { return {kind}; }
  void set_axis(int axis, Limit limit, bool motor, bool spring) {
    bits |= (limit | std::uint32_t(motor) << 2 | std::uint32_t(spring) << 3) << (2 + 4 * axis);
  }
  Class kind() const { return Class(bits & 3); }
  Limit limit(int axis) const { return Limit(bits >> (2 + 4 * axis) & 3); }
  bool motor(int axis) const { return (bits >> (4 + 4 * axis) & 1) != 0; }
  bool spring(int axis) const { return (bits >> (5 + 4 * axis) & 1) != 0; }
  bool operator==(const JointType& other) const { return bits == other.bits; }
};

// Of a world.
enum WorldNumber : std::uint32_t {
  kFps,       // 1 / time step, as Bullet's joints have it
  kDt,        // 1 / fps
  kStiffest,  // 1 / dt / dt / 16
  kTimeStep,
  kPerSecond,  // 1 / time step, as reports have it
  kWorldNumbers,
};

// Of a body that moves.
enum BodyNumber : std::uint32_t {
  kPose = 0,      // rotation, row by row, then position
  kInertia = 12,  // inverse, in the world's axes
  kLinear = 21,   // velocity
  kAngular = 24,
  kForce = 27,  // what forces add to the velocity in this step
  kTorque = 30,
  kBodyInverseMass = 33,
  kInertiaOwn = 34,  // inverse, about the body's own axes
  kBodyNumbers = 37,
};

enum SliderNumber : std::uint32_t {
  kSliderFrameA = 0,
  kSliderFrameB = 12,
  kFactorA = 24,  // of body A's part, by masses
  kFactorB,
  kHeldAngularRate,  // fps * erp
  kHeldLinearRate,
  kLinearStop,  // and what follows, as in SliderStop
  kAngularStop = kLinearStop + 8,
  kSliderCfm = kAngularStop + 8,  // of each row
  kSliderNumbers = kSliderCfm + 6,
};
enum SliderStop : std::uint32_t {
  kStopLower,
  kStopUpper,
  kStopRate,  // fps * erp
  kStopSoftness,
  kStopBounce,
  kStopTarget,  // of the motor: velocity
  kStopForce,
};

enum SixAxesNumber : std::uint32_t {
  kSixFrameA = 0,
  kSixFrameB = 12,
  kMassA = 24,
  kMassB,
  kEndless,  // 1 if springs ask for more than they get, and 0 if they ask for what they need
  kAxes,     // each as in AxisNumber
};
enum AxisNumber : std::uint32_t {
  kAxisLower,
  kAxisUpper,
  kAxisErp,   // of the stop
  kAxisRate,  // fps * erp
  kAxisBounce,
  kAxisMotorRate,
  kAxisStiffness,
  kAxisDamping,
  kAxisEquilibrium,
  kAxisStopCfm,
  kAxisMotorCfm,
  kAxisTarget,  // of the motor: velocity
  kAxisForce,
  kAxisNumbers,
};
inline constexpr std::uint32_t kSixAxesNumbers = kAxes + 6 * kAxisNumbers;

// Of a report: body B's force, then its torque.
inline constexpr std::uint32_t kReportNumbers = 6;

struct JointPlan {
  JointType type;
  std::uint32_t a, b;                  // places of its bodies
  std::uint32_t numbers;               // place
  std::uint32_t first_row, row_count;  // among the layout's rows
};

// Rows to make before a sweep, and to report of after it.
struct JointTask {
  const JointPlan* begin;
  const JointPlan* end;
  const PlacedRow* rows;
  const Scalar* worlds;  // kWorldNumbers
  const Scalar* bodies;
  const Scalar* numbers;
  Scalar* values;  // of the sweep
  int lanes;       // with a world
  // Filled in when rows are made: lanes with a row that can't be swept, as bits; and how large k is
  // at most, by lane.
  std::uint32_t unsound;
  Scalar* largest_k;
  // Filled in when they're reported of: kReportNumbers for each joint; and lanes with an impulse as
  // large as numbers go, at which Bullet switches the joint off, as bits.
  Scalar* reports;
  std::uint32_t extreme;
};

using JointFunction = void (*)(JointTask&);

// Of a body that was moved, in threes.
enum MovedNumber : std::uint32_t {
  kMovedBasis = 0,
  kMovedOrigin = 9,
  kMovedInertia = 12,
  kMovedLinear = 21,
  kMovedAngular = 24,
  kMovedNumbers = 27,
};

// Bodies to move, after a sweep.
struct MoveTask {
  std::uint32_t bodies;
  const std::uint32_t* places;  // of each body's block in `values`
  const Scalar* worlds;
  const Scalar* numbers;  // kBodyNumbers for each
  const Scalar* values;   // of the sweep
  int lanes;              // with a world
  Scalar* moved;          // to be filled in: kMovedNumbers for each
};

using MoveFunction = void (*)(const MoveTask&);

// Bodies' gyroscopic impulses: of each its rotation (9), angular velocity and inverse inertia about
// its own axes.
inline constexpr std::uint32_t kGyroscopicNumbers = 15;
struct GyroscopicTask {
  std::uint32_t bodies;
  const Scalar* time_step;
  const Scalar* numbers;
  Scalar* impulses;  // to be filled in: three for each
};

using GyroscopicFunction = void (*)(const GyroscopicTask&);

}  // namespace itarl::lockstep
