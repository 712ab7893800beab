#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <mujoco/mujoco.h>
#include <span>

#include <nlohmann/json.hpp>

#include "contract/errors.hpp"
#include "contract/words.hpp"
#include "geometry/rotation.hpp"
#include "mujoco/mujoco_world.hpp"

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

/// Of bodies that never move, whose masses have no effect; MuJoCo's own default.
constexpr double density_of_fixed_kg_per_m3 = 1000.0;

std::string name_of_geom(const mjModel& mujoco, int geom) {
  const char* name = mj_id2name(&mujoco, mjOBJ_GEOM, geom);
  return name == nullptr || *name == '\0' ? std::string("geom_") += std::to_string(geom) : name;
}

/// @throws CaseError if it is neither sphere nor capsule
Shape shape_of(const mjModel& mujoco, int geom, double unit_m) {
  const std::span size(mujoco.geom_size + std::ptrdiff_t{3} * geom, 3);
  if (mujoco.geom_type[geom] == mjGEOM_SPHERE) return {ShapeKind::sphere, size[0] * unit_m, 0.0};
  if (mujoco.geom_type[geom] == mjGEOM_CAPSULE) return {ShapeKind::capsule, size[0] * unit_m, 2.0 * size[1] * unit_m};
  throw CaseError("geom '" + name_of_geom(mujoco, geom) +
                  "' is neither sphere nor capsule (the fluid has no other bodies). Replace it by some of these.");
}

/// Whether MuJoCo lets two geoms overlap [MuJoCo 2.2, "Computation", collision detection].
bool may_overlap(const mjModel& mujoco, int geom1, int geom2) {
  if ((mujoco.geom_contype[geom1] & mujoco.geom_conaffinity[geom2]) == 0 &&
      (mujoco.geom_contype[geom2] & mujoco.geom_conaffinity[geom1]) == 0)
    return true;
  const int body1 = mujoco.geom_bodyid[geom1];
  const int body2 = mujoco.geom_bodyid[geom2];
  const auto [low, high] = std::minmax(body1, body2);
  for (int i = 0; i < mujoco.nexclude; ++i)
    if (mujoco.exclude_signature[i] == (low << 16) + high) return true;
  const int weld1 = mujoco.body_weldid[body1];
  const int weld2 = mujoco.body_weldid[body2];
  const int above1 = mujoco.body_weldid[mujoco.body_parentid[weld1]];
  const int above2 = mujoco.body_weldid[mujoco.body_parentid[weld2]];
  const bool parents_meet = (mujoco.opt.disableflags & mjDSBL_FILTERPARENT) != 0;
  return weld1 == weld2 || (!parents_meet && weld1 != 0 && weld2 != 0 && (weld1 == above2 || weld2 == above1));
}

/// Whether it has an element `include` or an attribute `file`.
bool names_a_file(const std::string& mjcf) {
  const std::string blanks = " \t\r\n";
  const std::string attribute = "file";
  if (mjcf.find("<include") != std::string::npos) return true;
  for (std::size_t at = mjcf.find(attribute); at != std::string::npos; at = mjcf.find(attribute, at + 1)) {
    const std::size_t next = mjcf.find_first_not_of(blanks, at + attribute.size());
    const bool is_word = at > 0 && blanks.find(mjcf[at - 1]) != std::string::npos;
    if (is_word && next != std::string::npos && mjcf[next] == '=') return true;
  }
  return false;
}

/// Refuses what would undo the contacts or the controls of the case, or has no effect in steps between exchanges. What
/// else a model may set is ours (mjcf_around_model) or acts as in MuJoCo alone.
void require_options(const mjModel& mujoco) {
  const mjOption& option = mujoco.opt;
  const auto disables = [&](int flag) { return (option.disableflags & flag) != 0; };
  const auto has_user_type = [&](const int* types, int user) {
    return std::ranges::count(types, types + mujoco.nu, user) > 0;
  };
  const struct {
    bool found;
    const char* problem;
  } refused[]{
      {option.integrator == mjINT_RK4,
       "integrator is RK4 (loads are those of the start of each step). Use Euler or implicit."},
      {option.collision != mjCOL_ALL,
       "collision is not all (bodies would pass through walls of the case). Use all, and <exclude> for pairs."},
      {disables(mjDSBL_CONTACT), "flag contact is disabled (bodies would pass through walls of the case). Remove it."},
      {disables(mjDSBL_CONSTRAINT),
       "flag constraint is disabled (bodies would pass through walls of the case). Remove it."},
      {disables(mjDSBL_ACTUATION), "flag actuation is disabled (controls of the case would do nothing). Remove it."},
      {(option.enableflags & mjENBL_OVERRIDE) != 0,
       "flag override is enabled (it changes the contacts that the case gives its walls). Remove it."},
      {has_user_type(mujoco.actuator_dyntype, mjDYN_USER) || has_user_type(mujoco.actuator_gaintype, mjGAIN_USER) ||
           has_user_type(mujoco.actuator_biastype, mjBIAS_USER),
       "type of an actuator is user (there is no such function). Use another dyntype, gaintype and biastype."},
  };
  for (const auto& [found, problem] : refused)
    if (found) throw CaseError(std::string("the model's ") + problem);
}

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

std::vector<ModelBody> bodies_of(const mjModel_& mujoco, const ModelSpecification& model) {
  require_options(mujoco);
  const MujocoData data = new_data(mujoco);
  mj_kinematics(&mujoco, data.get());
  std::vector<ModelBody> bodies;
  std::vector<double> volume_m3_of_body(mujoco.nbody, 0.0);
  for (int geom = 0; geom < mujoco.ngeom; ++geom) {
    if (mujoco.geom_type[geom] == mjGEOM_PLANE) continue;
    BodySpecification& body = bodies.emplace_back(ModelBody{geom, {}}).body;
    const int owner = mujoco.geom_bodyid[geom];
    body.name = name_of_geom(mujoco, geom);
    body.shape = shape_of(mujoco, geom, model.length_m);
    body.motion = mujoco.body_weldid[owner] == 0 ? MotionKind::fixed : MotionKind::free;
    body.position_m = Eigen::Map<const Eigen::Vector3d>(data->geom_xpos + std::ptrdiff_t{3} * geom) * model.length_m;
    const Eigen::Vector4d q_W = Eigen::Map<const Eigen::Vector4d>(data->xquat + std::ptrdiff_t{4} * owner);
    const Eigen::Vector4d q_geom = Eigen::Map<const Eigen::Vector4d>(mujoco.geom_quat + std::ptrdiff_t{4} * geom);
    body.orientation_wxyz = product(q_W, q_geom).normalized();
    volume_m3_of_body[owner] += volume_m3(body.shape);
  }
  if (bodies.empty())
    throw CaseError("the model has no sphere and no capsule (the fluid would have no bodies). Add one.");
  for (ModelBody& it : bodies) {
    const int owner = mujoco.geom_bodyid[it.geom];
    const double volume = volume_m3(it.body.shape);
    it.body.mass_kg = it.body.motion == MotionKind::fixed
                          ? density_of_fixed_kg_per_m3 * volume
                          : mujoco.body_mass[owner] * model.mass_kg * volume / volume_m3_of_body[owner];
  }
  return bodies;
}

std::string bodies_as_json(const ModelSpecification& model) {
  require_no_files(model.text);
  const MujocoModel mujoco = compiled(model.text);
  const std::vector<ModelBody> found = bodies_of(*mujoco, model);
  nlohmann::json bodies = nlohmann::json::array();
  nlohmann::json joints = nlohmann::json::array();
  for (std::size_t i = 0; i < found.size(); ++i) {
    const BodySpecification& body = found[i].body;
    bodies.push_back({{"name", body.name},
                      {"shape", copepod::name_of(shape_names, body.shape.kind)},
                      {"radius_m", body.shape.radius_m},
                      {"length_m", body.shape.length_m},
                      {"mass_kg", body.mass_kg},
                      {"motion", copepod::name_of(motion_names, body.motion)},
                      {"position_m", body.position_m},
                      {"orientation_wxyz", body.orientation_wxyz}});
    for (std::size_t j = 0; j < i; ++j) {
      const bool fixed = body.motion == MotionKind::fixed && found[j].body.motion == MotionKind::fixed;
      if (fixed || !may_overlap(*mujoco, found[j].geom, found[i].geom)) continue;
      joints.push_back({{"name", found[j].body.name + " and " + body.name},
                        {"kind", "model"},
                        {"bodies", {found[j].body.name, body.name}}});
    }
  }
  nlohmann::json controls = nlohmann::json::array();
  for (int i = 0; i < mujoco->nu; ++i) {
    const char* name = mj_id2name(mujoco.get(), mjOBJ_ACTUATOR, i);
    if (name != nullptr) controls.push_back(name);
  }
  return nlohmann::json{{"bodies", bodies}, {"joints", joints}, {"controls", controls}}.dump();
}

void require_bodies_of_model(const BodySetup& setup, const std::vector<ModelBody>& bodies) {
  const std::string remedy = "). Write body.model: FILE.xml, without bodies or swimmers beside it.";
  if (bodies.size() != setup.bodies.size())
    throw CaseError("the case has " + std::to_string(setup.bodies.size()) + " bodies, its model " +
                    std::to_string(bodies.size()) + " spheres and capsules (they must be the same" + remedy);
  constexpr double rounding = 1e-9;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const BodySpecification& body = setup.bodies[i];
    const BodySpecification& wanted = bodies[i].body;
    const auto same = [](double one, double other) { return std::abs(one - other) <= rounding * std::abs(other); };
    const bool same_shape = body.shape.kind == wanted.shape.kind && same(body.shape.radius_m, wanted.shape.radius_m) &&
                            same(body.shape.length_m, wanted.shape.length_m);
    const bool same_place = (body.position_m - wanted.position_m).norm() <= rounding * wanted.shape.radius_m &&
                            std::abs(body.orientation_wxyz.dot(wanted.orientation_wxyz)) >= 1.0 - rounding;
    const bool at_rest = body.velocity_m_per_s.isZero(0.0) && body.angular_velocity_rad_per_s.isZero(0.0);
    if (same_shape && same_place && at_rest && same(body.mass_kg, wanted.mass_kg) && body.motion == wanted.motion)
      continue;
    throw CaseError("body '" + body.name + "' is not '" + wanted.name +
                    "' of the model (shape, mass, place and motion must be the same, and it starts at rest" + remedy);
  }
}

void require_no_files(const std::string& mjcf) {
  if (mjcf.empty()) throw CaseError("the model is empty. Give a file in MuJoCo's format, MJCF.");
  if (!names_a_file(mjcf)) return;
  throw CaseError("the model reads other files (a case holds its whole model). Write their content into it.");
}

}  // namespace copepod::body
