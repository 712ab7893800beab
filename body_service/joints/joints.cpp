#include "joints/joints.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <tuple>

#include "contract/errors.hpp"
#include "contract/words.hpp"
#include "geometry/rotation.hpp"

namespace copepod::body {

namespace {

/// Added to the unit diagonal, so that loops with more equations than they need have a factorisation; the refinements
/// of solve() take its effect away.
constexpr double regularisation = 1e-11;

/// Share of a radius, or of a radian, that does not count.
constexpr double negligible_share = 1e-9;

void check_limits(const JointSpecification& joint, const std::string& name) {
  if (!has_axis(joint.kind)) throw CaseError(name + " has limits (only hinges and sliders can). Remove them.");
  if (!(std::isfinite(joint.lowest) && std::isfinite(joint.highest) && joint.lowest <= 0.0 && joint.highest >= 0.0))
    throw CaseError(name + " has limits that leave its start out (it counts as 0). Correct them.");
  if (joint.kind == JointKind::hinge && std::max(-joint.lowest, joint.highest) > 3.0)
    throw CaseError(name + " has limits wider than 3 (angles are those within half a turn). Use -3 to 3 at most.");
}

void check(const JointSpecification& joint, std::size_t index, const BodySetup& setup) {
  const std::string name = "joint " + std::to_string(index);
  const auto bodies = static_cast<int>(setup.bodies.size());
  if (joint.body_A < 0 || joint.body_A >= bodies || joint.body_B < -1 || joint.body_B >= bodies)
    throw CaseError(name + " joins bodies " + std::to_string(joint.body_A) + " and " + std::to_string(joint.body_B) +
                    " (there are " + std::to_string(bodies) + ", counted from 0). Correct the indices.");
  if (joint.body_A == joint.body_B)
    throw CaseError(name + " joins body '" + setup.bodies[joint.body_A].name + "' to itself. Join two bodies.");
  bool one_moves = false;
  for (const int body : {joint.body_A, joint.body_B}) {
    if (body < 0) continue;
    const MotionKind motion = setup.bodies[body].motion;
    if (motion == MotionKind::prescribed)
      throw CaseError(name + " holds body '" + setup.bodies[body].name +
                      "' (motion: prescribed cannot follow a joint). Use motion: free, fixed or axis.");
    one_moves = one_moves || motion != MotionKind::fixed;
  }
  if (!one_moves)
    throw CaseError(name + " holds body '" + setup.bodies[joint.body_A].name +
                    "' (nothing that it joins can move). Remove the joint, or use motion: free.");
  if (!joint.anchor_A_m.allFinite() || !joint.anchor_B_m.allFinite())
    throw CaseError(name + " has an anchor that is not finite. Use finite numbers.");
  if (!(joint.stiffness >= 0.0 && joint.damping >= 0.0 && std::isfinite(joint.rest)))
    throw CaseError(name + " has a spring that is not valid (its numbers must not be negative). Correct them.");
  if (!has_axis(joint.kind) && (joint.stiffness > 0.0 || joint.damping > 0.0))
    throw CaseError(name + " has a spring (only hinges and sliders can). Use a spring between the bodies.");
  if (joint.has_limits()) check_limits(joint, name);
  if (!(std::abs(joint.axis.norm() - 1.0) < 1e-6))
    throw CaseError(name + ": its axis has length " + rounded_text(joint.axis.norm()) +
                    " (a direction is a unit vector). Divide it by its length.");
}

/// The actuator of each joint, −1 for joints that are free.
std::vector<int> drives_of(const BodySetup& setup) {
  std::vector<int> drives(setup.joints.size(), -1);
  for (std::size_t i = 0; i < setup.actuators.size(); ++i) {
    const ActuatorSpecification& actuator = setup.actuators[i];
    if (actuator.kind != ActuatorKind::joint_motion) continue;
    const std::string name = "actuator " + std::to_string(i);
    if (actuator.joint < 0 || actuator.joint >= static_cast<int>(setup.joints.size()))
      throw CaseError(name + " drives joint " + std::to_string(actuator.joint) + " (there are " +
                      std::to_string(setup.joints.size()) + ", counted from 0). Correct the index.");
    const std::string joint = "joint " + std::to_string(actuator.joint);
    if (!has_motion(setup.joints[actuator.joint].kind))
      throw CaseError(name + " drives " + joint + " (it has no single motion). Use hinge, slider or distance.");
    if (setup.joints[actuator.joint].has_limits())
      throw CaseError(name + " drives " + joint + " (it has limits, which it would not obey). Remove one of them.");
    if (drives[actuator.joint] >= 0)
      throw CaseError(name + " drives " + joint + " (another actuator does, too). Remove one.");
    if (setup.integrator != Integrator::runge_kutta_4)
      throw CaseError(name + " drives " + joint + " (this takes the middle of each step). Use runge_kutta_4.");
    drives[actuator.joint] = static_cast<int>(i);
  }
  return drives;
}

/// Lowest body of those that each is connected to by joints through bodies that move.
std::vector<int> lowest_connected(const BodySetup& setup) {
  std::vector<int> island(setup.bodies.size());
  std::iota(island.begin(), island.end(), 0);
  const auto root = [&island](int body) {
    while (island[body] != body) body = island[body] = island[island[body]];  // halves the way of the next
    return body;
  };
  for (const JointSpecification& joint : setup.joints) {
    if (joint.body_B < 0 || setup.bodies[joint.body_A].motion == MotionKind::fixed ||
        setup.bodies[joint.body_B].motion == MotionKind::fixed)
      continue;
    const int one = root(joint.body_A);
    const int other = root(joint.body_B);
    island[std::max(one, other)] = std::min(one, other);
  }
  for (std::size_t body = 0; body < island.size(); ++body) island[body] = root(static_cast<int>(body));
  return island;
}

/// A rod needs a length, the other joints a place in common.
void check_anchors(const JointSpecification& joint, std::size_t index, const std::array<JointSide, 2>& sides,
                   const BodyModel& model) {
  constexpr double tolerance = 1e-6;  // of a radius
  const auto end_m = [&](int i, const Eigen::Vector3d& anchor_m) -> Eigen::Vector3d {
    return sides[i].position_m + sides[i].R_WB * anchor_m;
  };
  const double apart_m = (end_m(0, joint.anchor_A_m) - end_m(1, joint.anchor_B_m)).norm();
  const bool together = apart_m <= tolerance * model.shape(joint.body_A).radius_m;
  const std::string name = "joint " + std::to_string(index);
  if (together && joint.kind == JointKind::distance)
    throw CaseError(name + " is a rod that has no length (its direction is undefined). Move an anchor, or use ball.");
  if (!together && joint.kind != JointKind::distance)
    throw CaseError(name + ": its anchors do not meet (they are " + rounded_text(apart_m) +
                    " m apart). Give both bodies the same place.");
}

double rate(const JointRow& row, const JointSide& A, const JointSide& B) {
  return (row.linear[0].dot(A.velocity_m_per_s) + row.angular[0].dot(A.angular_velocity_rad_per_s)) +
         (row.linear[1].dot(B.velocity_m_per_s) + row.angular[1].dot(B.angular_velocity_rad_per_s));
}

}  // namespace

Joints::Joints(const BodySetup& setup, const BodyModel& model) : model_(model) {
  for (std::size_t i = 0; i < setup.joints.size(); ++i) check(setup.joints[i], i, setup);
  const std::vector<int> drives = drives_of(setup);
  const std::vector<int> island_of_body = lowest_connected(setup);
  std::vector<int> place(setup.bodies.size(), -1);
  for (std::size_t i = 0; i < setup.joints.size(); ++i) {
    const JointSpecification& joint = setup.joints[i];
    const int moving = moves(joint.body_A) ? joint.body_A : joint.body_B;
    int& at = place[island_of_body[moving]];
    if (at < 0) {
      at = static_cast<int>(islands_.size());
      islands_.push_back({moving, {}, {}, 0});
    }
    Island& island = islands_[at];
    for (const int body : {joint.body_A, joint.body_B})
      if (moves(body) && std::ranges::find(island.bodies, body) == island.bodies.end()) island.bodies.push_back(body);
    const MotionState& start = model.initial_state();
    const std::array<JointSide, 2> sides{side(joint.body_A, 0, start), side(joint.body_B, 0, start)};
    check_anchors(joint, i, sides, model);
    const JointEquations equations(joint, drives[i] >= 0, sides[0], sides[1]);
    island.joints.push_back({{joint.body_A, joint.body_B}, joint, static_cast<int>(island.rows), drives[i], equations});
    island.rows += island.joints.back().rows();
  }
  std::ranges::sort(islands_, {}, &Island::block_key);
  island_of_.assign(setup.bodies.size(), -1);
  for (std::size_t i = 0; i < islands_.size(); ++i)
    for (const int body : islands_[i].bodies) island_of_[body] = static_cast<int>(i);
}

std::span<const Joints::Island> Joints::islands_of(const BodyBlock& block) const {
  const auto first = std::ranges::lower_bound(islands_, block.first, {}, &Island::block_key);
  return {first, std::ranges::lower_bound(first, islands_.end(), block.first + block.bodies, {}, &Island::block_key)};
}

void Joints::drive(const Eigen::MatrixXd& actuation, double step_s) {
  if (islands_.empty()) return;
  step_s_ = step_s;
  if (actuation.cols() == 3) nodes_ = actuation;
}

/// The parabola through s₀, s₁, s₂ at 0, 1/2 and 1 of a step h, at x of it:
///   s = s₀ + (4 s₁ − 3 s₀ − s₂) x + 2 (s₀ − 2 s₁ + s₂) x²
JointMotion Joints::motion(const Joint& joint, double at) const {
  if (joint.actuator < 0 || nodes_.rows() == 0) return {};
  const Eigen::RowVector3d s = nodes_.row(joint.actuator);
  const double slope = 4.0 * (s[1] - s[0]) - (s[2] - s[0]);
  const double bend = 2.0 * ((s[2] - s[1]) - (s[1] - s[0]));
  const double value = at == 1.0 ? s[2] : s[0] + at * (slope + at * bend);
  return {value, (slope + 2.0 * bend * at) / step_s_, 2.0 * bend / (step_s_ * step_s_)};
}

template <class State>
JointSide Joints::side(int body, Eigen::Index first, const State& state) const {
  if (body < 0) return {};
  const Eigen::Index column = body - first;
  const Eigen::Vector4d q_WB = Eigen::Vector4d(state.orientation_wxyz.col(column)).normalized();
  return {state.position_m.col(column), rotation_matrix(q_WB), state.velocity_m_per_s.col(column),
          model_.angular_velocity_rad_per_s(body, q_WB, state.angular_momentum_N_m_s.col(column))};
}

std::pair<Eigen::Vector3d, Eigen::Vector3d> Joints::answer(int body, const JointSide& side, Eigen::Vector3d force_N,
                                                           Eigen::Vector3d torque_N_m) const {
  if (!moves(body)) return {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  model_.constrain_loads(body, force_N, torque_N_m);
  return {model_.inverse_mass_per_kg(body) * force_N, model_.per_inertia(body, side.R_WB, torque_N_m)};
}

template <class State>
void Joints::list_rows(const Island& island, Eigen::Index first, double at, const State& state, Work& work) const {
  work.sides.resize(island.joints.size());
  work.rows.resize(island.rows);
  work.response.resize(work.rows.size());
  for (std::size_t i = 0; i < island.joints.size(); ++i) {
    const Joint& joint = island.joints[i];
    work.sides[i] = {side(joint.bodies[0], first, state), side(joint.bodies[1], first, state)};
    joint.equations.evaluate(work.sides[i][0], work.sides[i][1], motion(joint, at), &work.rows[joint.first_row]);
    if (joint.specification.has_limits())
      work.rows[joint.first_row + joint.equations.rows()] = stop_row(joint, work.stops[i], work.sides[i]);
    for (int row = joint.first_row; row < joint.first_row + joint.rows(); ++row) {
      for (const int end : {0, 1}) {
        const JointRow& of_row = work.rows[row];
        JointRow& response = work.response[row];
        std::tie(response.linear[end], response.angular[end]) =
            answer(joint.bodies[end], work.sides[i][end], of_row.linear[end], of_row.angular[end]);
      }
    }
  }
}

template <class State>
Joints::Reach Joints::reach(const Joint& joint, Eigen::Index first, const State& state) const {
  const JointSpecification& limits = joint.specification;
  if (!limits.has_limits()) return {};
  const JointSide A = side(joint.bodies[0], first, state), B = side(joint.bodies[1], first, state);
  const JointRow motion = joint.equations.motion(A, B);
  const double unit = limits.kind == JointKind::hinge ? 1.0 : model_.shape(joint.bodies[0]).radius_m;
  const bool highest = limits.highest - motion.error < motion.error - limits.lowest;
  return {highest ? 1 : -1, highest ? motion.error - limits.highest : limits.lowest - motion.error,
          (highest ? 1.0 : -1.0) * rate(motion, A, B), negligible_share * unit};
}

/// The stop that a joint rests against; 0: none.
template <class State>
int Joints::stop_at_rest(const Joint& joint, Eigen::Index first, const State& state) const {
  const Reach it = reach(joint, first, state);
  return it.beyond >= -it.negligible && std::abs(it.rate) * step_s_ <= it.negligible ? it.stop : 0;
}

/// Of a joint at a stop C = s − limit; otherwise a row that does nothing, so that rows keep their places.
JointRow Joints::stop_row(const Joint& joint, int stop, const std::array<JointSide, 2>& sides) const {
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  if (stop == 0) return {{none, none}, {none, none}};
  JointRow row = joint.equations.motion(sides[0], sides[1]);
  row.error -= stop < 0 ? joint.specification.lowest : joint.specification.highest;
  return row;
}

/// Q = −k (s − s₀) − c ds/dt along the row of s.                                                  (B33)
void Joints::add_springs(const Island& island, Eigen::Index first, const Work& work, BlockVectors& force_N,
                         BlockVectors& torque_N_m) const {
  for (std::size_t i = 0; i < island.joints.size(); ++i) {
    const Joint& joint = island.joints[i];
    const JointSpecification& spring = joint.specification;
    if (spring.stiffness == 0.0 && spring.damping == 0.0) continue;
    const auto& [A, B] = work.sides[i];
    const JointRow motion = joint.equations.motion(A, B);
    const double load = -spring.stiffness * (motion.error - spring.rest) - spring.damping * rate(motion, A, B);
    for_each_moving(joint, [&](int end, int body) {
      force_N.col(body - first) += load * motion.linear[end];
      torque_N_m.col(body - first) += load * motion.angular[end];
    });
  }
}

void Joints::factorise(const Island& island, Work& work) const {
  work.matrix.setZero(island.rows, island.rows);
  work.right_side.resize(island.rows);
  for (const Joint& one : island.joints) {
    for (const Joint& other : island.joints) {
      if (other.first_row > one.first_row) break;
      for (const int i : {0, 1}) {
        for (const int j : {0, 1}) {
          if (one.bodies[i] != other.bodies[j] || !moves(one.bodies[i])) continue;
          for (int row = one.first_row; row < one.first_row + one.rows(); ++row) {
            for (int column = other.first_row; column < other.first_row + other.rows(); ++column)
              work.matrix(row, column) += work.rows[row].linear[i].dot(work.response[column].linear[j]) +
                                          work.rows[row].angular[i].dot(work.response[column].angular[j]);
          }
        }
      }
    }
  }
  work.scale = work.matrix.diagonal().unaryExpr([](double it) { return it > 0.0 ? 1.0 / std::sqrt(it) : 0.0; });
  work.matrix = work.scale.asDiagonal() * work.matrix * work.scale.asDiagonal();
  work.matrix.triangularView<Eigen::StrictlyUpper>() = work.matrix.transpose();
  work.matrix.diagonal().array() += regularisation;
  work.factors.compute(work.matrix);
  work.matrix.diagonal().array() -= regularisation;
}

void Joints::solve(Work& work) {
  work.right_side.array() *= work.scale.array();
  work.multipliers = work.factors.solve(work.right_side);
  for (int refinement = 0; refinement < 2; ++refinement)
    work.multipliers += work.factors.solve(work.right_side - work.matrix * work.multipliers);
  work.multipliers.array() *= work.scale.array();
}

void Joints::add_loads(const BodyBlock& block, const BlockState& state, double at, BlockVectors& force_N,
                       BlockVectors& torque_N_m, Work& work) const {
  const bool first_stage = at == 0.0;  // stops that hold then hold through the step
  if (first_stage) work.held.clear();
  auto held = work.held.cbegin();
  for (const Island& island : islands_of(block)) {
    work.stops.assign(island.joints.size(), 0);
    for (std::size_t i = 0; i < island.joints.size(); ++i)
      work.stops[i] = first_stage ? stop_at_rest(island.joints[i], block.first, state) : *held++;
    list_rows(island, block.first, at, state, work);
    add_springs(island, block.first, work, force_N, torque_N_m);
    for (;;) {
      factorise(island, work);
      for (std::size_t i = 0; i < island.joints.size(); ++i) {
        const Joint& joint = island.joints[i];
        std::array<JointSide, 2> acceleration;  // as if the joints exerted nothing
        for_each_moving(joint, [&](int end, int body) {
          const Eigen::Index column = body - block.first;
          const Eigen::Vector3d w = work.sides[i][end].angular_velocity_rad_per_s;
          const Eigen::Vector3d L = state.angular_momentum_N_m_s.col(column);
          std::tie(acceleration[end].velocity_m_per_s, acceleration[end].angular_velocity_rad_per_s) =
              answer(body, work.sides[i][end], force_N.col(column), torque_N_m.col(column) - w.cross(L));
        });
        for (int row = joint.first_row; row < joint.first_row + joint.rows(); ++row)
          work.right_side[row] = -work.rows[row].curvature - rate(work.rows[row], acceleration[0], acceleration[1]);
      }
      solve(work);
      if (!first_stage || !release(island, 0.0, work)) break;
      list_rows(island, block.first, at, state, work);
    }
    if (first_stage) work.held.insert(work.held.end(), work.stops.begin(), work.stops.end());
    for (const Joint& joint : island.joints) {
      for (int row = joint.first_row; row < joint.first_row + joint.rows(); ++row) {
        for_each_moving(joint, [&](int end, int body) {
          force_N.col(body - block.first) += work.multipliers[row] * work.rows[row].linear[end];
          torque_N_m.col(body - block.first) += work.multipliers[row] * work.rows[row].angular[end];
        });
      }
    }
  }
}

void Joints::correct(const BodyBlock& block, double at, MotionState& state, std::int64_t step, Work& work) const {
  auto held = work.held.cbegin();
  for (const Island& island : islands_of(block)) {
    work.stops.assign(island.joints.size(), 0);
    if (!work.held.empty()) held = std::ranges::copy_n(held, std::ssize(work.stops), work.stops.begin()).in;
    meet_stops(island, at, state, work);
    correct(island, at, state, step, work);
  }
  work.held.clear();
}

/// Joints that have passed a limit go back to when the first of them did, along straight lines, lose what they have of
/// outward velocity, and continue from there: momentum and angular momentum are kept, as with every impulse.
void Joints::meet_stops(const Island& island, double at, MotionState& state, Work& work) const {
  double ago_s = 0.0;
  for (std::size_t i = 0; i < island.joints.size(); ++i) {
    const Reach it = reach(island.joints[i], 0, state);
    if (work.stops[i] != 0 || it.beyond < -it.negligible || !(it.rate > 0.0)) continue;
    work.stops[i] = it.stop;
    ago_s = std::max(ago_s, std::min(it.beyond / it.rate, step_s_));
  }
  if (ago_s == 0.0) return;
  at -= ago_s / step_s_;
  drift(island, -ago_s, state);
  list_rows(island, 0, at, state, work);
  factorise(island, work);
  correct_velocities(island, at, work, state);
  drift(island, ago_s, state);
}

void Joints::drift(const Island& island, double duration_s, MotionState& state) const {
  for (const int body : island.bodies) {
    const Eigen::Vector3d w_rad_per_s = model_.angular_velocity_rad_per_s(body, state);
    state.position_m.col(body) += duration_s * state.velocity_m_per_s.col(body);
    state.orientation_wxyz.col(body) = rotated(duration_s * w_rad_per_s, state.orientation_wxyz.col(body)).normalized();
  }
}

/// Lets the stop go that pulls most, by what it changes of the rate or of the acceleration of the joint's motion.
/// @param least  change that counts, in shares of a motion that do not
/// @return whether there is one
bool Joints::release(const Island& island, double least, Work& work) const {
  std::size_t most = island.joints.size();
  for (std::size_t i = 0; i < island.joints.size(); ++i) {
    const Joint& joint = island.joints[i];
    const int row = joint.first_row + joint.equations.rows();
    if (work.stops[i] == 0 || work.scale[row] == 0.0) continue;
    const double unit = joint.specification.kind == JointKind::hinge ? 1.0 : model_.shape(joint.bodies[0]).radius_m;
    const double change = work.stops[i] * work.multipliers[row] / (work.scale[row] * work.scale[row]);
    if (!(change > least * negligible_share * unit)) continue;
    least = change / (negligible_share * unit);
    most = i;
  }
  if (most == island.joints.size()) return false;
  work.stops[most] = 0;
  return true;
}

void Joints::correct(const Island& island, double at, MotionState& state, std::int64_t step, Work& work) const {
  double last = 0.0;
  for (int correction = 0;; ++correction) {
    list_rows(island, 0, at, state, work);
    factorise(island, work);
    for (Eigen::Index row = 0; row < island.rows; ++row) work.right_side[row] = -work.rows[row].error;
    // In units of the response: lengths and cosines are compared by what it takes to remove them.
    const double left = (work.right_side.array() * work.scale.array()).matrix().norm();
    // Newton's method squares the error until rounding ends that; it may begin slowly.
    if (left == 0.0 || (correction > 0 && !(left < (open_joint(island, work) == nullptr ? 0.1 : 0.9) * last))) break;
    last = left;
    solve(work);
    correct_positions(island, work, state);
  }
  if (const Joint* joint = open_joint(island, work))
    throw SolverError("the joint of body '" + model_.name(joint->bodies[0]) +
                          "' comes apart (the step is too long for its motion). Use a shorter step.",
                      0, step);
  correct_velocities(island, at, work, state);
}

double Joints::inverse_mass_taken_per_kg(const std::array<int, 2>& bodies, const JointRow& contact, double at,
                                         const MotionState& state, Work& work) const {
  double taken = 0.0;
  std::array<int, 2> islands{-1, -1};
  for (const int end : {0, 1}) islands[end] = bodies[end] < 0 ? -1 : island_of_[bodies[end]];
  for (const int number : islands) {
    if (number < 0 || (&number == &islands[1] && number == islands[0])) continue;
    const Island& island = islands_[number];
    work.stops.assign(island.joints.size(), 0);
    for (std::size_t i = 0; i < island.joints.size(); ++i) work.stops[i] = stop_at_rest(island.joints[i], 0, state);
    Eigen::VectorXd changes(island.rows);  // of the rows' rates by a unit impulse at the contact
    do {
      list_rows(island, 0, at, state, work);
      factorise(island, work);
      for (std::size_t i = 0; i < island.joints.size(); ++i) {
        const Joint& joint = island.joints[i];
        std::array<JointSide, 2> pushed;
        for (const int end : {0, 1}) {
          for (const int of : {0, 1}) {
            if (bodies[of] < 0 || bodies[of] != joint.bodies[end]) continue;
            const auto [v, w] = answer(bodies[of], work.sides[i][end], contact.linear[of], contact.angular[of]);
            pushed[end].velocity_m_per_s += v;
            pushed[end].angular_velocity_rad_per_s += w;
          }
        }
        for (int row = joint.first_row; row < joint.first_row + joint.rows(); ++row)
          changes[row] = rate(work.rows[row], pushed[0], pushed[1]);
      }
      work.right_side = -changes;
      solve(work);
    } while (release(island, 0.0, work));
    taken -= changes.dot(work.multipliers);
  }
  return taken;
}

const Joints::Joint* Joints::open_joint(const Island& island, const Work& work) const {
  for (const Joint& joint : island.joints) {
    for (int row = joint.first_row; row < joint.first_row + joint.rows(); ++row) {
      const double unit = work.rows[row].linear[0].isZero(0.0) ? 1.0 : model_.shape(joint.bodies[0]).radius_m;
      if (!(std::abs(work.rows[row].error) <= negligible_share * unit)) return &joint;
    }
  }
  return nullptr;
}

void Joints::correct_positions(const Island& island, const Work& work, MotionState& state) const {
  std::vector<std::pair<int, Eigen::Vector3d>> turns;
  for (const Joint& joint : island.joints) {
    for_each_moving(joint, [&](int end, int body) {
      Eigen::Vector3d turn = Eigen::Vector3d::Zero();
      for (int row = joint.first_row; row < joint.first_row + joint.rows(); ++row) {
        state.position_m.col(body) += work.multipliers[row] * work.response[row].linear[end];
        turn += work.multipliers[row] * work.response[row].angular[end];
      }
      turns.emplace_back(body, turn);
    });
  }
  for (const auto& [body, turn] : turns)
    state.orientation_wxyz.col(body) = rotated(turn, state.orientation_wxyz.col(body)).normalized();
}

void Joints::correct_velocities(const Island& island, double at, Work& work, MotionState& state) const {
  for (;;) {
    for (std::size_t i = 0; i < island.joints.size(); ++i) {
      const Joint& joint = island.joints[i];
      for (int row = joint.first_row; row < joint.first_row + joint.rows(); ++row)
        work.right_side[row] = -work.rows[row].drift - rate(work.rows[row], work.sides[i][0], work.sides[i][1]);
    }
    solve(work);
    if (!release(island, 1.0 / step_s_, work)) break;
    list_rows(island, 0, at, state, work);
    factorise(island, work);
  }
  for (const Joint& joint : island.joints) {
    for_each_moving(joint, [&](int end, int body) {
      Eigen::Vector3d torque = Eigen::Vector3d::Zero();
      for (int row = joint.first_row; row < joint.first_row + joint.rows(); ++row) {
        state.velocity_m_per_s.col(body) += work.multipliers[row] * work.response[row].linear[end];
        torque += work.multipliers[row] * work.rows[row].angular[end];
      }
      Eigen::Vector3d none = Eigen::Vector3d::Zero();
      model_.constrain_loads(body, none, torque);
      state.angular_momentum_N_m_s.col(body) += torque;
    });
  }
}

}  // namespace copepod::body
