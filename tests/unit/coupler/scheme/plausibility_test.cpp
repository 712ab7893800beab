#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "contract/errors.hpp"
#include "scheme/serial_explicit.hpp"

namespace copepod::coupler {
namespace {

/// Two spheres of 4 µm in a channel of 40 × 40 × 80 µm that is periodic along z.
class PlausibilityTest : public testing::Test {
 protected:
  PlausibilityTest() {
    fluid.cell_size_m = 1e-6;
    fluid.domain_cells = {40, 40, 80};
    fluid.boundaries[4].kind = fluid.boundaries[5].kind = BoundaryKind::periodic;
    for (const char* name : {"first", "second"}) {
      BodySpecification body;
      body.name = name;
      body.shape.radius_m = 4e-6;
      body.position_m = {20e-6, 20e-6, 20e-6 + 30e-6 * static_cast<double>(bodies.size())};
      bodies.push_back(body);
    }
    before.resize(2);
    before.step = 1234;
    before.velocity_m_per_s.setZero();
    before.angular_velocity_rad_per_s.setZero();
    for (Eigen::Index i = 0; i < 2; ++i) {
      before.position_m.col(i) = bodies[static_cast<std::size_t>(i)].position_m;
      before.orientation_wxyz.col(i) = Eigen::Vector4d(1, 0, 0, 0);
    }
    after = before;
    after.step = 1235;
  }

  void judge() const { Plausibility(fluid, bodies, largest_speed_m_per_s).judge(before, after); }

  /// The report of a motion that must not pass.
  [[nodiscard]] FailureReport report() const {
    try {
      judge();
    } catch (const PeerFailed& failure) {
      return failure.report();
    }
    ADD_FAILURE() << "the motion passed";
    return {};
  }

  FluidSetup fluid;
  std::vector<BodySpecification> bodies;
  double largest_speed_m_per_s = std::numeric_limits<double>::infinity();
  Kinematics before, after;
};

TEST_F(PlausibilityTest, LetsAMotionOfLessThanARadiusPass) {
  after.position_m.col(1).x() += 3.9e-6;
  EXPECT_NO_THROW(judge());
}

TEST_F(PlausibilityTest, BlamesTheBodyComponentForALeapAndNamesBodyStepAndDistance) {
  after.position_m.col(1).y() += 5e-6;
  const FailureReport failure = report();
  EXPECT_EQ(failure.code, ExitCode::solver_failed);
  EXPECT_EQ(failure.component, "body");
  EXPECT_EQ(failure.step, 1234);
  EXPECT_NE(failure.reason.find("In step 1234 body 'second' moved by 5 µm (more than its radius of 4 µm)"),
            std::string::npos)
      << failure.reason;
}

TEST_F(PlausibilityTest, EndsWhereABodyLeavesTheDomain) {
  before.position_m(0, 0) = 1e-6;
  after.position_m(0, 0) = -1e-6;
  const std::string reason = report().reason;
  EXPECT_NE(reason.find("'first' left the domain: x = -1 µm (the domain ends at 0 and 40 µm)"), std::string::npos)
      << reason;
  after.position_m(0, 0) = 1e-6;
  before.position_m(1, 0) = 39e-6;
  after.position_m(1, 0) = 41e-6;
  EXPECT_NE(report().reason.find("y = 41 µm"), std::string::npos) << report().reason;
}

TEST_F(PlausibilityTest, DoesNotJudgeBodiesBehindAFaceThatRemovesThem) {
  after.position_m.col(1).x() = 300e-6;
  EXPECT_EQ(report().code, ExitCode::solver_failed);
  fluid.boundaries[1] = {.kind = BoundaryKind::outflow, .removes_bodies = true};
  EXPECT_NO_THROW(judge());
  after.position_m.col(1).x() = -1e-6;  // the other face
  EXPECT_EQ(report().code, ExitCode::solver_failed);
  after.position_m.col(1) = Eigen::Vector3d(300e-6, std::numeric_limits<double>::quiet_NaN(), 0.0);
  EXPECT_EQ(report().code, ExitCode::solver_failed);
}

TEST_F(PlausibilityTest, LetsBodiesCrossPeriodicFacesFoldedBackOrNot) {
  before.position_m(2, 0) = 79e-6;
  after.position_m(2, 0) = 81e-6;
  EXPECT_NO_THROW(judge());
  after.position_m(2, 0) = 1e-6;
  EXPECT_NO_THROW(judge());
}

TEST_F(PlausibilityTest, KnowsNoFacesWithoutADomainAndForBodiesThatBeganOutside) {
  before.position_m(0, 0) = after.position_m(0, 0) = -50e-6;
  EXPECT_THROW(judge(), PeerFailed);
  bodies[0].position_m.x() = -50e-6;
  EXPECT_NO_THROW(judge());
  bodies[0].position_m.x() = 20e-6;
  fluid.domain_cells = {0, 0, 0};
  EXPECT_NO_THROW(judge());
}

TEST_F(PlausibilityTest, RefusesAnOrientationThatIsNotAUnitQuaternion) {
  after.orientation_wxyz.col(0) = Eigen::Vector4d(0.9, 0, 0, 0);
  EXPECT_NE(report().reason.find("'first' got an orientation of length 0.9"), std::string::npos) << report().reason;
}

TEST_F(PlausibilityTest, RefusesNumbersThatAreNotFinite) {
  after.position_m(2, 1) = std::nan("");
  EXPECT_NE(report().reason.find("'second' moved by nan"), std::string::npos) << report().reason;
  after.position_m(2, 1) = before.position_m(2, 1);
  after.orientation_wxyz(3, 1) = std::nan("");
  EXPECT_NE(report().reason.find("length nan"), std::string::npos) << report().reason;
  for (Eigen::Matrix3Xd* velocities : {&after.velocity_m_per_s, &after.angular_velocity_rad_per_s}) {
    after = before;
    (*velocities)(0, 1) = std::nan("");
    EXPECT_NE(report().reason.find("moves at nan"), std::string::npos) << report().reason;
    (*velocities)(0, 1) = std::numeric_limits<double>::infinity();
    EXPECT_NE(report().reason.find("moves at inf"), std::string::npos) << report().reason;
  }
}

TEST_F(PlausibilityTest, EndsWhereABodyTurnsByMoreThanARadian) {
  const auto turned = [](double angle_rad) {
    return Eigen::Vector4d(std::cos(0.5 * angle_rad), 0, 0, std::sin(0.5 * angle_rad));
  };
  for (const double angle_rad : {0.9, -0.9}) {
    after.orientation_wxyz.col(0) = turned(angle_rad);
    EXPECT_NO_THROW(judge());
    after.orientation_wxyz.col(0) = -turned(angle_rad);  // the same orientation
    EXPECT_NO_THROW(judge());
  }
  after.orientation_wxyz.col(0) = turned(1.1);
  EXPECT_NE(report().reason.find("'first' turned by more than one radian"), std::string::npos) << report().reason;
}

TEST_F(PlausibilityTest, EndsWhereASurfaceIsFasterThanTheFluidCanFollow) {
  largest_speed_m_per_s = 0.4;
  after.velocity_m_per_s(1, 1) = 0.2;
  after.angular_velocity_rad_per_s(2, 1) = 0.19 / 4e-6;
  EXPECT_NO_THROW(judge());
  bodies[1].shape.kind = ShapeKind::capsule;
  bodies[1].shape.length_m = 1e-6;
  EXPECT_NE(report().reason.find("'second' has a surface that moves at 0.4138 m/s (the fluid follows up to 0.4 m/s"),
            std::string::npos)
      << report().reason;
  largest_speed_m_per_s = std::numeric_limits<double>::infinity();
  EXPECT_NO_THROW(judge());
}

}  // namespace
}  // namespace copepod::coupler
