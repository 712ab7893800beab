#include "vacuum/vacuum.hpp"

#include <string>

#include "contract/errors.hpp"
#include "files/stateless_checkpoint.hpp"

namespace copepod::fluid {

Vacuum::Vacuum(const FluidSetup& setup, const Communicator& communicator)
    : bodies_(static_cast<Eigen::Index>(setup.bodies.size())),
      rank_(communicator.rank()),
      ranks_(communicator.size()) {}

void Vacuum::exchange(const Kinematics& kinematics, Loads& loads) {
  if (kinematics.bodies() != bodies_)
    throw SolverError("kinematics of " + std::to_string(kinematics.bodies()) + " bodies (the setup has " +
                          std::to_string(bodies_) + "). Send every body in the order of the setup.",
                      rank_, kinematics.step);
  loads.resize(bodies_);
  loads.force_N.setZero();
  loads.torque_N_m.setZero();
  loads.step = kinematics.step;
}

void Vacuum::save(const std::string& path) {
  if (rank_ == 0) save_stateless(path, "vacuum");
}

void Vacuum::restore(const std::string& path) { restore_stateless(path, "vacuum"); }

SolverSummary Vacuum::summarise() {
  SolverSummary summary;
  summary.ranks = ranks_;
  return summary;
}

}  // namespace copepod::fluid
