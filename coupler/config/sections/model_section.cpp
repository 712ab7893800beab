#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sys/wait.h>

#include <nlohmann/json.hpp>

#include "config/sections/sections.hpp"
#include "config/yaml/csv_rows.hpp"
#include "conversion/limits.hpp"
#include "conversion/text.hpp"

namespace copepod::coupler {
namespace {

/// A word as the shell takes it whole.
std::string shell_word(const std::string& word) {
  std::string text(1, '\'');
  for (const char letter : word) {
    if (letter == '\'')
      text += "'\\''";
    else
      text += letter;
  }
  return text += '\'';
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

/// @return whether `text` holds the file's content now
bool read_file(Reader& reader, const std::string& key, const std::string& path, std::string& text) {
  std::ifstream stream(path, std::ios::binary);
  const std::string found = "is '" + path + "' (";
  if (!stream || !std::filesystem::is_regular_file(path)) {
    reader.reject(key, found + "cannot be read). Give the path of an MJCF file, relative to the case file.");
    return false;
  }
  text.assign(std::istreambuf_iterator<char>(stream), {});
  if (text.empty() || text.size() > conversion::kLimits.model_bytes || conversion::as_utf8(text, text.size()) != text) {
    reader.reject(key, found + "empty, longer than 16 MiB, or not UTF-8 text). Give an MJCF file.");
    return false;
  }
  return true;
}

}  // namespace

void read_model(Reader& body, BodyCase& result) {
  if (body.raw("model")->kind == Value::Kind::scalar) {
    const std::string path = file_beside_case(body, "model");
    if (read_file(body, "model", path, result.model.text)) result.model_file = path;
    return;
  }
  Reader model = body.section("model");
  result.model.length_m = model.number("length_m", Range::positive, 1.0);
  result.model.mass_kg = model.number("mass_kg", Range::positive, 1.0);
  result.model.time_s = model.number("time_s", Range::positive, 1.0);
  if (model.has("file") == model.has("text")) {
    model.reject("file",
                 "and text are both given or both missing (the model is in one of them). Write file: NAME.xml.");
  } else if (model.has("file")) {
    const std::string path = file_beside_case(model, "file");
    if (read_file(model, "file", path, result.model.text)) result.model_file = path;
  } else {
    result.model.text = model.text("text");
  }
}

nlohmann::ordered_json resolved_model(const ModelSpecification& model) {
  return {{"text", model.text}, {"length_m", model.length_m}, {"mass_kg", model.mass_kg}, {"time_s", model.time_s}};
}

void read_bodies_of_model(Case& the_case, Problems& problems) {
  const std::string path = "body.model";
  if (problems.any_under("body")) return;
  if (the_case.body.solver != BodySolverChoice::mujoco && the_case.services.body_command.empty()) {
    problems.error(path, path + " is given with solver: " + name_of(body_solver_names, the_case.body.solver) +
                             " (it reads no models). Use solver: mujoco.");
    return;
  }
  const ModelSpecification& model = the_case.body.model;
  std::string command = program_of(the_case) + " --bodies --units";
  for (const double unit : {model.length_m, model.mass_kg, model.time_s})
    command.append(" ").append(nlohmann::json(unit).dump());
  const Answer answer = answer_of(command + " < " + shell_word(the_case.body.model_file));
  if (!answer.succeeded) {
    problems.error(path, path + " is '" + the_case.body.model_file + "': " + reason_in(answer.text));
    return;
  }
  const Document document = Document::parse(answer.text, the_case.body.model_file, {});
  Reader found(&document.root(), path, problems);
  for (std::size_t i = 0; i < found.size("bodies"); ++i)
    the_case.bodies.push_back(read_body(found.item("bodies", i), the_case.step_s));
  for (std::size_t i = 0; i < found.size("joints"); ++i)
    the_case.joints.push_back(read_joint(found.item("joints", i), the_case.step_s));
  const std::vector<std::string> controls = found.words("controls");
  for (std::size_t i = 0; i < the_case.actuators.size(); ++i) {
    const NamedActuator& actuator = the_case.actuators[i];
    if (actuator.kind != ActuatorKind::control || std::ranges::find(controls, actuator.control) != controls.end())
      continue;
    const std::string key = "actuators." + std::to_string(i) + ".control";
    const std::string nearest = nearest_word(actuator.control, controls);
    problems.error(key, key + " is '" + actuator.control + "' (the model has no actuator of this name). " +
                            (nearest.empty() ? "Use one of the model's." : "Did you mean '" + nearest + "'?"));
  }
}

}  // namespace copepod::coupler
