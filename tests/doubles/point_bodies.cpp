#include "point_bodies.hpp"

#include <fstream>

#include "contract/digest.hpp"
#include "contract/errors.hpp"

namespace copepod::doubles {

namespace {

/// Calls `visit` for every number of the state but its step, in a fixed order.
template <class State, class Visit>
void for_each_number(State& state, Visit visit) {
  for (auto& number : state.position_m.reshaped()) visit(number);
  for (auto& number : state.orientation_wxyz.reshaped()) visit(number);
  for (auto& number : state.velocity_m_per_s.reshaped()) visit(number);
  for (auto& number : state.angular_velocity_rad_per_s.reshaped()) visit(number);
}

}  // namespace

PointBodies::PointBodies(const BodySetup& setup) : step_s_(setup.step_s) {
  state_.resize(static_cast<Eigen::Index>(setup.bodies.size()));
  Eigen::Index column = 0;
  for (const BodySpecification& body : setup.bodies) {
    state_.position_m.col(column) = body.position_m;
    state_.orientation_wxyz.col(column) = body.orientation_wxyz;
    state_.velocity_m_per_s.col(column) = body.velocity_m_per_s;
    state_.angular_velocity_rad_per_s.col(column) = body.angular_velocity_rad_per_s;
    ++column;
  }
}

void PointBodies::step(const AppliedLoads& applied, Kinematics& next) {
  accelerate(applied, state_);
  state_.position_m += step_s_ * state_.velocity_m_per_s;
  state_.step = applied.hydrodynamic.step + 1;
  next = state_;
}

void PointBodies::save(const std::string& path) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(&state_.step), sizeof(state_.step));
  for_each_number(state_, [&](double& number) { file.write(reinterpret_cast<const char*>(&number), sizeof(number)); });
  file.flush();
  if (!file) throw StorageError("The file " + path + " cannot be written (no such folder?). Choose another path.");
}

void PointBodies::restore(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  file.read(reinterpret_cast<char*>(&state_.step), sizeof(state_.step));
  for_each_number(state_, [&](double& number) { file.read(reinterpret_cast<char*>(&number), sizeof(number)); });
  if (!file)
    throw StorageError("The file " + path + " cannot be read (missing or damaged). Choose another checkpoint.");
}

SolverSummary PointBodies::summarise() {
  Digest digest;
  for_each_number(state_, [&](double& number) { digest.add(number); });
  return {digest.value(), 0, 1, {}};
}

}  // namespace copepod::doubles
