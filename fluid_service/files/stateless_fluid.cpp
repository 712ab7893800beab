#include "files/stateless_fluid.hpp"

#include <fstream>
#include <iterator>
#include <utility>

#include "contract/errors.hpp"
#include "system/durable_file.hpp"

namespace copepod::fluid {

namespace {

std::string checkpoint_text(const std::string& solver) { return "copepod " + solver + " checkpoint 1\n"; }

}  // namespace

StatelessFluid::StatelessFluid(std::string name, const FluidSetup& setup, const Communicator& communicator)
    : name_(std::move(name)),
      bodies_(static_cast<Eigen::Index>(setup.bodies.size())),
      rank_(communicator.rank()),
      ranks_(communicator.size()) {}

void StatelessFluid::save(const std::string& path) {
  if (rank_ == 0) write_durably(path, checkpoint_text(name_));
}

void StatelessFluid::restore(const std::string& path) {
  std::ifstream file(path);
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (text != checkpoint_text(name_))
    throw StorageError("checkpoint " + path + " is not one of a " + name_ +
                       " fluid (missing, damaged or of another solver). Use an earlier checkpoint.");
}

SolverSummary StatelessFluid::summarise() {
  SolverSummary summary;
  summary.ranks = ranks_;
  return summary;
}

void StatelessFluid::exchange(const Kinematics& kinematics, Loads& loads) {
  if (rank_ != 0) return;
  if (kinematics.bodies() != bodies_)
    throw SolverError("kinematics of " + std::to_string(kinematics.bodies()) + " bodies (the setup has " +
                          std::to_string(bodies_) + "). Send every body in the order of the setup.",
                      rank_, kinematics.step);
  loads.step = kinematics.step;
  loads.resize(bodies_);
  loads.force_N.setZero();
  loads.torque_N_m.setZero();
  add_loads(kinematics, loads);
}

}  // namespace copepod::fluid
