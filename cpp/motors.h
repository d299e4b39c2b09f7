// What the motors of joints did in the last step: their forces, and the work of these.
#pragma once

#include <memory>
#include <vector>

#include "bullet/src/bridge.rs.h"
#include "pausing.h"

namespace itarl {

struct JointEntry;

// Told of the rows of all joints of a step that has been measured.
class MotorMeter final : public JointRowObserver {
 public:
  explicit MotorMeter(const std::vector<std::unique_ptr<JointEntry>>& joints) : joints_(joints) {}

  // Before each step: a joint that has no row in it, since its bodies sleep, did nothing.
  void begin(btScalar time_step);
  void see(const btTypedConstraint& joint, const btSolverConstraint* rows, int count,
           const btSolverBody& a, const btSolverBody& b) override;

 private:
  const std::vector<std::unique_ptr<JointEntry>>& joints_;
  btScalar time_step_ = 0;
};

}  // namespace itarl
