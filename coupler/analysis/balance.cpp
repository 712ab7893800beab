#include "analysis/balance.hpp"

#include <nlohmann/json.hpp>

#include "config/checks/checks.hpp"
#include "geometry/rotation.hpp"

namespace copepod::coupler {

void Balance::observe(const StepRecord& record) {
  if (!started_) add_motion(record.kinematics, sums_.start_kg_m_per_s, sums_.start_J);
  started_ = true;
  for (Eigen::Index b = 0; b < record.kinematics.bodies(); ++b) {
    if (!moves_under_loads(bodies_[b])) continue;
    const auto impulse = [&](const Loads& loads) -> Eigen::Vector3d { return loads.force_N.col(b) * step_s_; };
    const auto work_J = [&](const Loads& loads) {
      return step_s_ * (loads.force_N.col(b).dot(record.kinematics.velocity_m_per_s.col(b)) +
                        loads.torque_N_m.col(b).dot(record.kinematics.angular_velocity_rad_per_s.col(b)));
    };
    sums_.from_fluid_N_s += impulse(record.raw);
    sums_.from_drive_N_s += impulse(record.drive);
    sums_.withheld_N_s += impulse(record.raw) - impulse(record.applied);
    sums_.exchanged_N_s += impulse(record.raw).norm();
    sums_.from_fluid_J += work_J(record.raw);
    sums_.from_drive_J += work_J(record.drive);
  }
}

/// P = Σ M v,   E = Σ (M v² + ω · I ω)/2
void Balance::add_motion(const Kinematics& kinematics, Eigen::Vector3d& momentum_kg_m_per_s, double& energy_J) const {
  for (Eigen::Index b = 0; b < kinematics.bodies(); ++b) {
    const BodySpecification& body = bodies_[b];
    if (!moves_under_loads(body)) continue;
    const Eigen::Vector3d v = kinematics.velocity_m_per_s.col(b);
    const Eigen::Vector3d w_B =
        rotation_matrix(kinematics.orientation_wxyz.col(b)).transpose() * kinematics.angular_velocity_rad_per_s.col(b);
    momentum_kg_m_per_s += body.mass_kg * v;
    energy_J += 0.5 * (body.mass_kg * v.squaredNorm() + w_B.dot(inertia_tensor_kg_m2(body) * w_B));
  }
}

nlohmann::ordered_json Balance::report() const {
  return {{"momentum_N_s",
           {{"bodies_at_start", sums_.start_kg_m_per_s},
            {"bodies_at_end", end_kg_m_per_s_},
            {"from_fluid", sums_.from_fluid_N_s},
            {"from_drive", sums_.from_drive_N_s}}},
          {"energy_J",
           {{"bodies_at_start", sums_.start_J},
            {"bodies_at_end", end_J_},
            {"from_fluid", sums_.from_fluid_J},
            {"from_drive", sums_.from_drive_J}}}};
}

}  // namespace copepod::coupler
