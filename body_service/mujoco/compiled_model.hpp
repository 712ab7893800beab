#pragma once

#include <memory>
#include <string>

struct mjModel_;
struct mjData_;

namespace copepod::body {

using MujocoModel = std::unique_ptr<mjModel_, void (*)(mjModel_*)>;
using MujocoData = std::unique_ptr<mjData_, void (*)(mjData_*)>;

/// MuJoCo's form of a model. Errors inside the library become SolverError from here on.
/// @param model_file  what `mjcf` includes as "model.xml"; empty: nothing
/// @throws CaseError with MuJoCo's words if it refuses the text
MujocoModel compiled(const std::string& mjcf, const std::string& model_file = "");

MujocoData new_data(const mjModel_& model);

}  // namespace copepod::body
