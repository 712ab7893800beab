#pragma once

#include <cmath>
#include <cstdint>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "contract/body_setup.hpp"
#include "contract/errors.hpp"
#include "contract/solver.hpp"
#include "geometry/actuator_loads.hpp"
#include "run/components.hpp"

namespace copepod::coupler {

/// Stokes drag on every body: F = −drag · v, T = −drag · w (in SI units of whatever the test likes).
class ConstantDragFluid : public FluidSolver {
 public:
  explicit ConstantDragFluid(double drag) : drag_(drag) {}

  void exchange(const Kinematics& kinematics, Loads& loads) override {
    if (before_exchange) before_exchange(kinematics.step);
    loads.step = kinematics.step;
    loads.resize(kinematics.bodies());
    loads.force_N = -drag_ * kinematics.velocity_m_per_s;
    loads.torque_N_m = -drag_ * kinematics.angular_velocity_rad_per_s;
    ++exchanges;
  }
  void advance() override { ++advances; }
  void save(const std::string& path) override {
    if (before_save) before_save();
    std::ofstream(path) << exchanges;
  }
  void restore(const std::string& path) override { std::ifstream(path) >> exchanges; }
  SolverSummary summarise() override {
    return {static_cast<std::uint64_t>(exchanges),
            static_cast<std::uint64_t>(exchanges) * 1000,
            1,
            phases_s,
            {"map"},
            {"idle"}};
  }

  std::function<void(std::int64_t step)> before_exchange;  ///< to make it fail, or to look
  std::function<void()> before_save;
  std::map<std::string, double> phases_s{{"bulk", 0.25}, {"map", 0.05}, {"idle", 9.0}};
  int exchanges = 0;
  int advances = 0;

 private:
  double drag_;
};

/// Point masses with springs between their centres, advanced by classical Runge-Kutta with loads held over
/// the step and the drive sampled at 0, 1/2 and 1. Rotation is left out.
class PointMassBodies : public BodySolver {
 public:
  explicit PointMassBodies(BodySetup setup) : setup_(std::move(setup)) {
    const auto bodies = static_cast<Eigen::Index>(setup_.bodies.size());
    state_.resize(bodies);
    for (Eigen::Index i = 0; i < bodies; ++i) {
      const BodySpecification& body = setup_.bodies[static_cast<std::size_t>(i)];
      state_.position_m.col(i) = body.position_m;
      state_.orientation_wxyz.col(i) = body.orientation_wxyz;
      state_.velocity_m_per_s.col(i) = body.velocity_m_per_s;
      state_.angular_velocity_rad_per_s.col(i) = body.angular_velocity_rad_per_s;
    }
  }

  [[nodiscard]] std::vector<double> driving_nodes() const override { return {0.0, 0.5, 1.0}; }
  void kinematics(Kinematics& kinematics) override { kinematics = state_; }

  void step(const AppliedLoads& applied, Kinematics& next) override {
    const double h = setup_.step_s;
    const Eigen::Matrix3Xd x = state_.position_m;
    const Eigen::Matrix3Xd v = state_.velocity_m_per_s;
    const Eigen::Matrix3Xd a1 = acceleration(x, v, applied, 0);
    const Eigen::Matrix3Xd v2 = v + 0.5 * h * a1;
    const Eigen::Matrix3Xd a2 = acceleration(x + 0.5 * h * v, v2, applied, 1);
    const Eigen::Matrix3Xd v3 = v + 0.5 * h * a2;
    const Eigen::Matrix3Xd a3 = acceleration(x + 0.5 * h * v2, v3, applied, 1);
    const Eigen::Matrix3Xd v4 = v + h * a3;
    const Eigen::Matrix3Xd a4 = acceleration(x + h * v3, v4, applied, 2);
    state_.position_m += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4);
    state_.velocity_m_per_s += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
    ++state_.step;
    next = state_;
  }

  void save(const std::string& path) override {
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(&state_.step), sizeof state_.step);
    for (const Eigen::Matrix3Xd* part : {&state_.position_m, &state_.velocity_m_per_s}) {
      file.write(reinterpret_cast<const char*>(part->data()),
                 static_cast<std::streamsize>(part->size() * sizeof(double)));
    }
  }
  void restore(const std::string& path) override {
    std::ifstream file(path, std::ios::binary);
    file.read(reinterpret_cast<char*>(&state_.step), sizeof state_.step);
    for (Eigen::Matrix3Xd* part : {&state_.position_m, &state_.velocity_m_per_s}) {
      file.read(reinterpret_cast<char*>(part->data()), static_cast<std::streamsize>(part->size() * sizeof(double)));
    }
    if (!file) throw StorageError(path + " cannot be read (too short). Use another checkpoint.");
  }
  SolverSummary summarise() override { return {42, 0, 1, {{"integrate", 0.01}}}; }

 private:
  Eigen::Matrix3Xd acceleration(const Eigen::Matrix3Xd& x, const Eigen::Matrix3Xd& v, const AppliedLoads& applied,
                                Eigen::Index node) const {
    const Eigen::Index bodies = x.cols();
    Kinematics stage = state_;
    stage.position_m = x;
    Loads drive;
    drive_loads(setup_.actuators, applied.actuation.col(node), stage, drive);
    Eigen::Matrix3Xd force = applied.hydrodynamic.force_N + drive.force_N;
    for (const SpringSpecification& spring : setup_.springs) {
      const Eigen::Vector3d between = x.col(spring.body_B) - x.col(spring.body_A);
      const Eigen::Vector3d closing = v.col(spring.body_B) - v.col(spring.body_A);
      const Eigen::Vector3d direction = between.normalized();
      const double pull = spring.stiffness_N_per_m * (between.norm() - spring.rest_length_m) +
                          spring.damping_N_s_per_m * closing.dot(direction);
      force.col(spring.body_A) += pull * direction;
      force.col(spring.body_B) -= pull * direction;
    }
    for (Eigen::Index i = 0; i < bodies; ++i) force.col(i) /= setup_.bodies[static_cast<std::size_t>(i)].mass_kg;
    return force;
  }

  BodySetup setup_;
  Kinematics state_;
};

/// Components in this process, made of the solvers above.
class LocalComponents : public Components {
 public:
  LocalComponents(double drag, bool saves) : drag_(drag) {
    fluid_capabilities_ = {
        "ConstantDragFluid", "1", {"solver:vacuum", "solver:stokes", "shape:sphere", "neglects:boundary"}};
    body_capabilities_ = {"PointMassBodies",
                          "1",
                          {"shape:sphere", "motion:free", "springs", "integrator:runge_kutta_4", "actuator:pair_force",
                           "actuator:world_force"}};
    if (!saves) return;
    fluid_capabilities_.features.insert("checkpoint");
    body_capabilities_.features.insert("checkpoint");
  }

  void connect() override {
    if (on_connect) on_connect();
  }
  [[nodiscard]] const Capabilities& fluid_capabilities() const override { return fluid_capabilities_; }
  [[nodiscard]] const Capabilities& body_capabilities() const override { return body_capabilities_; }
  std::unique_ptr<FluidSolver> make_fluid(const FluidSetup&, std::int64_t) override {
    auto fluid = std::make_unique<ConstantDragFluid>(drag_);
    fluid->before_exchange = before_exchange;
    fluid->before_save = before_save;
    if (!fluid_reports_phases) fluid->phases_s.clear();
    return fluid;
  }
  std::unique_ptr<BodySolver> make_body(const BodySetup& setup, std::int64_t) override {
    return std::make_unique<PointMassBodies>(setup);
  }
  void finish() override { finished = true; }
  void abort(const FailureReport& report) noexcept override { aborted_with = report.reason; }

  std::function<void()> on_connect, before_save;
  std::function<void(std::int64_t step)> before_exchange;
  Capabilities& changeable_body_capabilities() { return body_capabilities_; }
  bool fluid_reports_phases = true;
  bool finished = false;
  std::string aborted_with;

 private:
  double drag_;
  Capabilities fluid_capabilities_;
  Capabilities body_capabilities_;
};

}  // namespace copepod::coupler
