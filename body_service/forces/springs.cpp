#include "forces/springs.hpp"

#include <array>

#include <Eigen/Geometry>

#include "contract/errors.hpp"
#include "forces/pair_batch.hpp"
#include "geometry/rotation.hpp"

namespace copepod::body {

namespace {

void check(const SpringSpecification& spring, std::size_t index, int bodies) {
  const std::string name = "spring " + std::to_string(index);
  const auto exists = [bodies](int body) { return body >= 0 && body < bodies; };
  if (!exists(spring.body_A) || !exists(spring.body_B)) {
    throw CaseError(name + " connects bodies " + std::to_string(spring.body_A) + " and " +
                    std::to_string(spring.body_B) + " (there are " + std::to_string(bodies) +
                    " bodies, counted from 0). Correct the indices.");
  }
  if (spring.body_A == spring.body_B) {
    throw CaseError(name + " connects body " + std::to_string(spring.body_A) +
                    " to itself (such a spring does no work). Connect two bodies.");
  }
  if (!(spring.stiffness_N_per_m >= 0.0) || !(spring.damping_N_s_per_m >= 0.0) || !(spring.rest_length_m >= 0.0)) {
    throw CaseError(name +
                    " has a negative stiffness, damping or rest length (a spring must not create energy, and a length "
                    "is not negative). Use 0 or more.");
  }
}

}  // namespace

Springs::Springs(const BodySetup& setup) {
  for (const auto& body : setup.bodies) names_.push_back(body.name);
  for (const auto& spring : setup.springs) {
    check(spring, springs_.size(), static_cast<int>(setup.bodies.size()));
    springs_.push_back(
        {spring.body_A, spring.body_B, {spring.stiffness_N_per_m, spring.damping_N_s_per_m, spring.rest_length_m}});
    if (spring.anchor_A_m.isZero(0.0) && spring.anchor_B_m.isZero(0.0)) continue;
    springs_.back().anchors = static_cast<int>(anchors_.size());
    anchors_.push_back({spring.anchor_A_m, spring.anchor_B_m});
  }
}

void Springs::add_loads(const Stage& stage, BlockVectors& force_N, BlockVectors& torque_N_m) const {
  const Eigen::Index first = stage.block.first;
  const std::vector<int>& springs = stage.block.springs;
  for (std::size_t next = 0; next < springs.size();) {
    const auto index = static_cast<std::size_t>(springs[next]);
    if (springs_[index].anchors < 0) {
      next = add_unanchored(stage, next, force_N);
      continue;
    }
    const Eigen::Index A = springs_[index].body_A - first;
    const Eigen::Index B = springs_[index].body_B - first;
    const Pull anchored = pull(index, first, stage.state, stage.angular_velocity_rad_per_s);
    force_N.col(A) += anchored.f_A_W_N;
    force_N.col(B) -= anchored.f_A_W_N;
    torque_N_m.col(A) += anchored.r_A_W_m.cross(anchored.f_A_W_N);
    torque_N_m.col(B) -= anchored.r_B_W_m.cross(anchored.f_A_W_N);
    ++next;
  }
}

std::size_t Springs::add_unanchored(const Stage& stage, std::size_t from, BlockVectors& force_N) const {
  PairBatch pairs;
  std::array<PairBatch::Numbers, 3> ddot_AB_m_per_s;  // NOLINT(cppcoreguidelines-pro-type-member-init): likewise
  std::array<PairBatch::Numbers, 3> laws;             // NOLINT(cppcoreguidelines-pro-type-member-init)
  const auto position_m = components(stage.state.position_m);
  const auto velocity_m_per_s = components(stage.state.velocity_m_per_s);
  const auto first = static_cast<int>(stage.block.first);
  std::size_t next = from;
  for (; next < stage.block.springs.size() && !pairs.full(); ++next) {
    const Spring& spring = springs_[static_cast<std::size_t>(stage.block.springs[next])];
    if (spring.anchors >= 0) break;
    const int A = spring.body_A - first;
    const int B = spring.body_B - first;
    const int pair = pairs.size;
    pairs.add(A, B, position_m);
    for (int i = 0; i < 3; ++i) ddot_AB_m_per_s[i][pair] = velocity_m_per_s[i][B] - velocity_m_per_s[i][A];
    laws[0][pair] = spring.law.stiffness_N_per_m;
    laws[1][pair] = spring.law.damping_N_s_per_m;
    laws[2][pair] = spring.law.rest_length_m;
  }
  for (int pair = 0; pair < pairs.size; ++pair) {
    const auto force_N_of = spring_force(SpringLaw{laws[0][pair], laws[1][pair], laws[2][pair]},
                                         PairBatch::at(pairs.d_AB_m, pair), PairBatch::at(ddot_AB_m_per_s, pair));
    for (int i = 0; i < 3; ++i) pairs.force_A_N[i][pair] = force_N_of[i];
  }
  pairs.add_forces(force_N, [&](int pair) {
    fail(springs_[static_cast<std::size_t>(stage.block.springs[from + static_cast<std::size_t>(pair)])]);
  });
  return next;
}

Springs::Pull Springs::pull(std::size_t index, Eigen::Index first, const BlockState& state,
                            const BlockVectors& w) const {
  const Spring& spring = springs_[index];
  const Eigen::Index A = spring.body_A - first;
  const Eigen::Index B = spring.body_B - first;
  Pull pull;
  const Anchors anchors = spring.anchors < 0 ? Anchors{} : anchors_[static_cast<std::size_t>(spring.anchors)];
  pull.r_A_W_m = rotation_matrix(state.orientation_wxyz.col(A)) * anchors.A_m;
  pull.r_B_W_m = rotation_matrix(state.orientation_wxyz.col(B)) * anchors.B_m;
  pull.d_AB_W_m = (state.position_m.col(B) - state.position_m.col(A)) + (pull.r_B_W_m - pull.r_A_W_m);
  const Eigen::Vector3d ddot_AB_W_m_per_s = (state.velocity_m_per_s.col(B) + w.col(B).cross(pull.r_B_W_m)) -
                                            (state.velocity_m_per_s.col(A) + w.col(A).cross(pull.r_A_W_m));
  if (pull.d_AB_W_m.isZero(0.0)) fail(spring);
  pull.f_A_W_N = spring_force(spring.law, pull.d_AB_W_m, ddot_AB_W_m_per_s);
  return pull;
}

void Springs::fail(const Spring& spring) const {
  throw SolverError("the ends of the spring between bodies '" + names_[spring.body_A] + "' and '" +
                    names_[spring.body_B] +
                    "' coincide (its force has no direction). Give it a longer rest length, a higher stiffness, or "
                    "start its ends apart.");
}

}  // namespace copepod::body
