// Which joints' rows can be made in lanes, and what these need to know of a joint.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <functional>
#include <vector>

#include "lockstep/tasks.h"
#include "lockstep/rows.h"

namespace itarl {
enum class JointKind : std::uint8_t;
}

namespace itarl::lockstep {

struct JointForm {
  JointType type;
  std::vector<Form> rows;  // empty if Bullet makes the rows
};

// Of a joint that is ready to be stepped.
JointForm form_of(btTypedConstraint& joint, JointKind kind, const btContactSolverInfo& info);

// How many numbers lanes need.
std::uint32_t numbers_of(JointType type);

// Gives what doesn't change from step to step: place among the numbers, and number.
using Put = std::function<void(std::uint32_t, btScalar)>;
void put_numbers(btTypedConstraint& joint, JointType type, btScalar time_step,
                 const btContactSolverInfo& info, const Put& put);

}  // namespace itarl::lockstep
