#include "coupled_run.hpp"

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <unistd.h>

#include "components.hpp"
#include "fake_programs.hpp"

namespace copepod::protocol_test {

namespace {

constexpr double kStep_s = 1e-6;
constexpr double kRadius_m = 4e-6;
constexpr double kMass_kg = 5e-13;
constexpr double kDensity_kg_per_m3 = 1000;
constexpr double kViscosity_m2_per_s = 1e-6;

std::vector<std::string> command(const std::vector<std::string>& program, const std::string& endpoint,
                                 const std::string& log, const std::vector<std::string>& options) {
  std::vector<std::string> words = program;
  for (const std::string& word : {std::string("--endpoint"), endpoint, std::string("--session"), std::string("secret"),
                                  std::string("--log-file"), log}) {
    words.push_back(word);
  }
  words.insert(words.end(), options.begin(), options.end());
  return words;
}

/// The serial explicit scheme without averaging or driving.
void couple(FluidSolver& fluid, BodySolver& body, Kinematics& kinematics, Loads& loads, int steps) {
  AppliedLoads applied;
  applied.actuation.resize(0, 1);
  for (int i = 0; i < steps; ++i) {
    fluid.exchange(kinematics, loads);
    fluid.advance();
    applied.hydrodynamic = loads;
    body.step(applied, kinematics);
  }
}

std::vector<std::string> or_fake(const std::vector<std::string>& program, const char* fake) {
  return program.empty() ? std::vector<std::string>{fake} : program;
}

}  // namespace

std::string tcp_endpoint() { return "tcp://127.0.0.1:" + std::to_string(20000 + getpid() % 12000); }

FluidSetup two_spheres_in_fluid() {
  FluidSetup setup;
  setup.step_s = kStep_s;
  setup.density_kg_per_m3 = kDensity_kg_per_m3;
  setup.kinematic_viscosity_m2_per_s = kViscosity_m2_per_s;
  setup.domain_cells = {10, 10, 10};
  setup.bodies = {{ShapeKind::sphere, kRadius_m, 0}, {ShapeKind::sphere, kRadius_m, 0}};
  return setup;
}

BodySetup two_free_spheres() {
  BodySetup setup;
  setup.step_s = kStep_s;
  setup.bodies.resize(2);
  for (BodySpecification& body : setup.bodies) {
    body.shape = {ShapeKind::sphere, kRadius_m, 0};
    body.mass_kg = kMass_kg;
  }
  setup.bodies[0].name = "mover";
  setup.bodies[0].velocity_m_per_s = {1e-3, 0, 0};
  setup.bodies[1].name = "rester";
  setup.bodies[1].position_m = {3e-5, 0, 0};
  return setup;
}

double decay_per_step() {
  return 6 * std::numbers::pi * kDensity_kg_per_m3 * kViscosity_m2_per_s * kRadius_m * kStep_s / kMass_kg;
}

Digests digests_of_local_run(int steps) {
  SolverContext context;
  const auto fluid = doubles::constant_drag_component().make_solver(two_spheres_in_fluid(), context);
  const auto body = doubles::free_point_component().make_solver(two_free_spheres(), context);
  Kinematics kinematics;
  Loads loads;
  body->kinematics(kinematics);
  couple(*fluid, *body, kinematics, loads, steps);
  return {fluid->summarise().digest, body->summarise().digest};
}

std::vector<std::string> fake_fluid_command(const std::string& endpoint, const std::vector<std::string>& options) {
  return command({kFakeFluid}, endpoint, "/dev/null", options);
}

CoupledRun::CoupledRun(const std::vector<std::string>& fluid_options, const std::vector<std::string>& body_options,
                       LinkSettings settings, const std::string& endpoint, const Programs& programs) {
  settings.endpoint = endpoint.empty() ? "ipc://" + folder.path("coupler.ipc") : endpoint;
  settings.session = "secret";
  link = std::make_unique<Link>(settings);
  const auto or_ours = [&](const std::string& chosen) { return chosen.empty() ? settings.endpoint : chosen; };
  fluid_process = std::make_unique<ChildProcess>(command(
      or_fake(programs.fluid, kFakeFluid), or_ours(programs.fluid_endpoint), folder.path("fluid.log"), fluid_options));
  body_process = std::make_unique<ChildProcess>(command(
      or_fake(programs.body, kFakeBody), or_ours(programs.body_endpoint), folder.path("body.log"), body_options));
}

void CoupledRun::begin() {
  link->await_components();
  fluid = std::make_unique<RemoteFluid>(*link, two_spheres_in_fluid(), 0);
  body = std::make_unique<RemoteBody>(*link, two_free_spheres(), 0);
  body->kinematics(kinematics);
}

void CoupledRun::advance(int steps) { couple(*fluid, *body, kinematics, loads, steps); }

Digests CoupledRun::digests() { return {fluid->summarise().digest, body->summarise().digest}; }

std::string CoupledRun::advance_until_failure() {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  try {
    while (std::chrono::steady_clock::now() < end) advance(1);
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing failed";
}

std::string CoupledRun::fluid_log() const {
  std::ostringstream text;
  text << std::ifstream(folder.path("fluid.log")).rdbuf();
  return text.str();
}

}  // namespace copepod::protocol_test
