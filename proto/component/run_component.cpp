#include "component/run_component.hpp"

#include <csignal>
#include <iostream>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "component/command_line.hpp"
#include "component/control_lane.hpp"
#include "component/server.hpp"
#include "conversion/codec.hpp"
#include "system/process.hpp"
#include "transport/lanes.hpp"

namespace copepod {

namespace {

using namespace component;

session::Hello introduce(session::Role role, const Capabilities& capabilities, int ranks, const Options& options) {
  session::Hello hello;
  hello.role = role;
  hello.session_token = options.session_token;
  hello.capabilities = capabilities;
  hello.host = host_name();
  hello.pid = getpid();
  hello.ranks = static_cast<std::uint32_t>(ranks);
  hello.instance = random_number();
  hello.name = options.name;
  return hello;
}

/// Unique name of a lane at the coupler's socket.
std::string lane_name(const session::Hello& hello, session::Lane lane) {
  return hello.party() + "-" + std::to_string(hello.instance) + "-" + std::string(name_of(lane));
}

ExitCode serve(ServedSolver& solver, const Capabilities& capabilities, int ranks, SolverContext& context,
               const Options& options) {
  const auto vitals = std::make_shared<Vitals>(context);
  const auto log = open_log(options, solver.role(), 0, vitals);
  const session::Hello hello = introduce(solver.role(), capabilities, ranks, options);
  log->info("{} {} connects to {} as {}.", capabilities.name, capabilities.version, options.endpoint,
            name_of(solver.role()));
  const auto keys =
      options.key_file.empty() ? std::nullopt : std::optional(transport::read_component_keys(options.key_file));
  const auto data_lane = transport::connect_dealer(options.endpoint, lane_name(hello, session::Lane::data), keys);
  const ControlLane control_lane(
      transport::connect_dealer(options.endpoint, lane_name(hello, session::Lane::control), keys), *vitals, *log, hello,
      {options.orphan_after_s, 3.0});
  Server server(*data_lane, solver, *vitals, *log, hello, options.connect_deadline_s);
  const ExitCode code = server.run();
  log->info("Ending with exit code {}.", static_cast<int>(code));
  return code;
}

/// The component's estimate of a setup as `--estimate` prints it; empty if it has none.
template <class Component, class Setup>
EstimateText estimate_text(const Component& component, Setup setup_from_bytes(std::string_view)) {
  if (!component.estimate) return {};
  return [&component, setup_from_bytes](const std::string& setup_bytes, int ranks) {
    const Estimate estimate = component.estimate(setup_from_bytes(setup_bytes), ranks);
    return nlohmann::json{{"memory_bytes", estimate.memory_bytes}, {"problem", estimate.problem}}.dump();
  };
}

int run_served(int argc, char** argv, ServedSolver& solver, Capabilities capabilities, const EstimateText& estimate,
               const BodiesText& bodies, int ranks, SolverContext& context) {
  if (estimate) capabilities.features.insert("estimate");
  const ParsedCommandLine parsed = parse_command_line(argc, argv, solver.role(), capabilities, estimate, bodies);
  if (!parsed.options) return parsed.answer();
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is a full disk, not the end
  try {
    return static_cast<int>(serve(solver, capabilities, ranks, context, *parsed.options));
  } catch (const Error& error) {
    std::cerr << "error: " << error.what() << std::endl;
    return static_cast<int>(error.code());
  } catch (const std::exception& error) {
    std::cerr << "error: " << error.what() << std::endl;
    return static_cast<int>(ExitCode::solver_failed);
  }
}

}  // namespace

bool starts_service(int argc, char** argv) {
  return parse_command_line(argc, argv, session::Role::fluid, {}).options.has_value();
}

int run_fluid_component(int argc, char** argv, const FluidComponent& component, int ranks, SolverContext& context) {
  ServedFluid solver(component, context);
  const EstimateText estimate = estimate_text(component, conversion::fluid_setup_from_bytes);
  return run_served(argc, argv, solver, component.capabilities, estimate, component.bodies_of, ranks, context);
}

int run_fluid_component(int argc, char** argv, const FluidComponent& component) {
  SolverContext context;
  return run_fluid_component(argc, argv, component, 1, context);
}

int run_body_component(int argc, char** argv, const BodyComponent& component) {
  SolverContext context;
  ServedBody solver(component, context);
  const EstimateText estimate = estimate_text(component, conversion::body_setup_from_bytes);
  return run_served(argc, argv, solver, component.capabilities, estimate, component.bodies_of, 1, context);
}

int run_controller_component(int argc, char** argv, const ControllerComponent& component) {
  SolverContext context;
  ServedController controller(component, context);
  return run_served(argc, argv, controller, component.capabilities, {}, {}, 1, context);
}

}  // namespace copepod
