#include <cmath>
#include <filesystem>
#include <mujoco/mujoco.h>
#include <set>
#include <unistd.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "body_cases.hpp"
#include "contract/errors.hpp"
#include "engine/engine_under_test.hpp"
#include "mujoco/mujoco_world.hpp"

namespace copepod::body {
namespace {

constexpr double micrometre = 1e-6;
constexpr double short_step_s = 2e-9;

ModelSpecification model_of(const std::string& bodies, const std::string& others = "") {
  return {"<mujoco><worldbody>" + bodies + "</worldbody>" + others + "</mujoco>", micrometre, 1e-15, 1e-6};
}

BodySetup setup_of_model(const ModelSpecification& model) {
  BodySetup setup = setup_of({}, short_step_s);
  setup.model = model;
  for (const ModelBody& body : bodies_of(*compiled(model.text), model)) setup.bodies.push_back(body.body);
  return setup;
}

/// Two balls, one four times as heavy as the other, on one rigid body.
const std::string dumbbell = R"(<body pos="0 0 50"><freejoint/>
  <geom name="heavy" type="sphere" size="2" pos="-4 0 0" density="4"/><geom name="light" type="sphere" size="2" pos="4 0 0" density="1"/>
</body>)";

/// A hinge that a servo motor turns; its position filter has a state.
const std::string servo = R"(<body><geom name="arm" type="capsule" fromto="0 0 0 8 0 0" size="1" density="1"/>
  <joint name="hinge" axis="0 1 0" damping="2000"/></body>)";
const std::string motor = R"(<actuator><general name="motor" joint="hinge" dyntype="filter" dynprm="0.5"
  gainprm="4000" biastype="affine" biasprm="0 -4000 0"/></actuator>)";

BodySetup driven_arm() {
  BodySetup setup = setup_of_model(model_of(servo, motor));
  ActuatorSpecification& actuator = setup.actuators.emplace_back();
  actuator.kind = ActuatorKind::control;
  actuator.control = "motor";
  return setup;
}

void control_of_half_a_radian(AppliedLoads& applied) { applied.actuation.setConstant(0.5); }

TEST(ModelBodies, AreItsSpheresAndCapsulesInPlace) {
  const ModelSpecification model = model_of(R"(<geom type="plane" size="0 0 1"/>
    <geom name="rock" type="sphere" size="3" pos="20 0 3"/>
    <body pos="0 0 30"><freejoint/><geom type="capsule" fromto="1 2 3 1 2 9" size="2" density="1"/></body>)");
  const BodySetup setup = setup_of_model(model);
  ASSERT_EQ(setup.bodies.size(), 2U);
  const BodySpecification& rock = setup.bodies[0];
  EXPECT_EQ(rock.name, "rock");
  EXPECT_EQ(rock.motion, MotionKind::fixed);
  EXPECT_DOUBLE_EQ(rock.shape.radius_m, 3e-6);
  const BodySpecification& capsule = setup.bodies[1];
  EXPECT_EQ(capsule.name, "geom_2");
  EXPECT_EQ(capsule.motion, MotionKind::free);
  EXPECT_DOUBLE_EQ(capsule.shape.radius_m, 2e-6);
  EXPECT_DOUBLE_EQ(capsule.shape.length_m, 6e-6);
  EXPECT_LT((capsule.position_m - Eigen::Vector3d(1e-6, 2e-6, 36e-6)).norm(), 1e-18);
  EXPECT_NEAR(capsule.mass_kg, 1000.0 * volume_m3(capsule.shape), 1e-9 * capsule.mass_kg);
}

TEST(ModelBodies, OfOneRigidBodyShareItsMassByVolumeAndMayOverlap) {
  const auto found = nlohmann::json::parse(bodies_as_json(model_of(
      R"(<body><freejoint/><site name="end"/><geom name="a" type="sphere" size="2" density="1"/>
         <geom name="b" type="sphere" size="1" density="1"/>
         <body pos="9 0 0"><joint/><geom name="c" type="sphere" size="2" density="1"/>
           <body pos="9 0 0"><joint/><geom name="d" type="sphere" size="2" density="1"/></body></body></body>)",
      R"(<actuator><motor name="screw" site="end"/></actuator>)")));
  std::set<std::string> pairs;
  for (const auto& joint : found.at("joints")) pairs.insert(joint.at("name"));
  EXPECT_EQ(pairs, (std::set<std::string>{"a and b", "a and c", "b and c", "c and d"}));
  EXPECT_NEAR(double(found["bodies"][0]["mass_kg"]) / double(found["bodies"][1]["mass_kg"]), 8.0, 1e-9);
  EXPECT_EQ(found.at("controls"), nlohmann::json({"screw"}));
}

TEST(ModelBodies, RefuseWhatTheFluidCannotHaveOrTheCaseWouldLack) {
  const auto reason = [](const ModelSpecification& model) {
    return reason_of<CaseError>([&] { bodies_as_json(model); });
  };
  EXPECT_TRUE(contains(reason(model_of(R"(<geom name="brick" type="box" size="1 1 1"/>)")), "'brick' is neither"));
  EXPECT_TRUE(contains(reason(model_of("")), "no sphere and no capsule"));
  EXPECT_TRUE(contains(reason(model_of("", R"(<asset><texture file="x.png"/></asset>)")), "reads other files"));
  EXPECT_TRUE(contains(reason(model_of("", R"(<include\n  file = 'x.xml'/>)")), "reads other files"));
  EXPECT_TRUE(contains(reason({"", 1, 1, 1}), "empty"));
  EXPECT_TRUE(contains(reason({"<mujoco><nonsense/></mujoco>", 1, 1, 1}), "nonsense"));
}

TEST(ModelBodies, MustBeThoseOfTheCase) {
  BodySetup heavier = setup_of_model(model_of(dumbbell));
  heavier.bodies[1].mass_kg *= 1.001;
  EXPECT_TRUE(contains(reason_of<CaseError>([&] { engine_solver(heavier); }), "body 'light' is not 'light'"));
  BodySetup fewer = setup_of_model(model_of(dumbbell));
  fewer.bodies.pop_back();
  EXPECT_TRUE(contains(reason_of<CaseError>([&] { engine_solver(fewer); }), "1 bodies, its model 2"));
  BodySetup nameless = driven_arm();
  nameless.actuators[0].control = "engine";
  EXPECT_TRUE(contains(reason_of<CaseError>([&] { engine_solver(nameless); }), "'engine' (the model has no actuator"));
}

// Weight acts on the true centre of mass, which shares by volume would put in the middle; buoyancy acts on volumes.
TEST(ModelBodies, FallTogetherAndTurnOnlyByBuoyancy) {
  constexpr std::int64_t steps = 1000;
  BodySetup setup = setup_of_model(model_of(dumbbell));
  setup.gravity_m_per_s2 = {0, 0, -1e6};
  EngineBodySolver solver = engine_solver(setup);
  const Kinematics fallen = advance(solver, steps);
  const double time_s = short_step_s * steps;
  const double way_m = 0.5 * 1e6 * time_s * time_s * (1.0 + 1.0 / steps);  // semi-implicit Euler
  for (Eigen::Index body : {0, 1}) {
    const Eigen::Vector3d start_m = setup.bodies[static_cast<std::size_t>(body)].position_m;
    EXPECT_LT((fallen.position_m.col(body) - start_m + Eigen::Vector3d(0, 0, way_m)).norm(), 1e-9 * way_m);
  }

  // About the centre of mass, 2.4 µm from the middle: torque ρ 2V g a on the inertia of both.
  setup.fluid_density_kg_per_m3 = 1000.0;
  EngineBodySolver floating = engine_solver(setup);
  const Kinematics turned = advance(floating, steps / 10);
  const double ball_m3 = volume_m3(setup.bodies[0].shape);
  constexpr double off_middle_m = 2.4e-6;
  const double heavy_kg = 4000.0 * ball_m3;
  const double light_kg = 1000.0 * ball_m3;
  const double inertia = (heavy_kg + light_kg) * 0.4 * 4e-12 + heavy_kg * 1.6e-6 * 1.6e-6 + light_kg * 6.4e-6 * 6.4e-6;
  const double expected_per_s = 1000.0 * 2.0 * ball_m3 * 1e6 * off_middle_m / inertia * (0.1 * time_s);
  EXPECT_NEAR(turned.angular_velocity_rad_per_s(1, 0), -expected_per_s, 1e-3 * expected_per_s);
}

/// A pendulum of two links with a spring, friction, a limit, an equality and a motor, where options show.
ModelSpecification pendulum_with(const std::string& options) {
  ModelSpecification model = model_of(
      R"(<body><geom name="upper" type="capsule" fromto="0 0 0 8 0 0" size="1" density="1"/>
           <joint name="shoulder" axis="0 1 0" limited="true" range="-5 5"/>
           <body pos="8 0 0"><geom name="lower" type="capsule" fromto="1 0 0 8 0 1" size="1.5" density="1"/>
             <joint name="elbow" axis="0 1 0" damping="100" stiffness="50" armature="30" frictionloss="20"/></body></body>
         <body pos="0 9 0"><geom name="other" type="sphere" size="1" density="1"/><joint name="slide" type="slide"/></body>)",
      R"(<actuator><motor name="motor" joint="elbow" gear="900" ctrllimited="true" ctrlrange="-0.1 0.1"/></actuator>
         <equality><joint joint1="slide" joint2="shoulder"/></equality>)" +
          options);
  return model;
}

constexpr int option_steps = 300;
const Eigen::Vector3d option_gravity_m_per_s2(0, 0, -9.81e6);  // 9.81 in units of the model

/// Places of the bodies [m], and what the pendulum's are in MuJoCo alone.
Eigen::Matrix3Xd moved(const std::string& options) {
  BodySetup setup = setup_of_model(pendulum_with(options));
  setup.gravity_m_per_s2 = option_gravity_m_per_s2;
  setup.actuators.emplace_back().kind = ActuatorKind::control;
  setup.actuators.back().control = "motor";
  EngineBodySolver solver = engine_solver(setup);
  return advance(solver, option_steps, control_of_half_a_radian, 1).position_m;
}

Eigen::Matrix3Xd moved_by_mujoco_alone(const std::string& options) {
  const MujocoModel model = compiled(pendulum_with(options).text);
  model->opt.solver = mjSOL_NEWTON;
  model->opt.tolerance = 0.0;
  model->opt.iterations = 50;
  model->opt.disableflags |= mjDSBL_WARMSTART;
  const MujocoData data = new_data(*model);
  data->ctrl[0] = 0.5;
  for (int step = 0; step < option_steps; ++step) mj_step(model.get(), data.get());
  mj_kinematics(model.get(), data.get());
  return micrometre * Eigen::Map<const Eigen::Matrix3Xd>(data->geom_xpos, 3, model->ngeom);
}

TEST(ModelBodies, MoveInTheFluidAndTheGravityOfTheCaseAlone) {
  const Eigen::Matrix3Xd expected = moved("");
  for (const std::string option :
       {R"(density="2000" viscosity="30")", R"(viscosity="9" wind="100 0 0")", R"(gravity="0 5 0" timestep="0.1")",
        R"(solver="PGS" iterations="1")", R"(solver="CG" tolerance="0.1")",
        R"(apirate="7" mpr_tolerance="1" mpr_iterations="1" magnetic="1 2 3")"}) {
    EXPECT_EQ(moved("<option " + option + "/>"), expected) << option;
  }
  for (const std::string flag :
       {R"(gravity="disable")", R"(warmstart="enable")", R"(energy="enable")", R"(fwdinv="enable")",
        R"(sensor="disable")", R"(sensornoise="enable")", R"(multiccd="enable")", R"(refsafe="disable")"}) {
    EXPECT_LT((moved("<option><flag " + flag + "/></option>") - expected).norm(), 1e-9 * micrometre) << flag;
  }
  EXPECT_EQ(moved(R"(<statistic meaninertia="1e9" extent="3"/><size nkey="2" nuser_geom="3"/><custom>
                     <numeric name="n" data="1"/></custom><keyframe><key qpos="1 1 1"/></keyframe>)"),
            expected);
}

TEST(ModelBodies, KeepTheOptionsOfTheirJointsAsInMujocoAlone) {
  const Eigen::Matrix3Xd usual = moved("");
  for (const std::string options :
       {R"(<flag equality="disable"/>)", R"(<flag frictionloss="disable"/>)", R"(<flag limit="disable"/>)",
        R"(<flag passive="disable"/>)", R"(<flag clampctrl="disable"/>)", R"(<flag filterparent="disable"/>)"}) {
    const std::string text = "<option>" + options + "</option>";
    EXPECT_LT((moved(text) - moved_by_mujoco_alone(text)).norm(), 1e-9 * micrometre) << options;
    EXPECT_GT((moved(text) - usual).norm(), 1e-3 * micrometre) << options;
  }
  for (const std::string options : {R"(<option integrator="implicit"/>)", R"(<option cone="elliptic" impratio="10"/>)",
                                    R"(<option noslip_iterations="3"/>)", R"(<compiler settotalmass="500"/>)",
                                    R"(<compiler boundmass="200"/>)", R"(<compiler boundinertia="9000"/>)"})
    EXPECT_LT((moved(options) - moved_by_mujoco_alone(options)).norm(), 1e-9 * micrometre) << options;
  EXPECT_LT((moved(R"(<option integrator="implicit"/>)") - usual).norm(), 0.02 * micrometre);
}

TEST(ModelBodies, RefuseOptionsThatUndoWhatTheCaseAsksFor) {
  for (const auto& [options, reason] : std::vector<std::pair<std::string, std::string>>{
           {R"(<option integrator="RK4"/>)", "integrator is RK4"},
           {R"(<option collision="predefined"/>)", "collision is not all"},
           {R"(<option collision="dynamic"/>)", "collision is not all"},
           {R"(<option><flag contact="disable"/></option>)", "flag contact is disabled"},
           {R"(<option><flag constraint="disable"/></option>)", "flag constraint is disabled"},
           {R"(<option><flag actuation="disable"/></option>)", "flag actuation is disabled"},
           {R"(<option><flag override="enable"/></option>)", "flag override is enabled"},
           {R"(<actuator><general joint="elbow" dyntype="user"/></actuator>)", "type of an actuator is user"},
           {R"(<actuator><general joint="elbow" biastype="user"/></actuator>)", "type of an actuator is user"},
           {R"(<option gravcomp="1"/>)", "gravcomp"},
           {R"(<extension/>)", "extension"}}) {
    const ModelSpecification model = pendulum_with(options);
    EXPECT_TRUE(contains(reason_of<CaseError>([&] { bodies_as_json(model); }), reason)) << options;
    EXPECT_TRUE(contains(reason_of<CaseError>([&] { setup_of_model(model); }), reason)) << options;
  }
}

// A model's defaults and masks hold for its own geoms.
TEST(ModelBodies, MeetTheWallsOfTheCaseWhateverTheirMasksAre) {
  const auto fall = [](const std::string& defaults) {
    BodySetup setup = setup_of_model(model_of(R"(<body pos="0 0 3"><freejoint/>
      <geom name="ball" type="sphere" size="2" density="1"/></body>)",
                                              "<default><geom " + defaults + "/></default>"));
    setup.walls.push_back({{0, 0, 0}, {0, 0, 1}});
    setup.gravity_m_per_s2 = option_gravity_m_per_s2;
    EngineBodySolver solver = engine_solver(setup);
    return advance(solver, 1000).position_m(2, 0);
  };
  const double lying_m = fall("");
  EXPECT_NEAR(lying_m, 2e-6, 0.02e-6);
  for (const std::string defaults : {R"(contype="2" conaffinity="4")", R"(contype="0")", R"(conaffinity="0")"})
    EXPECT_EQ(fall(defaults), lying_m) << defaults;
  EXPECT_TRUE(contains(reason_of<CaseError>([&] { fall(R"(contype="0" conaffinity="0")"); }), "'ball' meets no wall"));
}

TEST(ModelBodies, MayOverlapWhereMasksOrFlagsLetThem) {
  const auto pairs = [](const std::string& mask, const std::string& others = "") {
    const ModelSpecification model = model_of(
        R"(<body><joint/><geom name="a" type="sphere" size="2" density="1"/><body pos="9 0 0"><joint/>
             <geom name="b" type="sphere" size="2" density="1"/></body></body>
           <body pos="0 9 0"><joint/><geom name="c" type="sphere" size="2" density="1" )" +
            mask + "/></body>",
        others);
    std::set<std::string> names;
    const auto found = nlohmann::json::parse(bodies_as_json(model));
    for (const auto& joint : found.at("joints")) names.insert(joint.at("name"));
    return names;
  };
  EXPECT_EQ(pairs(""), std::set<std::string>{"a and b"});
  EXPECT_EQ(pairs(R"(contype="2" conaffinity="2")"), (std::set<std::string>{"a and b", "a and c", "b and c"}));
  EXPECT_EQ(pairs(R"(contype="2" conaffinity="1")"), std::set<std::string>{"a and b"});
  EXPECT_EQ(pairs("", R"(<option><flag filterparent="disable"/></option>)"), std::set<std::string>{});
}

TEST(ModelBodies, FollowTheControlsOfTheCase) {
  EngineBodySolver solver = engine_solver(driven_arm());
  const Kinematics state = advance(solver, 20000, control_of_half_a_radian, 1);
  const Eigen::Vector3d middle_m(4e-6 * std::cos(0.5), 0.0, -4e-6 * std::sin(0.5));
  EXPECT_LT((state.position_m.col(0) - middle_m).norm(), 1e-6 * 4e-6);
}

TEST(ModelBodies, ContinueBitForBitAfterARestartWithTheStatesOfTheirActuators) {
  const auto file = std::filesystem::temp_directory_path() / ("model_restart_" + std::to_string(::getpid()));
  EngineBodySolver whole = engine_solver(driven_arm());
  advance(whole, 100, control_of_half_a_radian, 1);
  whole.save(file);
  EngineBodySolver resumed = engine_solver(driven_arm());
  resumed.restore(file);
  EXPECT_EQ(advance(whole, 100, control_of_half_a_radian, 1).position_m,
            advance(resumed, 100, control_of_half_a_radian, 1).position_m);
  EXPECT_EQ(whole.summarise().digest, resumed.summarise().digest);
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace copepod::body
