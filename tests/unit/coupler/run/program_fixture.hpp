#pragma once

#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "fakes.hpp"
#include "run/program.hpp"
#include "temporary_folder.hpp"

namespace copepod::coupler {

/// The coupler program with components in this process.
class Program : public testing::Test {
 protected:
  Program() {
    std::ofstream(case_file) << R"(case: small
fluid: {solver: vacuum, cell_size_m: 1.0e-6}
step_s: 7.5e-10
swimmers:
  - name: swimmer
    center_m: [0, 0, 0]
    beads: [{radius_m: 4.0e-6}, {radius_m: 4.0e-6}, {radius_m: 4.0e-6}]
    bead_mass_kg: 5.44e-13
    rest_gap_m: [17.0e-6, 17.0e-6]
    spring: {stiffness_N_per_m: 100, damping_N_s_per_m: 1.0e-6}
    stroke: {amplitude_N: 5.0e-5, period_steps: 1000, phase_lag_steps: 250, cycles: 2}
run: {steps: 2500}
output: {trajectory: {every_steps: 100}}
)";
  }

  int call(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "coupler");
    std::vector<const char*> argv;
    for (const std::string& argument : arguments) argv.push_back(argument.c_str());
    out.str("");
    err.str("");
    return run_program(static_cast<int>(argv.size()), argv.data(), out, err,
                       [&](const Options& options, const Case&, const RunSignals& of_the_run) {
                         seen = options;
                         signals = &of_the_run;
                         auto made = std::make_unique<LocalComponents>(drag, saves);
                         made->before_exchange = before_exchange;
                         made->on_connect = on_connect;
                         made->before_save = before_save;
                         made->fluid_reports_phases = fluid_reports_phases;
                         if (change_bodies) change_bodies(made->changeable_body_capabilities());
                         components = made.get();
                         return std::unique_ptr<Components>(std::move(made));
                       });
  }
  int run(std::vector<std::string> more = {}) {
    std::vector<std::string> arguments{"--run",      case_file, "--out",     out_dir.string(),
                                       "--endpoint", "none",    "--session", "secret-7"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return call(arguments);
  }
  [[nodiscard]] std::vector<nlohmann::json> events() const {
    std::vector<nlohmann::json> lines;
    std::istringstream text(out.str());
    for (std::string line; std::getline(text, line);) lines.push_back(nlohmann::json::parse(line));
    return lines;
  }
  [[nodiscard]] nlohmann::json file(const char* name) const {
    return nlohmann::json::parse(content_of(out_dir / name));
  }

  TemporaryFolder folder;
  std::filesystem::path out_dir = folder.path("run");
  std::string case_file = folder.path("case.yaml");
  std::ostringstream out;
  std::ostringstream err;
  Options seen;
  double drag = 1e-6;
  bool saves = true, fluid_reports_phases = true;
  std::function<void(Capabilities&)> change_bodies;  ///< what the body component announces
  std::function<void(std::int64_t)> before_exchange;
  std::function<void()> on_connect, before_save;
  LocalComponents* components = nullptr;  ///< valid inside a run only, like the next
  const RunSignals* signals = nullptr;
};

}  // namespace copepod::coupler
