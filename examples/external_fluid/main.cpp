// A fluid component in one file: Stokes drag in a uniform stream. Run a case with it:
//   deploy/copepod run CASE.yaml --fluid /tmp/external_fluid/external_fluid
#include <cstdint>
#include <fstream>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "component/run_component.hpp"
#include "contract/digest.hpp"
#include "contract/errors.hpp"

namespace {

using namespace copepod;

/// Drag on lonely spheres in a stream along x.
///   F = 6π η r (U − v),   T = −8π η r³ ω
/// Neglects the other bodies, the walls and the inertia of the fluid.
class UniformStream final : public FluidSolver {
 public:
  explicit UniformStream(const FluidSetup& setup)
      : bodies_(setup.bodies), viscosity_Pa_s_(setup.density_kg_per_m3 * setup.kinematic_viscosity_m2_per_s) {}

  void exchange(const Kinematics& kinematics, Loads& loads) override {
    constexpr double pi = std::numbers::pi;
    loads.resize(kinematics.bodies());
    loads.step = kinematics.step;
    for (Eigen::Index i = 0; i < kinematics.bodies(); ++i) {
      const double r_m = bodies_[static_cast<std::size_t>(i)].radius_m;
      const Eigen::Vector3d slip_m_per_s = kStream_m_per_s - kinematics.velocity_m_per_s.col(i);
      loads.force_N.col(i) = 6 * pi * viscosity_Pa_s_ * r_m * slip_m_per_s;
      loads.torque_N_m.col(i) =
          -8 * pi * viscosity_Pa_s_ * r_m * r_m * r_m * kinematics.angular_velocity_rad_per_s.col(i);
    }
  }

  void advance() override { ++steps_; }

  void save(const std::string& path) override {
    std::ofstream file(path);
    file << steps_ << " steps" << std::endl;
    if (!file) throw StorageError("The file " + path + " cannot be written (no such folder?). Choose another path.");
  }

  void restore(const std::string& path) override {
    std::ifstream file(path);
    std::string unit;
    if (!(file >> steps_ >> unit) || unit != "steps")
      throw StorageError("The file " + path + " cannot be read (missing or damaged). Choose another one.");
  }

  SolverSummary summarise() override {
    Digest digest;
    digest.add(steps_);
    return {digest.value(), 0, 1, {}};
  }

 private:
  inline static const Eigen::Vector3d kStream_m_per_s{1e-3, 0, 0};
  std::vector<Shape> bodies_;
  double viscosity_Pa_s_;
  std::uint64_t steps_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  const FluidComponent component{
      {"Uniform stream",
       "1.0",
       {"solver:external", "shape:sphere", "checkpoint", "snapshots", "imposes:flow", "neglects:boundary",
        "neglects:symmetry_planes", "neglects:fields"}},
      [](const FluidSetup& setup, SolverContext&) { return std::make_unique<UniformStream>(setup); }};
  return run_fluid_component(argc, argv, component);
}
