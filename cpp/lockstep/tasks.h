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
  kPerSecond,  // 1 / time step, as reports and contacts have it
  kContactCfm,
  kContactErp,
  kRelaxation,
  kWarmStart,  // how much of the last step's impulse a contact begins with
  kSlop,
  kLeastBounce,  // speed from which on bodies bounce
  kDeepest,      // penetration from which on Bullet would push bodies apart by other means
  kFastest,      // the range of a body's numbers in which a world may go on: of its speed,
  kFarthest,     // of its place,
  kLargest,      // and of any
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

// Of a body's shape and the plane that it may meet.
enum PairNumber : std::uint32_t {
  kPlanePose = 0,
  kPlaneAway = 12,    // where the inverse of that pose has its origin
  kPlaneNormal = 15,  // in its own frame
  kPlaneConstant = 18,
  kPlaneUp = 19,    // the normal in the world
  kPlaneAlong = 22,  // a direction in the plane: btPlaneSpace1
  kShapeFrame = 25,  // in the body's; if it's the child of a compound
  kHalfExtents = 37,  // of a box
  kHalfHeight = 40,   // of a capsule
  kMargin,
  kBreaking,  // distance up to which a point of contact lasts
  kPairFriction,
  kPairRestitution,
  kPairNumbers,
};

// Of a point of contact.
enum PointNumber : std::uint32_t {
  kLocalA = 0,  // the body's side, in the body's frame
  kLocalB = 3,  // the plane's, in its
  kWorldA = 6,
  kWorldB = 9,
  kDistance = 12,
  kImpulse,
  kLateral,    // impulse along kDirection
  kLife,       // how often it was refreshed, below kLifeUnit,
  kLifeUnits,  // and how many of these
  kDirection,  // of friction
  kPointNumbers = kDirection + 3,
};
inline constexpr int kMostPoints = 4;
inline constexpr std::uint32_t kLifeUnit = 1 << 20;  // any sum up to here is exact
// How many points there are, then each.
inline constexpr std::uint32_t kManifoldNumbers = 1 + kMostPoints * kPointNumbers;

enum class PairShape : std::uint8_t { Box, Capsule };  // a sphere is a capsule without height

// A body and the plane that it may meet.
struct PairPlan {
  PairShape shape;
  std::uint8_t up;     // a capsule's axis
  bool in_compound;    // its body's shape is a compound with one child
  std::uint32_t body;  // place of its numbers
  std::uint32_t block;  // place of its block in the sweep's values
  std::uint32_t contact;  // the first one's row among the layout's
  std::uint32_t friction;  // and its friction row
  std::uint32_t apart;     // from one contact's row to the next one's, and likewise for friction
};

// Contacts to find before a sweep, and their rows to make. Of each pair, one after the other:
struct ContactTask {
  const PairPlan* begin;
  const PairPlan* end;
  const Scalar* worlds;
  const Scalar* bodies;
  const Scalar* numbers;      // kPairNumbers
  const Scalar* before;       // kManifoldNumbers
  Scalar* after;              // the same; filled in when contacts are found
  std::uint32_t* most_points;  // in any world; filled in with them
  // For rows.
  const PlacedRow* rows;
  Scalar* values;
  std::uint32_t unsound;  // filled in: lanes with a row that can't be swept, as bits
  Scalar* largest_k;      // by lane, brought up to date
};

using ContactFunction = void (*)(ContactTask&);

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
  const Scalar* angles;  // of each joint, as read_angles() has them; null if they aren't known
  Scalar* values;        // of the sweep
  int lanes;             // with a world
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

// Of a body's numbers, those that a step changes.
inline constexpr std::uint32_t kMovedNumbers = kForce;

// Bodies to move, after a sweep.
struct MoveTask {
  std::uint32_t bodies;
  const std::uint32_t* places;  // of each body's block in `values`
  const Scalar* worlds;
  const Scalar* numbers;  // kBodyNumbers for each
  const Scalar* values;   // of the sweep
  int lanes;              // with a world
  Scalar* moved;          // to be filled in for each: the first kMovedNumbers of a body's numbers
  std::uint32_t stride;   // how many numbers further the next body's begin
};

using MoveFunction = void (*)(const MoveTask&);
// Which lanes have a body that left the range in which a world may go on, as bits.
using RangeFunction = std::uint32_t (*)(const MoveTask&);
// The angles of all joints, three vectors for each plan: a slider's in the first one, or those that
// btGeneric6DofSpring2Constraint has about x, y and z.
using AngleFunction = void (*)(const JointTask&, Scalar* angles);

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
// The same for bodies with kBodyNumbers, into which they're put as kTorque.
using TwistFunction = void (*)(std::uint32_t bodies, const Scalar* worlds, Scalar* numbers);

}  // namespace itarl::lockstep
