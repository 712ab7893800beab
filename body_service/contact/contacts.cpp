#include "contact/contacts.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <numeric>
#include <tuple>
#include <utility>

#include <Eigen/Geometry>

#include "contract/errors.hpp"
#include "contract/words.hpp"
#include "geometry/segment_distance.hpp"

namespace copepod::body {

namespace {

constexpr std::size_t words_per_contact = 5;

/// Calls work(first, last) for ranges that cover [0, count).
template <class Work>
void share_ranges(ThreadTeam& team, std::size_t count, const Work& work) {
  constexpr std::size_t part = 16384;
  team.share(static_cast<std::int64_t>((count + part - 1) / part), [&](std::int64_t index, int) {
    const std::size_t first = part * static_cast<std::size_t>(index);
    work(first, std::min(first + part, count));
  });
}

void check_contact(const BodySetup& setup) {
  const ContactSpecification& contact = setup.contact;
  if (!(contact.restitution > 0.0 && contact.restitution <= 1.0))
    throw CaseError("contact.restitution " + rounded_text(contact.restitution) +
                    " (a rebound has a part of the velocity before it). Use a number between 0.05 and 1.");
  if (!(contact.friction >= 0.0))
    throw CaseError("contact.friction " + rounded_text(contact.friction) +
                    " (friction must not create energy). Use 0 or more.");
  for (const BodySpecification& body : setup.bodies) {
    if (is_round(body.shape)) continue;
    throw CaseError("body '" + body.name + "' has shape " + word_of(body.shape) +
                    " (contacts of our own are those of spheres and capsules). Use body: {solver: bullet}.");
  }
  for (const WallSpecification& wall : setup.walls) {
    if (std::abs(wall.normal.norm() - 1.0) < 1e-6 && wall.friction >= 0.0) continue;
    throw CaseError("a wall has a normal of length " + rounded_text(wall.normal.norm()) + " or a friction of " +
                    rounded_text(wall.friction) + " (it needs a unit vector, and 0 or more). Correct them.");
  }
}

/// The number of an image, with ten bits of each component: no two images of one body meet another one at a time that
/// differ beyond these.
std::uint32_t image_word(const Eigen::Vector3d& number) {
  std::uint32_t word = 0;
  for (const double component : number)
    word = word << 10U | (static_cast<std::uint32_t>(static_cast<std::int64_t>(component)) & 1023U);
  return word;
}

/// Place of each body among the names; bodies of one name keep their order.
std::vector<int> bodies_by_name(const BodyModel& model) {
  std::vector<int> bodies(model.bodies());
  std::iota(bodies.begin(), bodies.end(), 0);
  std::ranges::stable_sort(bodies, {}, [&](int body) -> const std::string& { return model.name(body); });
  return bodies;
}

SolverError too_soft(const std::string& found, double overlap_m) {
  return SolverError(found + " by " + length_text(overlap_m) +
                     " (the contact is too soft for its load, or the step too long). Use a larger "
                     "contact.stiffness_N_per_m or a shorter step.");
}

}  // namespace

double Contacts::reach_m(const BodySetup& setup) {
  constexpr double share_of_radius = 0.1;
  double smallest_m = 0.0;
  for (const BodySpecification& body : setup.bodies)
    smallest_m = smallest_m == 0.0 ? body.shape.radius_m : std::min(smallest_m, body.shape.radius_m);
  return share_of_radius * smallest_m;
}

Contacts::Contacts(const BodySetup& setup, const BodyModel& model, const Joints& joints, NearPairs& near_pairs)
    : model_(model),
      joints_(joints),
      near_pairs_(near_pairs),
      friction_(setup.contact.friction),
      reach_m_(reach_m(setup)),
      rank_(setup.bodies.size()),
      by_rank_(bodies_by_name(model)) {
  check_contact(setup);
  std::ranges::copy_if(setup.walls, std::back_inserter(walls_), [](const auto& wall) { return !wall.removes_bodies; });
  if (!near_pairs.longer_than_the_box().empty())
    throw CaseError(
        "body '" + model.name(near_pairs.longer_than_the_box().front()) +
        "' is longer than the periodic domain (it would be in contact with its own image). Use a larger domain.");
  law_ = {setup.contact.stiffness_N_per_m, damping_ratio_of(setup.contact.restitution)};
  for (std::size_t rank = 0; rank < by_rank_.size(); ++rank) rank_[by_rank_[rank]] = static_cast<int>(rank);
  force_N_.resize(3, model.bodies());
  torque_N_m_.resize(3, model.bodies());
}

void Contacts::push(MotionState& state, const Interval& interval) {
  prepare(state, interval);
  for (const auto& [A, B] : pairs_) push_pair(A, B, state, interval);
  for (int body = 0; body < static_cast<int>(rank_.size()) && !walls_.empty(); ++body) {
    if (!model_.moves(body)) continue;
    for (std::size_t wall = 0; wall < walls_.size(); ++wall) push_from_wall(body, wall, state, interval);
  }
  if (!memory_.empty()) apply(state, interval.duration_s);
}

void Contacts::prepare(const MotionState& state, const Interval& interval) {
  std::swap(memory_, before_);
  memory_.clear();
  touches_.clear();
  next_before_ = 0;
  double fastest_m_per_s = 0.0;
  for (const WallSpecification& wall : walls_)
    fastest_m_per_s = std::max(fastest_m_per_s, wall.velocity_m_per_s.norm());
  for (Eigen::Index body = 0; body < model_.bodies(); ++body) {
    double speed_m_per_s = state.velocity_m_per_s.col(body).norm();
    const double half_length_m = core_half_length_m(model_.shape(body));
    if (half_length_m > 0.0) speed_m_per_s += half_length_m * model_.angular_velocity_rad_per_s(body, state).norm();
    fastest_m_per_s = std::max(fastest_m_per_s, speed_m_per_s);
  }
  // Two bodies approach each other at most twice as fast, over the half of the interval or to its other end.
  near_m_ = std::min(reach_m_, 2.0 * fastest_m_per_s * interval.duration_s);
  force_N_.setZero();
  torque_N_m_.setZero();
  list_pairs(state.position_m);
}

void Contacts::list_pairs(const Eigen::Matrix3Xd& position_m) {
  const std::vector<BodyPair>& near = near_pairs_.at(position_m);
  if (listing_ == near_pairs_.listing()) return;
  listing_ = near_pairs_.listing();
  const auto rank = [this](int body) { return rank_[body]; };
  pairs_.clear();
  for (auto [A, B] : near) {
    if (!model_.moves(A) && !model_.moves(B)) continue;
    if (rank(B) < rank(A)) std::swap(A, B);
    pairs_.emplace_back(A, B);
  }
  std::ranges::sort(pairs_, {}, [&](const BodyPair& pair) { return std::pair(rank(pair.first), rank(pair.second)); });
}

void Contacts::push_pair(int A, int B, const MotionState& state, const Interval& interval) {
  const Shape& shape_A = model_.shape(A);
  const Shape& shape_B = model_.shape(B);
  const double bound_m = bounding_radius_m(shape_A) + bounding_radius_m(shape_B) + near_m_;
  near_pairs_.images().for_each(state.position_m.col(B) - state.position_m.col(A), bound_m,
                                [&](const Eigen::Vector3d& apart_m, const Eigen::Vector3d& number) {
                                  push_image(A, B, apart_m, image_word(number), state, interval);
                                });
}

void Contacts::push_image(int A, int B, const Eigen::Vector3d& apart_m, std::uint32_t image, const MotionState& state,
                          const Interval& interval) {
  const Shape& shape_A = model_.shape(A);
  const Shape& shape_B = model_.shape(B);
  const auto half_m = [&](int body, const Shape& shape) {
    return core_of(shape, body, state.position_m, state.orientation_wxyz).half_W_m;
  };
  const CoreSegment core_A{Eigen::Vector3d::Zero(), half_m(A, shape_A)};
  const CoreSegment core_B{apart_m, half_m(B, shape_B)};
  const Eigen::Vector3d at_A_m = nearest_place(core_A, core_B) * core_A.half_W_m;
  const Eigen::Vector3d at_B_m = nearest_place(core_B, at_A_m) * core_B.half_W_m;
  const Eigen::Vector3d between_m = apart_m + at_B_m - at_A_m;
  const double distance_m = between_m.norm();
  const double overlap_m = shape_A.radius_m + shape_B.radius_m - distance_m;
  if (overlap_m < -near_m_) return;
  if (overlap_m > std::min(shape_A.radius_m, shape_B.radius_m))
    throw too_soft("bodies '" + model_.name(A) + "' and '" + model_.name(B) + "' are pressed into each other",
                   overlap_m);
  Touch touch{.A = A, .B = B, .image = image, .normal = between_m / distance_m, .overlap_m = overlap_m};
  touch.arm_A_m = at_A_m + (shape_A.radius_m - 0.5 * overlap_m) * touch.normal;
  touch.arm_B_m = at_B_m - (shape_B.radius_m - 0.5 * overlap_m) * touch.normal;
  touch.friction = friction_;
  act(touch, B, state, interval);
}

void Contacts::push_from_wall(int body, std::size_t wall, const MotionState& state, const Interval& interval) {
  const WallSpecification& plane = walls_[wall];
  const Shape& shape = model_.shape(body);
  const double height_m = plane.normal.dot(state.position_m.col(body) - plane.point_m);
  if (height_m - bounding_radius_m(shape) > near_m_) return;
  const Eigen::Vector3d half_m = core_of(shape, body, state.position_m, state.orientation_wxyz).half_W_m;
  const int ends = half_m.isZero(0.0) ? 1 : 2;
  const double slope_m = plane.normal.dot(half_m);
  const auto overlap_m = [&](int end) { return shape.radius_m - height_m + (end == 0 ? slope_m : -slope_m); };
  for (int end = 0; end < ends; ++end) {
    if (overlap_m(end) < -near_m_) continue;
    if (overlap_m(end) > shape.radius_m)
      throw too_soft("body '" + model_.name(body) + "' is pressed into a wall", overlap_m(end));
    Touch touch{.A = body, .normal = -plane.normal, .overlap_m = overlap_m(end)};
    const Eigen::Vector3d at_m = (end == 0 ? -1.0 : 1.0) * (ends - 1) * half_m;
    touch.arm_A_m = at_m + (shape.radius_m - touch.overlap_m) * touch.normal;
    touch.wall_m_per_s = plane.velocity_m_per_s;
    touch.friction = plane.friction;
    touch.lies = ends == 2 && overlap_m(0) > 0.0 && overlap_m(1) > 0.0;
    act(touch, static_cast<int>(rank_.size() + 2 * wall) + end, state, interval);
  }
}

/// What a unit impulse along the normal changes of the velocity at the contact: f·f/m + τ·I⁻¹τ, of motions that the
/// body's kind allows.
double Contacts::inverse_mass_per_kg(int body, const Eigen::Vector3d& arm_m, const Eigen::Vector3d& normal,
                                     const MotionState& state) const {
  if (!model_.moves(body)) return 0.0;
  if (model_.shape(body).kind == ShapeKind::sphere && model_.motion(body) == MotionKind::free)
    return model_.inverse_mass_per_kg(body);  // the arm is along the normal
  Eigen::Vector3d force = normal;
  Eigen::Vector3d torque = arm_m.cross(normal);
  model_.constrain_loads(body, force, torque);
  return force.squaredNorm() * model_.inverse_mass_per_kg(body) +
         torque.dot(model_.angular_velocity_rad_per_s(body, state.orientation_wxyz.col(body), torque));
}

double Contacts::inverse_mass_per_kg(const Touch& touch, double at, const MotionState& state) {
  // On both ends a capsule bears like a sphere, each with half of its mass.
  const double shares = touch.lies ? 2.0 : 1.0;
  const Eigen::Vector3d& n = touch.normal;
  const Eigen::Vector3d arm_A_m = touch.lies ? Eigen::Vector3d(0, 0, 0) : touch.arm_A_m;
  double alone_per_kg = inverse_mass_per_kg(touch.A, arm_A_m, n, state);
  if (touch.B >= 0) alone_per_kg += inverse_mass_per_kg(touch.B, touch.arm_B_m, n, state);
  if (joints_.empty()) return shares * alone_per_kg;
  const JointRow apart{{-n, n}, {n.cross(arm_A_m), touch.arm_B_m.cross(n)}};
  const double taken_per_kg = joints_.inverse_mass_taken_per_kg({touch.A, touch.B}, apart, at, state, joints_work_);
  constexpr double held = 1e-9;  // by rounding of what joints hold altogether, as a wall is held
  return alone_per_kg - taken_per_kg > held * alone_per_kg ? shares * (alone_per_kg - taken_per_kg) : 0.0;
}

Eigen::Vector3d Contacts::relative_m_per_s(const Touch& touch, const MotionState& state) const {
  const auto surface_m_per_s = [&](int body, const Eigen::Vector3d& arm_m) -> Eigen::Vector3d {
    return state.velocity_m_per_s.col(body) + model_.angular_velocity_rad_per_s(body, state).cross(arm_m);
  };
  const Eigen::Vector3d of_other = touch.B < 0 ? touch.wall_m_per_s : surface_m_per_s(touch.B, touch.arm_B_m);
  return of_other - surface_m_per_s(touch.A, touch.arm_A_m);
}

void Contacts::act(const Touch& touch, int other, const MotionState& state, const Interval& interval) {
  const Eigen::Vector3d relative = relative_m_per_s(touch, state);
  const double separation_m_per_s = relative.dot(touch.normal);
  const double overlap_m = touch.overlap_m - interval.after_s * separation_m_per_s;
  if (overlap_m + 0.5 * interval.duration_s * std::abs(separation_m_per_s) <= 0.0) return;
  const double inverse_per_kg = inverse_mass_per_kg(touch, interval.at, state);
  if (!(inverse_per_kg > 0.0)) return;
  const double mass_kg = 1.0 / inverse_per_kg;
  const double pressure_N = law_.normal_force_N(overlap_m, -separation_m_per_s, mass_kg, interval.duration_s);
  if (pressure_N == 0.0) return;
  Eigen::Vector3d force_N = pressure_N * touch.normal;  // on the other
  touches_.push_back(touch);
  ContactMemory& memory = memory_.emplace_back(ContactMemory{.body = touch.A, .other = other, .image = touch.image});
  if (touch.friction > 0.0) {
    const Eigen::Vector3d slip_m_per_s = relative - separation_m_per_s * touch.normal;
    if (const ContactMemory* last = before(touch.A, other, touch.image)) {
      // The surfaces have moved with the mean of their velocities since then.
      memory.stretch_m = turned_into_plane(last->stretch_m, touch.normal) +
                         0.5 * interval.since_s * (slip_m_per_s + last->slip_m_per_s);
    }
    force_N += law_.friction_N(memory.stretch_m, slip_m_per_s, mass_kg, touch.friction * pressure_N);
  }
  force_N_.col(touch.A) -= force_N;
  torque_N_m_.col(touch.A) -= touch.arm_A_m.cross(force_N);
  if (touch.B < 0) return;
  force_N_.col(touch.B) += force_N;
  torque_N_m_.col(touch.B) += touch.arm_B_m.cross(force_N);
}

std::vector<std::uint64_t> Contacts::memory() const {
  std::vector<std::uint64_t> words;
  words.reserve(words_per_contact * memory_.size());
  for (const ContactMemory& contact : memory_) {
    words.push_back(static_cast<std::uint64_t>(contact.body));
    words.push_back(std::uint64_t{contact.image} << 32U | static_cast<std::uint32_t>(contact.other));
    for (const double stretch_m : contact.stretch_m) words.push_back(std::bit_cast<std::uint64_t>(stretch_m));
  }
  return words;
}

void Contacts::restore(std::span<const std::uint64_t> words) {
  bool valid = words.size() % words_per_contact == 0;
  memory_.clear();
  for (; valid && !words.empty(); words = words.subspan(words_per_contact)) {
    const auto other = static_cast<std::uint32_t>(words[1]);
    valid = words[0] < rank_.size() && std::in_range<int>(other);
    memory_.push_back({.body = static_cast<int>(words[0]),
                       .other = static_cast<int>(other),
                       .image = static_cast<std::uint32_t>(words[1] >> 32U)});
    for (int i = 0; i < 3; ++i) memory_.back().stretch_m[i] = std::bit_cast<double>(words[2 + i]);
  }
  if (!valid) throw StorageError("the saved body state has a contact of no body. Resume from another checkpoint.");
}

/// Contacts are asked for in the order in which they were left, but for the images of one pair.
const ContactMemory* Contacts::before(int body, int other, std::uint32_t image) {
  const auto place = [this](int first, int second) {
    const bool wall = second >= static_cast<int>(rank_.size());
    const auto rank = [&](int of) { return wall ? of : rank_[of]; };
    return std::tuple(wall, rank(first), rank(second));
  };
  const auto wanted = place(body, other);
  const auto at = [&](std::size_t i) { return place(before_[i].body, before_[i].other); };
  while (next_before_ < before_.size() && at(next_before_) < wanted) ++next_before_;
  for (std::size_t i = next_before_; i < before_.size() && at(i) == wanted; ++i)
    if (before_[i].image == image) return &before_[i];
  return nullptr;
}

void Contacts::apply(MotionState& state, double duration_s) {
  for (const int body : by_rank_) {
    if (!model_.moves(body)) continue;
    Eigen::Vector3d force_N = force_N_.col(body);
    Eigen::Vector3d torque_N_m = torque_N_m_.col(body);
    model_.constrain_loads(body, force_N, torque_N_m);
    state.velocity_m_per_s.col(body) += duration_s * model_.inverse_mass_per_kg(body) * force_N;
    state.angular_momentum_N_m_s.col(body) += duration_s * torque_N_m;
  }
  for (std::size_t i = 0; i < touches_.size(); ++i) {
    const Eigen::Vector3d relative = relative_m_per_s(touches_[i], state);
    memory_[i].slip_m_per_s = relative - relative.dot(touches_[i].normal) * touches_[i].normal;
  }
}

OverlapCheck::OverlapCheck(const BodyModel& model, NearPairs& near_pairs, const ContactSpecification& contact)
    : model_(model),
      near_pairs_(near_pairs),
      overlaps_(model.shapes(), near_pairs.images()),
      contacts_are_resolved_(contact.stiffness_N_per_m > 0.0) {}

void OverlapCheck::check(const MotionState& state, std::int64_t step, ThreadTeam& team) {
  std::atomic<bool> hold = true;
  share_ranges(team, state.bodies(), [&](std::size_t first, std::size_t last) {
    if (!near_pairs_.hold(state.position_m, first, last)) hold = false;
  });
  if (!hold) near_pairs_.list(state.position_m);
  const std::vector<BodyPair>& pairs = near_pairs_.listed();
  share_ranges(team, pairs.size(), [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) check_pair(pairs[i].first, pairs[i].second, state, step);
  });
  for (const int body : near_pairs_.longer_than_the_box()) check_pair(body, body, state, step);
}

void OverlapCheck::check_pair(int A, int B, const MotionState& state, std::int64_t step) const {
  const double depth_m = overlaps_.depth_m(A, B, state.position_m, state.orientation_wxyz);
  if (!(depth_m > 0.0)) return;
  std::array<char, 32> depth{};
  std::snprintf(depth.data(), depth.size(), " by %.3e m", depth_m);
  if (A == B)
    throw SolverError("body '" + model_.name(A) + "' overlaps with its own periodic image" + depth.data() +
                          " (the periodic length is shorter than the body). Use a larger domain.",
                      0, step);
  throw SolverError(
      "bodies '" + model_.name(A) + "' and '" + model_.name(B) + "' overlap" + depth.data() +
          (contacts_are_resolved_
               ? " at the start (a contact would push them apart at once). Start them further apart."
               : " (contacts are not resolved). Let bodies rebound (contact: {} in the case), start them further "
                 "apart, or use a smaller amplitude of the drive (amplitude_N, amplitude_m), a stiffer spring or a "
                 "shorter step."),
      0, step);
}

}  // namespace copepod::body
