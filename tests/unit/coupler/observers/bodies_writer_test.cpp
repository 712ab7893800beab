#include "observers/bodies_writer.hpp"

#include <filesystem>
#include <fstream>
#include <set>

#include <gtest/gtest.h>

#include "contract/errors.hpp"
#include "geometry/rotation.hpp"
#include "temporary_folder.hpp"

namespace copepod::coupler {
namespace {

/// A ball at 0.75 m along every axis, moved by a metre along x with every step.
class BodiesFile : public testing::Test {
 protected:
  BodiesFile() {
    bodies_.resize(1);
    bodies_[0].name = "ball";
    bodies_[0].shape = {ShapeKind::sphere, 0.125, 0.0};
    kinematics_.resize(1);
    kinematics_.position_m.setConstant(0.75);
    kinematics_.orientation_wxyz.col(0) << 1, 0, 0, 0;
    kinematics_.velocity_m_per_s.setZero();
    kinematics_.angular_velocity_rad_per_s.setZero();
    loads_.resize(1);
    loads_.force_N.setZero();
    loads_.torque_N_m.setZero();
  }

  /// Steps from `first` up to, but not including, `stop`; the last of the run is `steps`.
  void run(std::int64_t first, std::int64_t stop, std::int64_t steps = 10) {
    BodiesWriter writer(path_, bodies_, 0.5, periodic_length_m_, 4, first);
    for (std::int64_t step = first; step < stop; ++step) writer.observe(record(step));
    if (stop == steps) writer.finish(record(steps));
  }
  StepRecord record(std::int64_t step) {
    kinematics_.step = step;
    kinematics_.position_m(0, 0) = 0.75 + static_cast<double>(step);
    return {step, kinematics_, loads_, loads_, loads_, loads_};
  }
  [[nodiscard]] std::set<std::string> frames() const {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path("bodies")))
      names.insert(entry.path().filename().string());
    return names;
  }
  [[nodiscard]] std::string frame_path(const std::string& name) const { return folder_.path("bodies") + "/" + name; }
  [[nodiscard]] std::string list() const { return content_of(path_.string()); }
  [[nodiscard]] Eigen::Matrix3Xf points_in(const std::string& frame) const {
    const std::string text = content_of(frame_path(frame));
    const std::size_t element = text.find("Name=\"points\"");
    const std::size_t offset = std::stoul(text.substr(text.find("offset=\"", element) + 8));
    const std::size_t start = text.find("\n_") + 2 + offset;
    std::uint64_t bytes = 0;
    text.copy(reinterpret_cast<char*>(&bytes), sizeof bytes, start);
    Eigen::Matrix3Xf points(3, bytes / 12);
    text.copy(reinterpret_cast<char*>(points.data()), bytes, start + sizeof bytes);
    return points;
  }
  [[nodiscard]] Eigen::Vector3f center_in(const std::string& frame) const { return points_in(frame).rowwise().mean(); }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_.path("bodies.pvd");
  std::vector<BodySpecification> bodies_;
  std::array<double, 3> periodic_length_m_{};
  Kinematics kinematics_;
  Loads loads_;
};

TEST_F(BodiesFile, HaveAFrameOfTheFirstTheLastAndEveryFourthStepWithItsTime) {
  run(0, 10);
  EXPECT_EQ(frames(), (std::set<std::string>{"step_000000000.vtp", "step_000000004.vtp", "step_000000008.vtp",
                                             "step_000000010.vtp"}));
  EXPECT_NE(list().find("<DataSet timestep=\"5\" file=\"bodies/step_000000010.vtp\"/>"), std::string::npos) << list();
  EXPECT_TRUE(center_in("step_000000004.vtp").isApprox(Eigen::Vector3f(4.75F, 0.75F, 0.75F), 1e-6F));
}

TEST_F(BodiesFile, AreTurnedAsTheirQuaternionsSay) {
  bodies_[0].shape = {ShapeKind::capsule, 0.125, 1.0};
  kinematics_.orientation_wxyz.col(0) << 0.5, 0.1, 0.7, 0.5;  // a unit vector
  run(0, 1);
  const Eigen::Vector3f axis = z_axis(kinematics_.orientation_wxyz.col(0)).cast<float>();
  const Eigen::Matrix3Xf arms = points_in("step_000000000.vtp").colwise() - Eigen::Vector3f(0.75F, 0.75F, 0.75F);
  EXPECT_TRUE(arms.col(0).isApprox(0.625F * axis, 1e-5F)) << "the upper pole comes first";
  EXPECT_NEAR((axis.transpose() * arms).maxCoeff(), 0.625F, 1e-6F);
}

TEST_F(BodiesFile, OfAResumedRunContinueThoseBeforeItsFirstStep) {
  run(0, 10);
  const std::string undisturbed = list();
  std::filesystem::remove(frame_path("step_000000004.vtp"));
  std::ofstream(frame_path("step_000000004.vtp")) << "kept";
  run(5, 10);
  EXPECT_EQ(list(), undisturbed);
  EXPECT_EQ(content_of(frame_path("step_000000004.vtp")), "kept");
  run(5, 8);  // lost before its end
  EXPECT_EQ(frames(), (std::set<std::string>{"step_000000000.vtp", "step_000000004.vtp"}));
}

TEST_F(BodiesFile, OfANewRunReplaceThoseOfAnOlderOne) {
  run(0, 10);
  run(0, 3);
  EXPECT_EQ(frames(), std::set<std::string>{"step_000000000.vtp"});
  EXPECT_EQ(list().find("step_000000008"), std::string::npos);
}

TEST_F(BodiesFile, AreFoldedBackIntoAPeriodicDomain) {
  periodic_length_m_ = {2.0, 0.0, 2.0};
  run(0, 10);
  EXPECT_TRUE(center_in("step_000000004.vtp").isApprox(Eigen::Vector3f(0.75F, 0.75F, 0.75F), 1e-6F));
}

TEST_F(BodiesFile, ThatCannotBeWrittenAreAStorageError) {
  std::ofstream(folder_.path("bodies")) << "in the way";
  EXPECT_THROW(run(0, 1), StorageError);
}

}  // namespace
}  // namespace copepod::coupler
