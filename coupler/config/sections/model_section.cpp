#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <sys/wait.h>

#include <nlohmann/json.hpp>

#include "config/sections/sections.hpp"
#include "config/yaml/keys.hpp"
#include "conversion/limits.hpp"

namespace copepod::coupler {
namespace {

/// A word as the shell takes it whole.
std::string shell_word(const std::string& word) {
  return "'" + std::regex_replace(word, std::regex("'"), "'\\''") + "'";
}

/// The program of the case's body component, with its own arguments.
std::string program_of(const Case& the_case) {
  std::string command;
  for (const std::string& word : the_case.services.body_command) command.append(" ").append(shell_word(word));
  if (!command.empty()) return command;
  return shell_word(std::filesystem::read_symlink("/proc/self/exe").parent_path() / "mujoco_body_service");
}

struct Answer {
  bool succeeded = false;
  std::string text;  ///< all that was printed
};

Answer answer_of(const std::string& command) {
  Answer answer;
  std::FILE* pipe = popen((command + " 2>&1").c_str(), "re");
  if (pipe == nullptr) return answer;
  char piece[4096];
  for (std::size_t size = 1; size > 0;) {
    size = std::fread(piece, 1, sizeof piece, pipe);
    answer.text.append(piece, size);
  }
  const int status = pclose(pipe);
  answer.succeeded = WIFEXITED(status) && WEXITSTATUS(status) == 0;
  return answer;
}

/// The last line of what a program printed, without "error: ".
std::string reason_in(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  text = text.substr(text.rfind('\n') + 1);
  const std::string prefix = "error: ";
  return text.starts_with(prefix) ? text.substr(prefix.size()) : text;
}

/// Takes the model from the file that a key names.
void read_model_file(Keys& keys, const std::string& key, BodyCase& body) {
  const std::string path = file_beside_case(keys, key);
  std::ifstream stream(path, std::ios::binary);
  const std::string found = "is '" + path + "' (";
  if (!stream || !std::filesystem::is_regular_file(path))
    return keys.reject(key, found + "cannot be read). Give the path of an MJCF file, relative to the case file.");
  std::string& text = body.model.text;
  text.assign(std::istreambuf_iterator<char>(stream), {});
  if (text.empty() || text.size() > conversion::kLimits.model_bytes || conversion::as_utf8(text, text.size()) != text)
    return keys.reject(key, found + "empty, longer than 16 MiB, or not UTF-8 text). Give an MJCF file.");
  body.model_file = path;
}

/// The text of the model, or the file that holds it.
void declare_source(Keys& keys, BodyCase& body) {
  keys.reject_if(keys.has("file") == keys.has("text"), "file",
                 "and text are both given or both missing (the model is in one of them). Write file: NAME.xml.");
  if (keys.has("file") && !keys.has("text")) return read_model_file(keys, "file", body);
  keys.describe("file", {{"type", "string"}}, "Path of the MJCF file, relative to the case file.");
  keys.text("text", body.model.text,
            "The model itself, as resolved cases have it; bodies and joints are then in the case too.");
}

}  // namespace

void declare_model(Keys& keys, BodyCase& body) {
  if (!keys.when(keys.reads() ? keys.has("model") : !body.model.text.empty())) return;
  if (const Value* file = keys.raw("model"); file != nullptr && file->kind == Value::Kind::scalar)
    return read_model_file(keys, "model", body);
  keys.describe("model", {{"type", "string"}},
                "The bodies as a model of MuJoCo: its spheres and capsules are the case's bodies, with the model's own "
                "joints, tendons and actuators; fluid, gravity and step are the case's. The path of an MJCF file, "
                "relative to the case file, or a mapping. With solver: mujoco.");
  keys.either("model", [&](Keys& model) {
    declare_source(model, body);
    model.number("length_m", body.model.length_m, Range::positive,
                 "Unit of length of the model. Numbers near 1 suit MuJoCo.");
    model.number("mass_kg", body.model.mass_kg, Range::positive, "Its unit of mass.");
    model.number("time_s", body.model.time_s, Range::positive, "Its unit of time; steps near 0.002 suit MuJoCo.");
  });
}

void read_bodies_of_model(Case& the_case, Problems& problems) {
  const std::string path = "body.model";
  if (problems.any_under("body")) return;
  if (the_case.body.solver != BodySolverChoice::mujoco && the_case.services.body_command.empty())
    return problems.reject(path, std::string("is given with solver: ") +
                                     name_of(body_solver_names, the_case.body.solver) +
                                     " (it reads no models). Use solver: mujoco.");
  const ModelSpecification& model = the_case.body.model;
  std::string command = program_of(the_case) + " --bodies --units";
  for (const double unit : {model.length_m, model.mass_kg, model.time_s})
    command.append(" ").append(nlohmann::json(unit).dump());
  const Answer answer = answer_of(command + " < " + shell_word(the_case.body.model_file));
  if (!answer.succeeded)
    return problems.reject(path, "is '" + the_case.body.model_file + "': " + reason_in(answer.text));
  const Document document = Document::parse(answer.text, the_case.body.model_file, {});
  Keys found(&document.root(), path, problems);
  std::vector<SingleBody> bodies;
  std::vector<NamedJoint> joints;
  const auto item = [&](Keys& below, auto& each) { declare(below, each, the_case.step_s); };
  found.list("bodies", bodies, "", item);
  found.list("joints", joints, "", item);
  the_case.bodies.insert(the_case.bodies.end(), bodies.begin(), bodies.end());
  the_case.joints.insert(the_case.joints.end(), joints.begin(), joints.end());
  std::vector<std::string> controls;
  found.words("controls", controls, 0, "");
  for (std::size_t i = 0; i < the_case.actuators.size(); ++i) {
    const NamedActuator& actuator = the_case.actuators[i];
    if (actuator.kind != ActuatorKind::control || std::ranges::find(controls, actuator.control) != controls.end())
      continue;
    const std::string key = "actuators." + std::to_string(i) + ".control";
    const std::string nearest = nearest_word(actuator.control, controls);
    problems.reject(key, "is '" + actuator.control + "' (the model has no actuator of this name). " +
                             (nearest.empty() ? "Use one of the model's." : "Did you mean '" + nearest + "'?"));
  }
}

}  // namespace copepod::coupler
