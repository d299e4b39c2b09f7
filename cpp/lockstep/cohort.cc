#include "lockstep/cohort.h"

#include <algorithm>
#include <utility>

#include "lockstep/moving.h"
#include "lockstep/residual.h"
#include "state.h"

namespace itarl::lockstep {

namespace {

// Whether nothing acts on a world's bodies but joints, gravity and contacts, and the solver does with
// contacts what lanes do.
bool is_plain(State& state) {
  const btContactSolverInfo& info = state.world.getSolverInfo();
  const int different =
      SOLVER_RANDMIZE_ORDER | SOLVER_USE_2_FRICTION_DIRECTIONS |
      SOLVER_ENABLE_FRICTION_DIRECTION_CACHING | SOLVER_DISABLE_VELOCITY_DEPENDENT_FRICTION_DIRECTION;
  if ((info.m_solverMode & different) != 0 || (info.m_solverMode & SOLVER_USE_WARMSTARTING) == 0) {
    return false;
  }
  if (state.broken || state.solver.is_observed() || state.solver.separate_groups() != 0) return false;
  return std::all_of(state.bodies.begin(), state.bodies.end(), [](const auto& entry) {
    if (!entry || entry->motion == Motion::Static) return true;
    const btRigidBody& body = *entry->body;
    return entry->motion == Motion::Dynamic && body.getLinearDamping() == 0 &&
           body.getAngularDamping() == 0 && body.getDeactivationTime() == 0 &&
           body.getActivationState() == DISABLE_DEACTIVATION;
  });
}

}  // namespace

std::shared_ptr<Cohort> Cohort::of(const std::vector<WorldRows*>& lanes,
                                   const std::vector<std::uint32_t>& dynamic_ids,
                                   const SweepChoice& choice) {
  std::shared_ptr<Cohort> cohort(new Cohort(choice));
  if (!cohort->take(lanes, dynamic_ids)) return nullptr;
  return cohort;
}

bool Cohort::take(const std::vector<WorldRows*>& lanes,
                  const std::vector<std::uint32_t>& dynamic_ids) {
  const Signature& signature = lanes.front()->signature();
  for (const JointKey& joint : signature.joints) {
    if (joint.type.kind() == JointType::FromPools) return false;
  }
  for (const WorldRows* const lane : lanes) {
    if (!(lane->signature() == signature) || !lane->is_moved() || !is_plain(lane->state())) {
      return false;
    }
    states_.push_back(&lane->state());
  }
  if (!signature.contacts.empty() || !take_pairs(dynamic_ids)) return false;
  ahead_.assign(states_.size(), 0);
  take_bodies(dynamic_ids);
  make_layout(*lanes.front(), lanes);
  joints_.enter(states_, width_);
  joints_.gather_worlds();
  find_places();
  read_angles();
  return true;
}

bool Cohort::take_pairs(const std::vector<std::uint32_t>& dynamic_ids) {
  for (State* const state : states_) {
    std::vector<PlanePair> pairs;
    if (!list_pairs(*state, dynamic_ids, pairs)) return false;
    const auto alike = [](const PlanePair& a, const PlanePair& b) { return a.is_like(b); };
    if (!pairs_.empty() && !std::equal(pairs.begin(), pairs.end(), pairs_[0].begin(),
                                       pairs_[0].end(), alike)) {
      return false;
    }
    pairs_.push_back(std::move(pairs));
  }
  const auto width = std::size_t(width_);
  const std::size_t count = pairs_[0].size();
  most_points_.assign(count, 0);
  pair_numbers_.make_room(count * kPairNumbers * width);
  points_.make_room(count * kManifoldNumbers * width);
  next_points_.make_room(count * kManifoldNumbers * width);
  for (std::size_t pair = 0; pair < count; ++pair) {
    for (std::size_t i = 0; i < width; ++i) {
      // Empty lanes do what the last one does: no number is a surprise there.
      const PlanePair& from = pairs_[std::min(i, pairs_.size() - 1)][pair];
      put_pair(from, pairs_of(pair_numbers_, pair, kPairNumbers) + i, width);
      take_points(from, pairs_of(points_, pair, kManifoldNumbers) + i, width);
      take_points(from, pairs_of(next_points_, pair, kManifoldNumbers) + i, width);
    }
  }
  return true;
}

void Cohort::take_bodies(const std::vector<std::uint32_t>& dynamic_ids) {
  const auto width = std::size_t(width_);
  for (std::uint32_t slot = 0; slot < dynamic_ids.size(); ++slot) {
    if (dynamic_ids[slot] != kNoBody) body_slots_.push_back(slot);
  }
  contacts_.assign(body_slots_.size(), 0);
  const std::size_t size = body_slots_.size() * kBodyNumbers * width;
  for (Vectors* const numbers : {&bodies_, &next_bodies_}) {
    numbers->make_room(size);
    for (std::size_t body = 0; body < body_slots_.size(); ++body) {
      for (std::size_t i = 0; i < width; ++i) {
        const State& state = *states_[std::min(i, states_.size() - 1)];
        take_body(*state.bodies[body_slots_[body]]->body, state.time_step,
                  numbers->begin() + body * kBodyNumbers * width + i, width);
      }
    }
  }
}

void Cohort::make_layout(const WorldRows& first, const std::vector<WorldRows*>& lanes) {
  const int mode = first.solver().info().m_solverMode;
  layout_ = std::make_unique<RowLayout>(
      first.signature(), std::uint32_t(body_slots_.size()), 1,
      (mode & SOLVER_INTERLEAVE_CONTACT_AND_FRICTION_CONSTRAINTS) != 0, width_);
  for (std::uint32_t joint = 0; joint < first.signature().joints.size(); ++joint) {
    layout_->need_rows(joint, first.rows(joint));
    for (std::uint32_t part = 0; part < first.rows(joint); ++part) {
      Form form;
      for (const WorldRows* const lane : lanes) form = form & lane->form(joint, part);
      layout_->set_form(joint, part, form);
    }
  }
}

// What depends on where rows lie.
void Cohort::find_places() {
  layout_->settle();
  const std::size_t size = std::size_t(layout_->size()) * std::size_t(width_);
  values_.make_room(size);
  std::fill_n(values_.begin(), size, Scalar(0));
  body_places_.clear();
  for (std::uint32_t i = 0; i < layout_->body_count(); ++i) {
    body_places_.push_back(layout_->body_place(i));
  }
  plans_.clear();
  for (const PlanePair& pair : pairs_[0]) {
    const std::uint32_t first = layout_->contact_index(pair.body, 0);
    plans_.push_back({pair.shape, pair.up, pair.in_compound, pair.body * kBodyNumbers,
                      layout_->body_place(pair.body), layout_->contact_row(first),
                      layout_->friction_row(first), layout_->contacts_apart()});
  }
  joints_.plan(*layout_);
  angle_places_.assign(states_[0]->joints.size(), {});
  for (std::size_t k = 0; k < joints_.joints().size(); ++k) {
    const std::uint32_t joint = joints_.joints()[k];
    angle_places_[joint] = {3 * k, states_[0]->joints[joint]->kind == JointKind::Slider};
  }
  angles_.make_room(3 * joints_.joints().size() * std::size_t(width_));
}

void Cohort::admit() {
  for (std::size_t i = 0; i < states_.size(); ++i) {
    states_[i]->leave_lanes();
    states_[i]->cohort = shared_from_this();
    states_[i]->lane = i;
  }
}

bool Cohort::is_of(State* const* states, std::size_t count) const {
  if (count != states_.size()) return false;
  for (std::size_t i = 0; i < count; ++i) {
    const State& state = *states[i];
    if (&state != states_[i] || state.cohort.get() != this || state.lane != i || state.broken) {
      return false;
    }
  }
  return true;
}

void Cohort::begin() {
  largest_k_.fill(0);
  joints_.gather_motors();
  choice_.twist(std::uint32_t(body_slots_.size()), joints_.worlds(), bodies_.begin());
  contact_task_ = {plans_.data(),
                   plans_.data() + plans_.size(),
                   joints_.worlds(),
                   bodies_.begin(),
                   pair_numbers_.begin(),
                   points_.begin(),
                   next_points_.begin(),
                   most_points_.data(),
                   nullptr,
                   nullptr,
                   0,
                   largest_k_.data()};
  choice_.find_contacts(contact_task_);
  make_room_for_contacts();
  reset_bodies();
  joint_task_ = &joints_.task(*layout_, values_.begin(), largest_k_.data());
  joint_task_->bodies = bodies_.begin();
  joint_task_->angles = angles_.begin();
  choice_.make_rows(*joint_task_);
  contact_task_.begin = plans_.data();
  contact_task_.end = plans_.data() + plans_.size();
  contact_task_.rows = layout_->rows().data();
  contact_task_.values = values_.begin();
  choice_.make_contact_rows(contact_task_);
  set_residual_floors(largest_k_, width_, floors_);
  sweep_ = {rows_.data(), rows_.data() + rows_.size(), values_.begin(),
            states_[0]->world.getSolverInfo().m_numIterations, floors_.data(), 0, &alone_};
}

// For as many rows of contacts as the worlds have now.
void Cohort::make_room_for_contacts() {
  bool changed = rows_.empty();
  for (std::size_t pair = 0; pair < most_points_.size(); ++pair) {
    const std::uint32_t body = pairs_[0][pair].body;
    changed = changed || contacts_[body] != most_points_[pair];
    contacts_[body] = most_points_[pair];
    layout_->need_contacts(body, most_points_[pair]);
  }
  if (!changed) return;
  if (!layout_->is_settled()) find_places();
  layout_->rows_in_order(contacts_, rows_);
}

// Velocities' changes are 0 before the first row.
void Cohort::reset_bodies() {
  const auto width = std::size_t(width_);
  for (std::uint32_t body = 0; body <= layout_->body_count(); ++body) {
    const bool moves = body < layout_->body_count();
    Scalar* const to = values_.begin() + layout_->body_place(moves ? body : kNoBody) * width;
    std::fill_n(to, kInverseMass * width, Scalar(0));
    const Scalar* const mass = bodies_.begin() + (body * kBodyNumbers + kBodyInverseMass) * width;
    for (std::size_t i = 0; i < width; ++i) to[kInverseMass * width + i] = moves ? mass[i] : 0;
  }
}

std::uint32_t Cohort::end() {
  choice_.report(*joint_task_);
  const std::uint32_t all = (std::uint32_t{1} << states_.size()) - 1;
  const std::uint32_t left = all & (joint_task_->unsound | contact_task_.unsound | not_finite() |
                                    sweep_.maybe_converged);
  for (std::size_t i = 0; i < states_.size(); ++i) {
    if ((left >> i & 1) != 0) states_[i]->leave_lanes();
  }
  choice_.report_contacts(contact_task_);
  const MoveTask moves{std::uint32_t(body_slots_.size()), body_places_.data(), joints_.worlds(),
                       bodies_.begin(), values_.begin(), int(states_.size()),
                       next_bodies_.begin(), kBodyNumbers};
  choice_.move(moves);
  left_range_ = (choice_.leave_range(moves) | joints_.not_finite()) & all & ~left;
  std::swap(bodies_, next_bodies_);
  std::swap(points_, next_points_);
  read_angles();
  std::fill(ahead_.begin(), ahead_.end(), std::uint8_t(1));
  return left;
}

void Cohort::read_angles() {
  JointTask& task = joints_.task(*layout_, values_.begin(), largest_k_.data());
  task.bodies = bodies_.begin();
  choice_.read_angles(task, angles_.begin());
}

std::array<double, 3> Cohort::angles(std::size_t lane, std::uint32_t joint) const {
  const auto width = std::size_t(width_);
  const AnglePlace& at = angle_places_[joint];
  const Scalar* const of = angles_.begin() + at.place * width + lane;
  if (at.slider) return {double(of[0]), 0, 0};
  // Bullet's have the other sign.
  return {double(0 - of[0]), double(0 - of[width]), double(0 - of[2 * width])};
}

// Lanes with a number that isn't finite, or so large that Bullet would switch a joint off, as bits.
std::uint32_t Cohort::not_finite() {
  return joint_task_->extreme |
         lanes_not_finite(*layout_, values_.begin(), width_, states_.size());
}

void Cohort::settle(std::size_t lane, State& to) {
  if (ahead_[lane] == 0) return;
  ahead_[lane] = 0;
  const auto width = std::size_t(width_);
  for (std::size_t body = 0; body < body_slots_.size(); ++body) {
    put_body(*to.bodies[body_slots_[body]]->body,
             bodies_.begin() + body * kBodyNumbers * width + lane, width);
  }
  for (std::size_t pair = 0; pair < pairs_[lane].size(); ++pair) {
    put_points(pairs_[lane][pair], pairs_of(points_, pair, kManifoldNumbers) + lane, width);
  }
  joints_.report(std::uint32_t(lane), to);
}

}  // namespace itarl::lockstep
