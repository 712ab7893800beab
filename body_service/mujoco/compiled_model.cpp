#include "mujoco/compiled_model.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <mujoco/mujoco.h>

#include "contract/errors.hpp"

namespace copepod::body {

namespace {

/// MuJoCo's own handler would wait for a key; an exception passes its C functions, which hold nothing.
[[noreturn]] void raise(const char* text) {
  throw SolverError("MuJoCo: " + std::string(text) + " (an error inside the library). Use body.solver: own.", 0);
}

void ignore(const char*) {}  // its own handler writes a file; MujocoWorld looks for warnings

/// Files in memory that MuJoCo finds by their names.
class Files {
 public:
  Files() { mj_defaultVFS(&files_); }
  Files(const Files&) = delete;
  Files& operator=(const Files&) = delete;
  ~Files() { mj_deleteVFS(&files_); }

  void add(const char* name, const std::string& text) {
    mj_makeEmptyFileVFS(&files_, name, static_cast<int>(text.size()));
    std::memcpy(files_.filedata[files_.nfile - 1], text.data(), text.size());
  }
  [[nodiscard]] const mjVFS* get() const { return &files_; }

 private:
  mjVFS files_{};
};

}  // namespace

MujocoModel compiled(const std::string& mjcf, const std::string& model_file) {
  mju_user_error = raise;
  mju_user_warning = ignore;
  const auto files = std::make_unique<Files>();  // large
  files->add("case.xml", mjcf);
  if (!model_file.empty()) files->add("model.xml", model_file);
  std::array<char, 1000> problem{};
  MujocoModel model(mj_loadXML("case.xml", files->get(), problem.data(), static_cast<int>(problem.size())),
                    mj_deleteModel);
  if (model != nullptr) return model;
  std::string reason(problem.data());
  while (reason.ends_with('\n')) reason.pop_back();
  std::ranges::replace(reason, '\n', ' ');
  throw CaseError("MuJoCo refuses the bodies (" + reason + "). Correct body.model, or use body.solver: own.");
}

MujocoData new_data(const mjModel_& model) { return {mj_makeData(&model), mj_deleteData}; }

}  // namespace copepod::body
