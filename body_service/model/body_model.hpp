#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "contract/body_setup.hpp"
#include "geometry/rotation.hpp"
#include "model/body_block.hpp"
#include "model/motion_state.hpp"

namespace copepod::body {

/// What does not change about the bodies during a run; SI units, one entry or column per body.
class BodyModel {
 public:
  /// @throws CaseError naming the body if a mass, shape, orientation or axis is not valid
  explicit BodyModel(const BodySetup& setup);

  [[nodiscard]] Eigen::Index bodies() const { return inverse_mass_per_kg_.size(); }
  [[nodiscard]] const std::string& name(Eigen::Index body) const { return names_[body]; }
  [[nodiscard]] const std::vector<Shape>& shapes() const { return shapes_; }
  [[nodiscard]] const Shape& shape(Eigen::Index body) const { return shapes_[body]; }
  [[nodiscard]] MotionKind motion(Eigen::Index body) const { return motions_[body]; }
  /// Whether loads move it.
  [[nodiscard]] bool moves(Eigen::Index body) const {
    return motions_[body] == MotionKind::free || motions_[body] == MotionKind::axis;
  }
  [[nodiscard]] Eigen::Vector3d axis(Eigen::Index body) const { return axis_.col(body); }
  [[nodiscard]] double inverse_mass_per_kg(Eigen::Index body) const { return inverse_mass_per_kg_[body]; }
  [[nodiscard]] const Eigen::RowVectorXd& inverse_masses_per_kg() const { return inverse_mass_per_kg_; }
  /// What a torque or an angular momentum turns into, R I_B⁻¹ Rᵀ v; of an angular momentum it is the angular velocity,
  ///   ω = R I_B⁻¹ Rᵀ L                                                                 (B11)
  [[nodiscard]] Eigen::Vector3d per_inertia(Eigen::Index body, const Eigen::Matrix3d& R_WB,
                                            const Eigen::Vector3d& vector_W) const {
    if (inertia_[body] == Inertia::full) return R_WB * (full_[body] * (R_WB.transpose() * vector_W));
    return R_WB * inverse_inertia_.col(body).cwiseProduct(R_WB.transpose() * vector_W);
  }

  [[nodiscard]] Eigen::Vector3d angular_velocity_rad_per_s(Eigen::Index body, const Eigen::Vector4d& q_WB,
                                                           const Eigen::Vector3d& L_W_N_m_s) const {
    // An isotropic tensor commutes with every rotation: spheres need no rotation matrix.
    if (inertia_[body] == Inertia::isotropic) return inverse_inertia_.col(body).cwiseProduct(L_W_N_m_s);
    return per_inertia(body, rotation_matrix(q_WB), L_W_N_m_s);
  }

  [[nodiscard]] Eigen::Vector3d angular_velocity_rad_per_s(Eigen::Index body, const MotionState& state) const {
    return angular_velocity_rad_per_s(body, state.orientation_wxyz.col(body), state.angular_momentum_N_m_s.col(body));
  }

  /// The same of the bodies of a block.
  void angular_velocities_rad_per_s(const BodyBlock& block, const BlockState& state,
                                    BlockVectors& w_WB_rad_per_s) const {
    if (block.of_free_spheres) {
      const auto L = components(state.angular_momentum_N_m_s);
      const auto w = components(w_WB_rad_per_s);
      for (std::size_t k = 0; k < 3; ++k) multiply(block.bodies, &inverse_inertia_(0, block.first), L[k], w[k]);
      return;
    }
    for (Eigen::Index i = 0; i < block.bodies; ++i)
      w_WB_rad_per_s.col(i) = angular_velocity_rad_per_s(block.first + i, state.orientation_wxyz.col(i),
                                                         state.angular_momentum_N_m_s.col(i));
  }

  /// Takes from force and torque what the constraint force of the body's kind of motion balances      (B12)
  ///   free: nothing;   fixed, prescribed: all;   axis: all but the part along the axis, F → a (a·F)
  void constrain_loads(Eigen::Index body, Eigen::Ref<Eigen::Vector3d> force_N,
                       Eigen::Ref<Eigen::Vector3d> torque_N_m) const {
    if (motions_[body] == MotionKind::free) return;
    if (motions_[body] == MotionKind::axis) {
      force_N = axis(body) * axis(body).dot(force_N);
      torque_N_m = axis(body) * axis(body).dot(torque_N_m);
    } else {
      force_N.setZero();
      torque_N_m.setZero();
    }
  }

  /// State of motion at the start of the run.
  [[nodiscard]] const MotionState& initial_state() const { return initial_; }

 private:
  /// Of the tensor that answers to torques: a multiple of unity, diagonal, or neither.
  enum class Inertia : std::uint8_t { isotropic, principal, full };

  void add(Eigen::Index body, const BodySpecification& specification);

  std::vector<std::string> names_;
  std::vector<Shape> shapes_;
  std::vector<MotionKind> motions_;
  std::vector<Inertia> inertia_;
  Eigen::Matrix3Xd axis_;
  Eigen::RowVectorXd inverse_mass_per_kg_;
  BlockVectors inverse_inertia_;       ///< diagonal of I_B⁻¹ [1/(kg m²)]
  std::vector<Eigen::Matrix3d> full_;  ///< I_B⁻¹
  MotionState initial_;
};

}  // namespace copepod::body
