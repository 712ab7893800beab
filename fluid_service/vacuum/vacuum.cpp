#include "vacuum/vacuum.hpp"

#include <fcntl.h>
#include <fstream>
#include <string>
#include <unistd.h>

#include "contract/errors.hpp"

namespace copepod::fluid {

namespace {

const std::string checkpoint_text = "copepod vacuum checkpoint 1\n";

}  // namespace

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
  if (rank_ != 0) return;
  const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  const auto size = static_cast<ssize_t>(checkpoint_text.size());
  const bool written = file >= 0 && write(file, checkpoint_text.data(), checkpoint_text.size()) == size;
  const bool synced = written && fsync(file) == 0;
  const bool closed = file >= 0 && close(file) == 0;
  if (!synced || !closed)
    throw StorageError("checkpoint " + path +
                       " cannot be written (disk full or no permission). Make room and resume.");
}

void Vacuum::restore(const std::string& path) {
  std::ifstream file(path);
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (text != checkpoint_text)
    throw StorageError(
        "checkpoint " + path +
        " is not one of a vacuum (missing, damaged or of another solver). Use an earlier checkpoint.");
}

SolverSummary Vacuum::summarise() {
  SolverSummary summary;
  summary.ranks = ranks_;
  return summary;
}

}  // namespace copepod::fluid
