#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "config/checks/checks.hpp"
#include "config/placement/geometry.hpp"

namespace copepod::coupler {
namespace {

using Complex = std::complex<double>;

/// |R(z)| of Runge-Kutta 4.
double amplification(Complex z) { return std::abs(1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0)))); }

double largest_step_of_runge_kutta_s(double a, double b) {
  const Complex root = std::sqrt(Complex(b * b - 4.0 * a));
  const std::array<Complex, 2> rates{(-b + root) / 2.0, (-b - root) / 2.0};
  constexpr double beyond = 4.0;  // |z| of no stable point is that large
  constexpr double rounding = 1e-9;
  double stable = 0.0;
  double unstable = beyond / std::max(std::abs(rates[0]), std::abs(rates[1]));
  for (int halving = 0; halving < 50; ++halving) {
    const double middle = 0.5 * (stable + unstable);
    const bool grows = std::max(amplification(middle * rates[0]), amplification(middle * rates[1])) > 1.0 + rounding;
    (grows ? unstable : stable) = middle;
  }
  return stable;
}

/// What a spring of unit tension, or a bend of unit moment, does to one of its bodies.
struct End {
  std::size_t spring = 0;  ///< as in StepLimit
  Eigen::Vector3d force_W;
  Eigen::Vector3d torque_W;  ///< about the centre of mass
};

/// Rate at which a unit tension at end f accelerates its body along end e, of motions that its kind allows:
///   e·f/m + τ_e·I⁻¹ τ_f;   on an axis a: (a·e)(a·f)/m + (a·τ_e)(a·τ_f)/(aᵀ I a)
double response(const BodySpecification& body, const End& e, const End& f) {
  const Eigen::Matrix3d R_WB = rotation_matrix(body.orientation_wxyz);
  const Eigen::Matrix3d inertia_kg_m2 = R_WB * inertia_tensor_kg_m2(body) * R_WB.transpose();
  if (!moves_under_loads(body)) return 0.0;
  if (body.motion == MotionKind::axis)
    return e.force_W.dot(body.axis) * f.force_W.dot(body.axis) / body.mass_kg +
           e.torque_W.dot(body.axis) * f.torque_W.dot(body.axis) / body.axis.dot(inertia_kg_m2 * body.axis);
  return e.force_W.dot(f.force_W) / body.mass_kg + e.torque_W.dot(inertia_kg_m2.ldlt().solve(f.torque_W));
}

/// The ends that pull at each body.
std::vector<std::vector<End>> ends_by_body(const std::vector<BodySpecification>& bodies,
                                           const std::vector<SpringSpecification>& springs,
                                           const std::vector<BendSpecification>& bends,
                                           const std::vector<JointSpecification>& joints) {
  std::vector<std::vector<End>> ends(bodies.size());
  for (std::size_t i = 0; i < springs.size(); ++i) {
    const SpringSpecification& spring = springs[i];
    if (spring.body_A < 0 || spring.body_B < 0) continue;
    const BodySpecification &A = bodies[spring.body_A], &B = bodies[spring.body_B];
    const Eigen::Vector3d arm_A = in_world(A, spring.anchor_A_m);
    const Eigen::Vector3d arm_B = in_world(B, spring.anchor_B_m);
    const Eigen::Vector3d along = (B.position_m + arm_B - A.position_m - arm_A).stableNormalized();
    ends[spring.body_A].push_back({i, along, arm_A.cross(along)});
    ends[spring.body_B].push_back({i, -along, -arm_B.cross(along)});
  }
  for (std::size_t i = 0; i < bends.size(); ++i) {
    const BendSpecification& bend = bends[i];
    if (std::min({bend.body_A, bend.body_B, bend.body_C}) < 0) continue;
    Eigen::Vector3d on_vertex = Eigen::Vector3d::Zero();
    const auto arm_m = [&](int body) -> Eigen::Vector3d {
      return bodies[body].position_m - bodies[bend.body_B].position_m;
    };
    const Eigen::Vector3d normal = arm_m(bend.body_A).stableNormalized().cross(arm_m(bend.body_C).stableNormalized());
    // Straight arms bend alike in every plane through them.
    const Eigen::Vector3d axis = normal.norm() > 1e-9 ? normal.normalized() : arm_m(bend.body_A).unitOrthogonal();
    for (const auto& [body, turn] : {std::pair(bend.body_A, 1.0), std::pair(bend.body_C, -1.0)}) {
      const Eigen::Vector3d arm = arm_m(body);
      const Eigen::Vector3d across = turn * axis.cross(arm) / std::max(arm.squaredNorm(), 1e-300);
      ends[body].push_back({springs.size() + i, across, Eigen::Vector3d::Zero()});
      on_vertex -= across;
    }
    ends[bend.body_B].push_back({springs.size() + i, on_vertex, Eigen::Vector3d::Zero()});
  }
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const JointSpecification& joint = joints[i];
    if (joint.body_A < 0 || !has_axis(joint.kind)) continue;
    const Eigen::Vector3d axis = in_world(bodies[joint.body_A], joint.axis);
    const auto add = [&](int body, const Eigen::Vector3d& anchor_m, double sign) {
      if (body < 0) return;
      const Eigen::Vector3d none = Eigen::Vector3d::Zero();
      const Eigen::Vector3d along = sign * axis;
      if (joint.kind == JointKind::hinge)
        ends[body].push_back({springs.size() + bends.size() + i, none, along});
      else
        ends[body].push_back({springs.size() + bends.size() + i, along, in_world(bodies[body], anchor_m).cross(along)});
    };
    add(joint.body_A, joint.anchor_A_m, 1.0);
    add(joint.body_B, joint.anchor_B_m, -1.0);
  }
  return ends;
}

}  // namespace

double largest_stable_step_s(Integrator integrator, double stiffness_per_s2, double damping_per_s) {
  if (stiffness_per_s2 == 0.0 && damping_per_s == 0.0) return std::numeric_limits<double>::infinity();
  if (integrator == Integrator::runge_kutta_4) return largest_step_of_runge_kutta_s(stiffness_per_s2, damping_per_s);
  return 4.0 / (damping_per_s + std::sqrt(damping_per_s * damping_per_s + 4.0 * stiffness_per_s2));
}

FastestSprings fastest_springs(const std::vector<BodySpecification>& bodies,
                               const std::vector<SpringSpecification>& springs,
                               const std::vector<BendSpecification>& bends,
                               const std::vector<JointSpecification>& joints, Integrator integrator) {
  struct Rates {
    double stiffness_per_s2 = 0.0;
    double damping_per_s = 0.0;
  };
  // Square roots of stiffness and damping: [N/m], [N s/m] of springs and sliders, [N m/rad] of bends and hinges.
  std::vector<std::pair<double, double>> roots;
  roots.reserve(springs.size() + bends.size() + joints.size());
  for (const auto& spring : springs)
    roots.emplace_back(std::sqrt(spring.stiffness_N_per_m), std::sqrt(spring.damping_N_s_per_m));
  for (const auto& bend : bends) roots.emplace_back(std::sqrt(bend.stiffness_N_m_per_rad), 0.0);
  std::vector<Rates> alone(roots.size());
  for (const auto& joint : joints) roots.emplace_back(std::sqrt(joint.stiffness), std::sqrt(joint.damping));
  std::vector<Rates> all(roots.size());
  const auto ends = ends_by_body(bodies, springs, bends, joints);
  for (std::size_t body = 0; body < bodies.size(); ++body) {
    for (const End& e : ends[body]) {
      for (const End& f : ends[body]) {
        const double rate = std::abs(response(bodies[body], e, f));
        const auto add_to = [&](Rates& rates) {
          rates.stiffness_per_s2 += rate * roots[e.spring].first * roots[f.spring].first;
          rates.damping_per_s += rate * roots[e.spring].second * roots[f.spring].second;
        };
        add_to(all[e.spring]);
        if (e.spring == f.spring && e.spring < alone.size()) add_to(alone[e.spring]);
      }
    }
  }
  const auto fastest_of = [&](const std::vector<Rates>& rates) {
    StepLimit fastest{0, std::numeric_limits<double>::infinity()};
    for (std::size_t i = 0; i < rates.size(); ++i) {
      const double step_s = largest_stable_step_s(integrator, rates[i].stiffness_per_s2, rates[i].damping_per_s);
      if (step_s < fastest.largest_step_s) fastest = {i, step_s};
    }
    return fastest;
  };
  return {fastest_of(all), fastest_of(alone)};
}

}  // namespace copepod::coupler
