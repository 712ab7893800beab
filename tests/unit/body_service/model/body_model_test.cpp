#include "model/body_model.hpp"

#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "body_cases.hpp"
#include "contract/errors.hpp"

namespace copepod::body {
namespace {

std::string refusal(const std::function<void(BodySpecification&)>& spoil) {
  BodySpecification body = capsule("odd one", {0, 0, 0});
  spoil(body);
  return reason_of<CaseError>([&] { const BodyModel model(setup_of({body}, 1e-9)); });
}

TEST(BodyModel, NamesTheBodyAndTheProblemOfAnImpossibleBody) {
  EXPECT_TRUE(contains(refusal([](auto& body) { body.mass_kg = 0.0; }), "body 'odd one': mass_kg"));
  EXPECT_TRUE(
      contains(refusal([](auto& body) { body.mass_kg = std::numeric_limits<double>::quiet_NaN(); }), "mass_kg"));
  EXPECT_TRUE(contains(refusal([](auto& body) { body.shape.radius_m = -1.0; }), "radius_m"));
  EXPECT_TRUE(contains(refusal([](auto& body) { body.shape.length_m = -1.0; }), "length_m"));
  EXPECT_TRUE(contains(refusal([](auto& body) { body.orientation_wxyz = {1, 1, 0, 0}; }), "orientation_wxyz"));
  EXPECT_TRUE(contains(refusal([](auto& body) { body.orientation_wxyz.setConstant(std::nan("")); }), "orientation"));
  EXPECT_TRUE(contains(refusal([](auto& body) { body.position_m[1] = std::nan(""); }), "not finite"));
}

TEST(BodyModel, GivesBackTheAngularVelocityItWasGiven) {
  BodySpecification body = capsule("a", {0, 0, 0});
  body.orientation_wxyz = Eigen::Vector4d(0.3, -0.5, 0.7, 0.4).normalized();
  body.angular_velocity_rad_per_s = {1.0, -2.0, 3.0};
  const BodyModel model(setup_of({body}, 1e-9));
  const MotionState& state = model.initial_state();
  const Eigen::Vector3d w =
      model.angular_velocity_rad_per_s(0, state.orientation_wxyz.col(0), state.angular_momentum_N_m_s.col(0));
  EXPECT_TRUE(w.isApprox(body.angular_velocity_rad_per_s, 1e-14));
}

TEST(BodyModel, GivesAFreeCapsuleTheAngularMomentumOfItsFullTensor) {
  BodySpecification body = capsule("a", {0, 0, 0});
  body.orientation_wxyz = {std::sqrt(0.5), std::sqrt(0.5), 0, 0};  // axis along −y
  body.angular_velocity_rad_per_s = {1.0, 1.0, 0.0};
  const BodyModel model(setup_of({body}, 1e-9));
  const Eigen::Matrix3d inertia = inertia_tensor_kg_m2(body.shape, body.mass_kg);
  const Eigen::Vector3d expected(inertia(0, 0), inertia(2, 2), 0.0);
  EXPECT_TRUE(model.initial_state().angular_momentum_N_m_s.col(0).isApprox(expected, 1e-14));
}

}  // namespace
}  // namespace copepod::body
