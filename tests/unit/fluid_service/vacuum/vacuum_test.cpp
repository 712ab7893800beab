#include <fstream>

#include <gtest/gtest.h>

#include "contract/errors.hpp"
#include "files/stateless_fluid.hpp"
#include "temporary_folder.hpp"

namespace copepod::fluid {
namespace {

class VacuumOfThreeBodies : public testing::Test {
 protected:
  VacuumOfThreeBodies() : vacuum_(setup_of_three_bodies(), ranks_) {}

  static FluidSetup setup_of_three_bodies() {
    FluidSetup setup;
    setup.kind = FluidKind::vacuum;
    setup.bodies.resize(3);
    return setup;
  }

  SolverContext context_;
  SelfCommunicator ranks_{context_};
  Vacuum vacuum_;
  TemporaryFolder folder_;
  std::string path_ = folder_.path("checkpoint");
};

TEST_F(VacuumOfThreeBodies, ExertsNoLoads) {
  Kinematics kinematics;
  kinematics.step = 17;
  kinematics.resize(3);
  kinematics.velocity_m_per_s.setConstant(2.0);
  Loads loads;
  loads.resize(1);
  loads.force_N.setConstant(9.0);
  vacuum_.exchange(kinematics, loads);
  EXPECT_EQ(loads.step, 17);
  EXPECT_EQ(loads.bodies(), 3);
  EXPECT_EQ(loads.force_N, Eigen::Matrix3Xd::Zero(3, 3));
  EXPECT_EQ(loads.torque_N_m, Eigen::Matrix3Xd::Zero(3, 3));
}

TEST_F(VacuumOfThreeBodies, RefusesKinematicsOfAnotherNumberOfBodies) {
  Kinematics kinematics;
  kinematics.step = 5;
  kinematics.resize(2);
  Loads loads;
  try {
    vacuum_.exchange(kinematics, loads);
    FAIL() << "accepted two bodies";
  } catch (const SolverError& error) {
    EXPECT_EQ(error.step(), 5);
  }
}

TEST_F(VacuumOfThreeBodies, RestoresWhatItSaved) {
  vacuum_.save(path_);
  Vacuum another(setup_of_three_bodies(), ranks_);
  EXPECT_NO_THROW(another.restore(path_));
}

TEST_F(VacuumOfThreeBodies, RefusesADamagedCheckpoint) {
  vacuum_.save(path_);
  std::ofstream(path_, std::ios::app) << "x";
  EXPECT_THROW(vacuum_.restore(path_), StorageError);
}

TEST_F(VacuumOfThreeBodies, ReportsAFolderThatIsNotThere) {
  EXPECT_THROW(vacuum_.save(folder_.path("no/such/folder/checkpoint")), StorageError);
}

}  // namespace
}  // namespace copepod::fluid
