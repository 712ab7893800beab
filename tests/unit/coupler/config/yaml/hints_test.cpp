#include <algorithm>
#include <map>
#include <regex>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "config/load_case.hpp"
#include "config/sections/sections.hpp"
#include "config/yaml/keys.hpp"

namespace copepod::coupler {
namespace {

/// A section that a schema has, by its path, and its keys.
using Sections = std::map<std::string, std::vector<std::string>>;

Sections sections() {
  Sections found;
  for (const std::string& path : case_keys()) {
    const std::size_t dot = path.rfind('.');
    std::vector<std::string>& keys = found[dot == std::string::npos ? "" : path.substr(0, dot)];
    const std::string key = path.substr(dot + 1);
    if (std::ranges::find(keys, key) == keys.end()) keys.push_back(key);
  }
  return found;
}

struct Mistake {
  std::string section;
  std::string written;
  std::string meant;  ///< part of the hint
};

/// Of every key of some sections: its unit left out, or another one; a letter too few; two that change places.
std::vector<Mistake> slips() {
  std::vector<Mistake> mistakes;
  const std::regex unit("[a-z]_(m|kg|N_per_m|s|N_s_per_m|m_per_s)$");
  for (const auto& [section, keys] : sections()) {
    if (section.starts_with("swarm.template") || section.find("signal") != std::string::npos) continue;
    for (const std::string& key : keys) {
      if (key.size() < 5) continue;
      if (std::regex_search(key, unit)) {
        const std::string quantity =
            key.substr(0, key.size() - std::sregex_iterator(key.begin(), key.end(), unit)->length() + 1);
        mistakes.push_back({section, quantity, "mean " + quantity});
        mistakes.push_back({section, quantity + "_um", "mean " + quantity});
      }
      std::string swapped = key;
      std::swap(swapped[2], swapped[3]);
      if (swapped != key) mistakes.push_back({section, swapped, "mean " + key});
      mistakes.push_back({section, key.substr(0, 1) + key.substr(2), "mean " + key});
    }
  }
  return mistakes;
}

const std::vector<Mistake> other_mistakes{
    // Another name of the same quantity.
    {"bodies.[]", "density_kg_per_m3", "mean mass_kg"},
    {"bodies.[]", "weight_kg", "mean mass_kg"},
    {"bodies.[]", "center_m", "mean position_m"},
    {"bodies.[]", "pos", "mean position_m"},
    {"bodies.[]", "diameter_m", "mean radius_m"},
    {"bodies.[]", "r_m", "mean radius_m"},
    {"bodies.[]", "speed_m_per_s", "mean velocity_m_per_s"},
    {"bodies.[]", "spin_rad_per_s", "mean angular_velocity_rad_per_s"},
    {"bodies.[]", "quaternion", "mean orientation_wxyz"},
    {"bodies.[]", "type", "mean shape"},
    {"bodies.[]", "id", "mean name"},
    {"swimmers.[].beads.[]", "rho_kg_per_m3", "mean density_kg_per_m3"},
    {"swimmers.[].beads.[]", "size_m", "mean radius_m"},
    {"swimmers.[]", "position_m", "mean center_m"},
    {"swimmers.[]", "springs", "mean arms"},
    {"swimmers.[]", "spheres", "mean beads"},
    {"swimmers.[].arms.[].spring", "k_N_per_m", "mean stiffness_N_per_m"},
    {"swimmers.[].arms.[].spring", "spring_constant", "mean stiffness_N_per_m"},
    {"swimmers.[].arms.[].spring", "gamma", "mean damping_N_s_per_m"},
    {"swimmers.[].arms.[].spring", "length_m", "mean rest_length_m"},
    {"springs.[]", "length_m", "mean rest_length_m"},
    {"springs.[]", "k", "mean stiffness_N_per_m"},
    {"fluid", "viscosity_m2_per_s", "mean kinematic_viscosity_m2_per_s"},
    {"fluid", "nu", "mean kinematic_viscosity_m2_per_s"},
    {"fluid", "rho", "mean density_kg_per_m3"},
    {"fluid", "dx_m", "mean cell_size_m"},
    {"fluid", "resolution", "mean cell_size_m"},
    {"fluid", "tau", "mean relaxation_time"},
    {"fluid", "domain", "mean domain_cells"},
    {"fluid", "grid", "mean domain_cells"},
    {"fluid", "boundary_conditions", "mean boundaries"},
    {"fluid", "walls", "mean boundaries"},
    {"fluid", "collision_model", "mean collision"},
    {"fluid", "method", "mean solver"},
    {"fluid", "force_N_per_m3", "mean body_force_N_per_m3"},
    {"", "dt", "mean step_s"},
    {"", "time_step_s", "mean step_s"},
    {"", "gravity", "mean gravity_m_per_s2"},
    {"", "g", "mean gravity_m_per_s2"},
    {"", "particles", "mean bodies"},
    {"", "name", "mean case"},
    {"run", "iterations", "mean steps"},
    {"run", "duration_s", "mean steps"},
    {"services.fluid", "processes", "mean ranks"},
    {"services.body", "cores", "mean threads"},
    {"output.fields", "interval_steps", "mean every_steps"},
    {"output.trajectory", "every", "mean every_steps"},
    {"contact", "mu", "mean friction"},
    {"contact", "elasticity", "mean restitution"},
    {"joints.[]", "type", "mean kind"},
    {"actuators.[].signal", "force_N", "mean amplitude_N"},
    {"actuators.[].signal", "delay_s", "mean lag_s"},
    {"actuators.[].signal", "phase_deg", "mean lag_deg"},
    {"swarm", "number", "mean count"},
    {"swarm", "random_seed", "mean seed"},
    // A key of another section.
    {"", "ranks", "key of services.fluid"},
    {"", "solver", "key of fluid, body"},
    {"", "viscosity", "fluid.kinematic_viscosity_m2_per_s"},
    {"", "domain_cells", "key of fluid"},
    {"", "relaxation_time", "key of fluid"},
    {"", "collision", "key of fluid"},
    {"", "steps", "key of run"},
    {"", "load_averaging", "key of coupling"},
    {"", "virtual_mass", "key of coupling"},
    {"", "restitution", "key of contact"},
    {"", "roughness_m", "key of lubrication"},
    {"", "transport", "key of services"},
    {"", "trajectory", "key of output"},
    {"", "checkpoint", "key of output"},
    {"", "integrator", "key of body"},
    {"fluid", "step_s", "key of the top of the case"},
    {"fluid", "gravity_m_per_s2", "key of the top of the case"},
    {"fluid", "ranks", "key of services.fluid"},
    {"fluid", "roughness_m", "key of lubrication"},
    {"run", "step_s", "key of the top of the case"},
    {"run", "gravity_m_per_s2", "key of the top of the case"},
    {"output", "every_wall_s", "key of output.checkpoint"},
    {"output", "quantities", "key of output.fields"},
    {"output", "region_cells", "key of output.fields"},
    {"output", "mean_over_steps", "key of output.fields"},
    {"services", "ranks", "key of services.fluid"},
    {"services", "threads", "key of services.body"},
    {"bodies.[]", "friction", "key of contact"},
    {"bodies.[]", "restitution", "key of contact"},
    {"body", "gravity_m_per_s2", "key of the top of the case"},
    {"coupling", "roughness_m", "key of lubrication"},
};

TEST(Hints, AreRightForNineMistakesOfTen) {
  const Sections known = sections();
  std::vector<Mistake> mistakes = slips();
  EXPECT_GT(mistakes.size() + other_mistakes.size(), 200U);
  const auto wrong_among = [&](const std::vector<Mistake>& some) {
    double wrong = 0;
    for (const auto& [section, written, meant] : some) {
      const std::vector<std::string>& keys = known.at(section);
      if (std::ranges::find(keys, written) != keys.end()) continue;
      const std::string hint = hint_for(written, keys, case_keys());
      if (hint.find(meant) != std::string::npos) continue;
      ++wrong;
      std::printf("%s: %s → %s (not: %s)\n", section.c_str(), written.c_str(), hint.substr(0, 60).c_str(),
                  meant.c_str());
    }
    return wrong / static_cast<double>(some.size());
  };
  EXPECT_LT(wrong_among(mistakes), 0.05);
  EXPECT_LT(wrong_among(other_mistakes), 0.1);
}

}  // namespace
}  // namespace copepod::coupler
