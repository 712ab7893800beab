#include "config/load_case.hpp"

#include <fstream>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "config/sections/sections.hpp"
#include "config/setups.hpp"
#include "config/yaml/document.hpp"
#include "contract/errors.hpp"
#include "temporary_folder.hpp"

namespace copepod::coupler {
namespace {

const std::string only_round_bodies =
    "bodies=[{name: ball, radius_m: 2.0e-6, mass_kg: 5.0e-13, position_m: [8.0e-6, 25.0e-6, 20.0e-6]}]";

LoadedCase with_every_key(const std::vector<std::string>& overrides = {}) {
  return load_case(std::string(CONFIG_TESTS) + "/every_key.yaml", overrides);
}

TEST(Step, FollowsFromTheRelaxationTimeAndBack) {
  // The paper's parameters: τ = 2/3, Δx = 1 µm, ν = 7.36e-5 m²/s give 7.5483e-10 s.
  const double step_s = step_from_relaxation_time(2.0 / 3.0, 1e-6, 7.36e-5);
  EXPECT_NEAR(step_s, 7.54831e-10, 1e-15);
  EXPECT_NEAR(relaxation_time_from_step(step_s, 1e-6, 7.36e-5), 2.0 / 3.0, 1e-15);
}

TEST(Run, HasAsManyStepsAsItsCyclesIfItEndsOnceItIsPeriodic) {
  const auto steps = [](const std::string& run) { return with_every_key({"sweep=null", "run=" + run}).content.steps; };
  EXPECT_EQ(steps("{until_periodic: {cycles: 5}}"), 5 * 4000);  // of the longest period, that of the swimmers
  EXPECT_EQ(steps("{until_periodic: {cycles: 5}, steps: 15000}"), 15000);
  EXPECT_EQ(steps("{until_periodic: {cycles: 5}, steps: 30000}"), 5 * 4000);
  EXPECT_EQ(steps("{until_periodic: {}, steps: 30000}"), 30000);
  EXPECT_EQ(steps("{until_periodic: {cycles: 900000000000000}}"), 1'000'000'000'000);
  const LoadedCase groups =
      with_every_key({"sweep=null", "groups.0.period_steps=7000", "run={until_periodic: {cycles: 2}}"});
  EXPECT_EQ(groups.content.steps, 14000);
  EXPECT_EQ(load_case_text(to_yaml(resolved(groups.content)), "again.yaml", {}).content.steps, 14000);
}

TEST(Run, MustGiveItsStepsIfNoCyclesDo) {
  const std::string still = "case: still\nfluid: {solver: vacuum}\nstep_s: 1.0e-6\n";
  for (const std::string run : {"{until_periodic: {cycles: 5}}", "{until_periodic: {}}", "{}"}) {
    try {
      load_case_text(still + "run: " + run, "case.yaml", {});
      ADD_FAILURE() << run;
    } catch (const CaseInvalid& error) {
      EXPECT_NE(error.lines()[0].find("run.steps is missing"), std::string::npos) << error.what();
    }
  }
}

TEST(Coefficients, AreAlongTheInflowAndOfTheSecondHalfUnlessTheCaseGivesOthers) {
  const std::string given = "output.coefficients=[{of: ball, speed_m_per_s: 1, area_m2: 1, length_m: 1}]";
  const auto found = [&](const std::string& faces) {
    return with_every_key({given, "fluid.boundaries.z=" + faces}).content.output.coefficients[0];
  };
  const Coefficients at_rest = found("no_slip"),
                     suction = found("{low: {velocity_m_per_s: [0, 0, -0.1]}, high: outflow}");
  EXPECT_EQ(at_rest.drag_axis, Eigen::Vector3d::UnitX());
  EXPECT_EQ(at_rest.lift_axis, Eigen::Vector3d::UnitY());
  EXPECT_EQ(at_rest.from_step, 7500);
  EXPECT_EQ(suction.drag_axis, -Eigen::Vector3d::UnitZ());
  EXPECT_EQ(suction.lift_axis, -Eigen::Vector3d::UnitX());
}

TEST(Coefficients, BelongToTheCaseThatARunIsContinuedWithButNotTheStepThatTheyStartAt) {
  const std::string key = case_key(with_every_key().content);
  EXPECT_EQ(case_key(with_every_key({"output.coefficients.0.from_step=9000"}).content), key);
  EXPECT_EQ(case_key(with_every_key({"output.trajectory.every_steps=10"}).content), key);
  EXPECT_NE(case_key(with_every_key({"output.coefficients.0.area_m2=1.0e-11"}).content), key);
}

TEST(FluidSetup, CarriesEverythingThatTheCaseSays) {
  const LoadedCase loaded = with_every_key();
  const FluidSetup setup = make_fluid_setup(loaded.content, loaded.assembly, "/somewhere");
  EXPECT_EQ(setup.kind, FluidKind::lattice_boltzmann);
  EXPECT_EQ(setup.step_s, loaded.content.step_s);
  EXPECT_EQ(setup.domain_cells, (std::array<std::int64_t, 3>{48, 50, 96}));
  EXPECT_EQ(setup.boundaries[0].kind, BoundaryKind::no_slip);
  EXPECT_EQ(setup.boundaries[1].velocity_m_per_s, Eigen::Vector3d(0, 0, 1));
  EXPECT_EQ(setup.boundaries[2].kind, BoundaryKind::velocity);
  EXPECT_EQ(setup.boundaries[4].pressure_Pa, 1.0);
  EXPECT_EQ(setup.symmetry_planes, (std::array<bool, 3>{false, true, false}));
  EXPECT_EQ(setup.body_force_N_per_m3, Eigen::Vector3d(0, 0, 0.25));
  EXPECT_EQ(setup.collision, CollisionKind::central_moments);
  EXPECT_EQ(setup.precision, Precision::single_precision);
  ASSERT_EQ(setup.bodies.size(), 11U);
  EXPECT_EQ(setup.bodies[7].extents_m, Eigen::Vector3d(1e-6, 2e-6, 3e-6));
  ASSERT_EQ(setup.obstacles.size(), 1U);
  EXPECT_EQ(setup.obstacles[0].name, "step");
  EXPECT_EQ(setup.bodies[1].kind, ShapeKind::capsule);
  EXPECT_EQ(setup.fields.directory, "/somewhere");
  EXPECT_EQ(setup.fields.every_steps, 1000);
  EXPECT_EQ(setup.fields.mean_start, 8000);
  EXPECT_EQ(setup.fields.mean_stop, 12000);
  EXPECT_EQ(setup.fields.mean_every_steps, 10);
}

TEST(Case, OfOlderVersionsIsReadUnlessItHasForces) {
  const TemporaryFolder folder;
  const std::string path = folder.path("case.yaml");
  std::ifstream present(std::string(CONFIG_TESTS) + "/every_key.yaml");
  std::ofstream(path) << present.rdbuf() << "\nforces: []\n";
  EXPECT_EQ(load_case(path, {}).assembly.bodies.size(), 11U);
}

TEST(BodySetup, CarriesEverythingThatTheCaseSays) {
  const LoadedCase loaded = with_every_key();
  const BodySetup setup = make_body_setup(loaded.content, loaded.assembly);
  EXPECT_EQ(setup.integrator, Integrator::runge_kutta_4);
  EXPECT_EQ(setup.gravity_m_per_s2, Eigen::Vector3d(0, 0, -9.81));
  EXPECT_EQ(setup.fluid_density_kg_per_m3, 1360);
  ASSERT_EQ(setup.bodies.size(), 11U);
  EXPECT_EQ(setup.bodies[6].name, "ball");
  EXPECT_EQ(setup.bodies[6].motion, MotionKind::axis);
  EXPECT_TRUE(setup.bodies[6].axis.isApprox(Eigen::Vector3d(0.6, 0, 0.8)));
  ASSERT_EQ(setup.springs.size(), 5U);
  EXPECT_EQ(setup.springs[0].stiffness_N_per_m, 20);  // of the chosen parameter set
  EXPECT_EQ(setup.springs[4].body_A, 6);
  EXPECT_EQ(setup.springs[4].body_B, 0);
  EXPECT_EQ(setup.springs[4].anchor_B_m, Eigen::Vector3d(0, 0, -1e-6));
}

TEST(BodySetup, KnowsThePeriodsOfTheDomain) {
  const LoadedCase loaded = with_every_key({"fluid.boundaries.z=periodic"});
  const BodySetup setup = make_body_setup(loaded.content, loaded.assembly);
  EXPECT_EQ(setup.periodic_length_m[0], 0.0);
  EXPECT_NEAR(setup.periodic_length_m[2], 96e-6, 1e-18);
}

TEST(BodySetup, HasNoBuoyancyInVacuum) {
  LoadedCase loaded = with_every_key();
  loaded.content.fluid.kind = FluidKind::vacuum;
  EXPECT_EQ(make_body_setup(loaded.content, loaded.assembly).fluid_density_kg_per_m3, 0.0);
}

TEST(Requirements, NameWhatTheCaseUsesAndNothingElse) {
  const LoadedCase loaded = with_every_key();
  EXPECT_EQ(required_of_fluid(loaded.content, loaded.assembly), (std::set<std::string>{"body_force",
                                                                                       "boundary:no_slip",
                                                                                       "boundary:pressure",
                                                                                       "boundary:velocity",
                                                                                       "checkpoint",
                                                                                       "collision:central_moments",
                                                                                       "fields",
                                                                                       "fields:selection",
                                                                                       "flow_samples",
                                                                                       "flow_samples:faces",
                                                                                       "initial_flow:uniform",
                                                                                       "moving_boundary:bounce_back",
                                                                                       "obstacle_loads",
                                                                                       "obstacles",
                                                                                       "precision:single",
                                                                                       "refill:equilibrium",
                                                                                       "shape:box",
                                                                                       "shape:capsule",
                                                                                       "shape:compound",
                                                                                       "shape:cylinder",
                                                                                       "shape:ellipsoid",
                                                                                       "shape:mesh",
                                                                                       "shape:sphere",
                                                                                       "solver:lattice_boltzmann",
                                                                                       "symmetry_planes",
                                                                                       "thin_films"}));
  // The case brings its own body service, which integrates in its own way.
  EXPECT_EQ(required_of_body(loaded.content, make_body_setup(loaded.content, loaded.assembly)),
            (std::set<std::string>{"actuator:body_force",
                                   "actuator:body_torque",
                                   "actuator:control",
                                   "actuator:joint_motion",
                                   "actuator:pair_force",
                                   "actuator:world_torque",
                                   "anchors",
                                   "bends",
                                   "checkpoint",
                                   "contact",
                                   "contact:friction",
                                   "gravity",
                                   "inertia",
                                   "joint:distance",
                                   "joint:hinge",
                                   "joint:slider",
                                   "joint:springs",
                                   "joint:limits",
                                   "model:mjcf",
                                   "motion:axis",
                                   "motion:free",
                                   "shape:box",
                                   "shape:capsule",
                                   "shape:compound",
                                   "shape:cylinder",
                                   "shape:ellipsoid",
                                   "shape:mesh",
                                   "shape:sphere",
                                   "springs",
                                   "walls"}));
}

TEST(Requirements, NameThinFilmsOnlyForACaseThatGivesTheirThickness) {
  const auto films_of = [](const std::string& cut_off) {
    const LoadedCase loaded =
        load_case(std::string(CONFIGS) + "/quick/three_sphere.yaml", {"lubrication.cut_off_cells=" + cut_off});
    return required_of_fluid(loaded.content, loaded.assembly).count("thin_films");
  };
  EXPECT_EQ(films_of("none"), 0U);
  EXPECT_EQ(films_of("auto"), 0U);
  EXPECT_EQ(films_of("1.5"), 1U);
}

TEST(Requirements, AreFewForOtherSolvers) {
  const auto required = [](const std::string& solver) {
    const LoadedCase loaded = with_every_key({"fluid.solver=" + solver, "obstacles=null", only_round_bodies});
    return required_of_fluid(loaded.content, loaded.assembly);
  };
  EXPECT_TRUE(required("stokes").contains("solver:stokes"));
  EXPECT_FALSE(required("stokes").contains("collision:central_moments"));
  EXPECT_FALSE(required("stokes").contains("fields"));
  EXPECT_TRUE(required("stokes").contains("no_slip_plane"));
  EXPECT_FALSE(required("external").contains("collision:central_moments"));
  EXPECT_TRUE(required("external").contains("body_force")) << "an external solver must not leave out physics unnoticed";
}

TEST(Requirements, OfPhysicsAreMadeOfAnExternalSolverToo) {
  EXPECT_NO_THROW(require_features({"Drag", "2", {"solver:external"}}, {"solver:lattice_boltzmann"}));
  EXPECT_THROW(require_features({"Drag", "2", {"solver:external"}}, {"shape:capsule"}), Refused);
}

TEST(Requirements, ThatAComponentNeglectsAreReported) {
  const auto notices = require_features({"Drag", "2", {"neglects:boundary", "springz"}}, {"boundary:no_slip"});
  EXPECT_EQ(notices,
            (std::vector<std::string>{"Drag 2 announces 'springz' (not a known feature). Did you mean 'springs'?",
                                      "Drag 2 neglects boundary:no_slip (the case uses it)."}));
}

TEST(SolverChoice, ChangesNothingElse) {
  const std::string quick = std::string(CONFIGS) + "/quick/three_sphere.yaml";
  const LoadedCase lattice = load_case(quick, {});
  for (const char* solver : {"stokes", "vacuum", "external"}) {
    std::vector<std::string> overrides{std::string("fluid.solver=") + solver};
    if (solver == std::string("external")) overrides.emplace_back("services.fluid.command=a_fluid");
    const LoadedCase loaded = load_case(quick, overrides);
    EXPECT_EQ(loaded.content.step_s, lattice.content.step_s) << solver;
    EXPECT_EQ(loaded.content.services.fluid_ranks, solver == std::string("external") ? 2 : 1) << solver;
  }
}

TEST(Services, AreGivenMoreTimeToAnswerOverANetworkUnlessTheCaseSaysHowMuch) {
  const std::string quick = std::string(CONFIGS) + "/quick/three_sphere.yaml";
  EXPECT_EQ(load_case(quick, {}).content.services.silence_s, 3.0);
  const std::string tcp = "services.transport=tcp://127.0.0.1:5555";
  EXPECT_EQ(load_case(quick, {tcp}).content.services.silence_s, 30.0);
  EXPECT_EQ(load_case(quick, {tcp, "services.silence_s=7"}).content.services.silence_s, 7.0);
  EXPECT_EQ(load_case(quick, {"services.hosts=[a, b]"}).content.services.silence_s, 30.0);
}

TEST(Services, HaveTheRanksOfAllHosts) {
  const std::string quick = std::string(CONFIGS) + "/quick/three_sphere.yaml";
  const LoadedCase loaded = load_case(quick, {"services.hosts=[a, b.example.org:8, 10.0.0.3:0]"});
  EXPECT_EQ(loaded.content.services.fluid_ranks, 9);
  EXPECT_EQ(loaded.content.services.hosts, (std::vector<std::string>{"a", "b.example.org:8", "10.0.0.3:0"}));
  for (const char* bad : {"[a, a:2]", "[a b]", "[-o]", "[a:x]", "[me@a]", "[a:0]"})
    EXPECT_THROW(load_case(quick, {std::string("services.hosts=") + bad}), CaseError) << bad;
  EXPECT_THROW(load_case(quick, {"fluid.solver=vacuum", "services.transport=in_process", "services.hosts=[a]"}),
               CaseError);
}

TEST(SolverChoice, TakesACommandInItsOwnLine) {
  const LoadedCase loaded =
      with_every_key({"fluid.solver={command: python3 'my fluid.py'}", "body.solver={command: [./a, b c]}",
                      "services.fluid.command=[]", "services.body.command=[]"});
  EXPECT_EQ(loaded.content.fluid.solver, FluidSolverChoice::external);
  EXPECT_EQ(loaded.content.services.fluid_command, (std::vector<std::string>{"python3", "my fluid.py"}));
  EXPECT_EQ(loaded.content.body.solver, BodySolverChoice::external);
  EXPECT_EQ(loaded.content.services.body_command, (std::vector<std::string>{"./a", "b c"}));
  const LoadedCase replaced = with_every_key({"fluid.solver={command: one}", "services.fluid.command=another --fast"});
  EXPECT_EQ(replaced.content.services.fluid_command, (std::vector<std::string>{"another", "--fast"}));
}

TEST(SolverChoice, AsksOnlyOurOwnBodiesForTheIntegrator) {
  const auto required = [](const std::string& solver) {
    const LoadedCase loaded = with_every_key({"services.body.command=[]", "body.solver=" + solver, only_round_bodies});
    return required_of_body(loaded.content, make_body_setup(loaded.content, loaded.assembly));
  };
  EXPECT_TRUE(required("own").contains("integrator:runge_kutta_4"));
  EXPECT_FALSE(required("bullet").contains("integrator:runge_kutta_4"));
}

TEST(SolverChoice, AsksForNeighboursAcrossPeriodicFaces) {
  const auto required = [](const std::string& boundary) {
    const LoadedCase loaded = with_every_key({"services.body.command=[]", "fluid.boundaries.z=" + boundary});
    return required_of_body(loaded.content, make_body_setup(loaded.content, loaded.assembly)).contains("periodic");
  };
  EXPECT_TRUE(required("periodic"));
  EXPECT_FALSE(required("no_slip"));
}

TEST(Requirements, AreComparedWithWhatAComponentCanDo) {
  const Capabilities component{"Drag", "2", {"shape:sphere"}};
  EXPECT_NO_THROW(require_features(component, {"shape:sphere"}));
  try {
    require_features(component, {"shape:capsule", "shape:sphere", "fields"});
    FAIL() << "a missing feature was not noticed";
  } catch (const Refused& refusal) {
    EXPECT_NE(std::string(refusal.what()).find("fields, shape:capsule"), std::string::npos);
    EXPECT_NE(std::string(refusal.what()).find("Drag 2"), std::string::npos);
  }
}

TEST(Estimate, CountsTheComputedPartOfASymmetricDomain) {
  const LoadedCase loaded = with_every_key();
  EXPECT_EQ(computed_cells(loaded.content.fluid), 48 * 25 * 96);
  EXPECT_EQ(population_bytes(loaded.content.fluid), 48 * 25 * 96 * 19 * 4);
}

}  // namespace
}  // namespace copepod::coupler
