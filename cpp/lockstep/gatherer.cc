#include "lockstep/gatherer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "lockstep/joint_form.h"
#include "lockstep/moving.h"
#include "state.h"

namespace itarl::lockstep {

namespace {

// Groups of worlds whose joints are kept at hand.
constexpr std::size_t kMostCopies = 16;

}  // namespace

std::uint64_t Gatherer::enter(const std::vector<State*>& worlds, int width) {
  lanes_ = worlds;
  width_ = width;
  copy_ = &copy_for(width);
  return copy_->number;
}

void Gatherer::gather(const RowLayout& layout) {
  gather_worlds();
  plan(layout);
  gather_motors();
}

void Gatherer::gather_bodies(const RowLayout& layout, const std::vector<WorldRows*>& lanes) {
  with_width(width_, [&](auto width) { gather_bodies<width.value>(layout.body_count(), lanes); });
}

Gatherer::Copy& Gatherer::copy_for(int width) {
  const auto is_same = [&](const std::unique_ptr<Copy>& copy) {
    return copy->width == width &&
           std::equal(
               copy->builds.begin(), copy->builds.end(), lanes_.begin(), lanes_.end(),
               [](const auto& build, const State* of) { return build == of->build; });
  };
  const auto known = std::find_if(copies_.begin(), copies_.end(), is_same);
  if (known != copies_.end()) return **known;
  if (copies_.size() < kMostCopies) {
    copies_.push_back(std::make_unique<Copy>());
    next_copy_ = copies_.size() - 1;
  } else {
    next_copy_ = (next_copy_ + 1) % kMostCopies;
  }
  Copy& copy = *copies_[next_copy_];
  copy.builds.clear();  // unknown until it's filled
  copy.width = width;
  copy.number = ++made_;
  fill(copy);
  for (const State* const of : lanes_) copy.builds.push_back(of->build);
  return copy;
}

void Gatherer::fill(Copy& copy) const {
  copy.places.clear();
  std::uint32_t size = 0;
  const auto& joints = lane(0).joints;  // as in all of them
  for (const auto& entry : joints) {
    copy.places.push_back(size);
    if (entry) size += numbers_of(entry->form.type);
  }
  const auto width = std::size_t(width_);
  copy.numbers.make_room(size * width);
  for (std::size_t i = 0; i < width; ++i) {
    State& state = lane(i);
    for (std::size_t joint = 0; joint < joints.size(); ++joint) {
      const auto& entry = state.joints[joint];
      if (!entry || entry->form.type.kind() == JointType::FromPools) continue;
      Scalar* const to = copy.numbers.begin() + copy.places[joint] * width + i;
      put_numbers(*entry->joint, entry->form.type, state.time_step, state.world.getSolverInfo(),
                  [&](std::uint32_t place, btScalar number) { to[place * width] = number; });
    }
  }
}

void Gatherer::plan(const RowLayout& layout) {
  plans_.clear();
  joints_.clear();
  const std::vector<JointKey>& keys = layout.signature().joints;
  for (std::uint32_t i = 0; i < keys.size(); ++i) {
    const JointKey& key = keys[i];
    if (key.type.kind() == JointType::FromPools) continue;
    const auto rows = std::uint32_t(lane(0).joints[key.joint]->form.rows.size());
    plans_.push_back({key.type, key.a * kBodyNumbers, key.b * kBodyNumbers,
                      copy_->places[key.joint], layout.first_row(i), rows});
    joints_.push_back(key.joint);
  }
}

void Gatherer::gather_worlds() {
  const auto width = std::size_t(width_);
  worlds_.make_room(kWorldNumbers * width);
  for (std::size_t i = 0; i < width; ++i) {
    const btScalar time_step = lane(i).time_step;
    const btScalar fps = 1.f / time_step, dt = btScalar(1) / fps;
    Scalar* const to = worlds_.begin() + i;
    to[kFps * width] = fps;
    to[kDt * width] = dt;
    to[kStiffest * width] = btScalar(1) / dt / dt / btScalar(16);
    to[kTimeStep * width] = time_step;
    to[kPerSecond * width] = btScalar(1) / time_step;
    const btContactSolverInfo& info = lane(i).world.getSolverInfo();
    to[kContactCfm * width] = info.m_globalCfm * (btScalar(1) / time_step);
    to[kContactErp * width] = info.m_erp2;
    to[kRelaxation * width] = info.m_sor;
    to[kWarmStart * width] = info.m_warmstartingFactor;
    to[kSlop * width] = info.m_linearSlop;
    to[kLeastBounce * width] = info.m_restitutionVelocityThreshold;
    to[kDeepest * width] = info.m_splitImpulse ? btScalar(info.m_splitImpulsePenetrationThreshold)
                                               : -std::numeric_limits<btScalar>::infinity();
    to[kFastest * width] = btScalar(lane(i).fastest());
    to[kFarthest * width] = btScalar(kFarthestPlace);
    to[kLargest * width] = btScalar(kLargestNumber);
  }
}

void Gatherer::gather_motors() {
  const auto width = std::size_t(width_);
  for (std::size_t k = 0; k < plans_.size(); ++k) {
    const JointPlan& plan = plans_[k];
    Scalar* const numbers = copy_->numbers.begin() + plan.numbers * width;
    for (std::size_t i = 0; i < width; ++i) {
      btTypedConstraint& joint = *lane(i).joints[joints_[k]]->joint;
      const auto put = [&](std::uint32_t target, btScalar velocity, btScalar force) {
        numbers[target * width + i] = velocity;
        numbers[(target + 1) * width + i] = force;
      };
      if (plan.type.kind() == JointType::Slider) {
        auto& slider = static_cast<btSliderConstraint&>(joint);
        if (plan.type.motor(0)) {
          put(kLinearStop + kStopTarget, slider.getTargetLinMotorVelocity(),
              slider.getMaxLinMotorForce());
        }
        if (plan.type.motor(3)) {
          put(kAngularStop + kStopTarget, slider.getTargetAngMotorVelocity(),
              slider.getMaxAngMotorForce());
        }
        continue;
      }
      auto& six = static_cast<btGeneric6DofSpring2Constraint&>(joint);
      for (int axis = 0; axis < 6; ++axis) {
        if (!plan.type.motor(axis)) continue;
        const std::uint32_t target = kAxes + std::uint32_t(axis) * kAxisNumbers + kAxisTarget;
        if (axis < 3) {
          const btTranslationalLimitMotor2& motor = *six.getTranslationalLimitMotor();
          put(target, motor.m_targetVelocity[axis], motor.m_maxMotorForce[axis]);
        } else {
          const btRotationalLimitMotor2& motor = *six.getRotationalLimitMotor(axis - 3);
          put(target, motor.m_targetVelocity, motor.m_maxMotorForce);
        }
      }
    }
  }
}

template <int W>
void Gatherer::gather_bodies(std::uint32_t bodies, const std::vector<WorldRows*>& lanes) {
  static const btVector3 zero(0, 0, 0);
  bodies_.make_room(std::size_t(bodies) * kBodyNumbers * W);
  for (std::uint32_t body = 0; body < bodies; ++body) {
    Scalar* const to = bodies_.begin() + std::size_t(body) * kBodyNumbers * W;
    std::array<const btSolverBody*, W> from;
    for (std::size_t i = 0; i < W; ++i) from[i] = lanes[std::min(i, lanes.size() - 1)]->body(body);
    alignas(64) std::array<Scalar, W> unused;
    const auto three = [&](std::uint32_t place, auto member) {
      Scalar* const x = to + place * W;
      transpose<W>({x, x + W, x + 2 * W, unused.data()}, [&](int i) {
        const btSolverBody* const solver = from[std::size_t(i)];
        return (solver == nullptr ? zero : member(*solver)).m_floats;
      });
    };
    for (int row = 0; row < 3; ++row) {
      const auto place = std::uint32_t(3 * row);
      three(kPose + place, [row](auto& of) -> const btVector3& {
        return of.m_originalBody->getWorldTransform().getBasis()[row];
      });
      three(kInertia + place, [row](auto& of) -> const btVector3& {
        return of.m_originalBody->getInvInertiaTensorWorld()[row];
      });
    }
    three(kPose + 9, [](auto& of) -> const btVector3& {
      return of.m_originalBody->getWorldTransform().getOrigin();
    });
    three(kLinear,
          [](auto& of) -> const btVector3& { return of.m_originalBody->getLinearVelocity(); });
    three(kAngular,
          [](auto& of) -> const btVector3& { return of.m_originalBody->getAngularVelocity(); });
    three(kForce, [](auto& of) -> const btVector3& { return of.m_externalForceImpulse; });
    three(kTorque, [](auto& of) -> const btVector3& { return of.m_externalTorqueImpulse; });
    three(kInertiaOwn,
          [](auto& of) -> const btVector3& { return of.m_originalBody->getInvInertiaDiagLocal(); });
    for (std::size_t i = 0; i < W; ++i) {
      to[kBodyInverseMass * W + i] = from[i] == nullptr ? 0 : from[i]->m_originalBody->getInvMass();
    }
  }
}

JointTask& Gatherer::task(const RowLayout& layout, Scalar* values, Scalar* largest_k) {
  reports_.make_room(plans_.size() * kReportNumbers * std::size_t(width_));
  task_ = {plans_.data(),
           plans_.data() + plans_.size(),
           layout.rows().data(),
           worlds_.begin(),
           bodies_.begin(),
           copy_->numbers.begin(),
           nullptr,
           values,
           int(lanes_.size()),
           0,
           largest_k,
           reports_.begin(),
           0};
  return task_;
}

void Gatherer::report(std::uint32_t lane, State& to) const {
  const auto width = std::size_t(width_);
  for (std::size_t k = 0; k < plans_.size(); ++k) {
    const PlacedRow& last = task_.rows[plans_[k].first_row + plans_[k].row_count - 1];
    JointEntry& joint = *to.joints[joints_[k]];
    joint.joint->internalSetAppliedImpulse(task_.values[last.applied * width + lane]);
    const Scalar* const from = reports_.begin() + k * kReportNumbers * width + lane;
    const auto number = [&](std::size_t i) { return from[i * width]; };
    joint.feedback.m_appliedForceBodyB.setValue(number(0), number(1), number(2));
    joint.feedback.m_appliedTorqueBodyB.setValue(number(3), number(4), number(5));
  }
}

// As check_impulses in world.cc.
std::uint32_t Gatherer::not_finite() const {
  const auto width = std::size_t(width_);
  std::array<Scalar, 16> sums{};
  for (std::size_t k = 0; k < 2 * plans_.size(); ++k) {
    const Scalar* const x = reports_.begin() + 3 * k * width;
    for (std::size_t i = 0; i < width; ++i) {
      sums[i] += (std::abs(x[i]) + std::abs(x[width + i]) + std::abs(x[2 * width + i])) * 0;
    }
  }
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < width; ++i) bits |= std::uint32_t(!(sums[i] == 0)) << i;
  return bits;
}

MoveTask Gatherer::moves(const RowLayout& layout, const Scalar* values) {
  body_places_.clear();
  for (std::uint32_t i = 0; i < layout.body_count(); ++i) {
    body_places_.push_back(layout.body_place(i));
  }
  moved_.make_room(std::size_t(layout.body_count()) * kMovedNumbers * std::size_t(width_));
  return {layout.body_count(), body_places_.data(), worlds_.begin(), bodies_.begin(), values,
          int(lanes_.size()),  moved_.begin(),       kMovedNumbers};
}

void Gatherer::move(std::uint32_t lanes, const std::vector<WorldRows*>& to) const {
  const auto width = std::size_t(width_);
  for (std::size_t i = 0; i < to.size(); ++i) {
    if ((lanes >> i & 1) == 0) continue;
    for (std::uint32_t body = 0; body < body_places_.size(); ++body) {
      const Scalar* const from = moved_.begin() + std::size_t(body) * kMovedNumbers * width + i;
      put_body(*to[i]->body(body)->m_originalBody, from, width);
    }
  }
}

}  // namespace itarl::lockstep
