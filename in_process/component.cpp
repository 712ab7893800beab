#include <condition_variable>
#include <cstdlib>
#include <limits>
#include <memory>
#include <mutex>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "c_border.hpp"
#include "component/run_component.hpp"
#include "conversion/codec.hpp"
#include "copepod_component.h"

namespace copepod {
namespace {

copepod_request request_to(std::int32_t kind, const char* text = nullptr) {
  copepod_request request{};
  request.kind = kind;
  request.text = text;
  return request;
}

/// A component whose solver is the caller of the C interface. The kit serves it in a thread of its own, which asks one
/// request at a time and waits for the answer.
class CalledComponent {
 public:
  // Of the kit's thread.

  /// @throws what the caller answers by copepod_component_fail
  void ask(copepod_request request) {
    std::unique_lock lock(mutex_);
    request.bodies = kinematics.bodies();
    request.loads = loads.bodies();
    request.actuators = actuators;
    request.position_m = kinematics.position_m.data();
    request.orientation_wxyz = kinematics.orientation_wxyz.data();
    request.velocity_m_per_s = kinematics.velocity_m_per_s.data();
    request.angular_velocity_rad_per_s = kinematics.angular_velocity_rad_per_s.data();
    request.force_N = loads.force_N.data();
    request.torque_N_m = loads.torque_N_m.data();
    request_ = request;
    turn_ = Turn::caller;
    changed_.notify_all();
    if (request.kind == COPEPOD_END) return;
    changed_.wait(lock, [&] { return turn_ == Turn::kit; });
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
  }

  Kinematics kinematics;  ///< asked for or to be answered, like the loads
  Loads loads;
  std::int64_t actuators = 0;
  SolverContext* context = nullptr;
  nlohmann::json setup;

  // Of the caller's thread.

  std::thread kit;

  copepod_request next() {
    const std::unique_lock in_a_call = only_call();
    std::unique_lock lock(mutex_);
    require(!ended_, "the component has ended (COPEPOD_END was its last request). End the process.");
    if (turn_ == Turn::caller && is_asked_) give_back();
    changed_.wait(lock, [&] { return turn_ == Turn::caller; });
    is_asked_ = true;
    ended_ = request_.kind == COPEPOD_END;
    lock.unlock();
    if (ended_) kit.join();  // the process is about to end
    return request_;
  }

  void fail(int code, const std::string& reason) {
    const std::unique_lock in_a_call = only_call();
    const std::lock_guard lock(mutex_);
    require(is_asked_ && turn_ == Turn::caller && !ended_, "nothing was asked (next comes first). Call it.");
    failure_ = code == static_cast<int>(ExitCode::storage_failed)
                   ? std::make_exception_ptr(StorageError(reason))
                   : std::make_exception_ptr(SolverError(reason, 0, request_.step));
    give_back();
  }

  [[nodiscard]] double number(const std::string& path) const {
    const bool is_path = path.starts_with('/') && path.find('~') == std::string::npos;
    require(is_path && setup.contains(nlohmann::json::json_pointer(path)),
            "the setup has no " + path + " (or there is none yet). Its text has the names.");
    const nlohmann::json& value = setup.at(nlohmann::json::json_pointer(path));
    const std::string text = value.is_string() ? value.get<std::string>() : value.dump();  // text: also of 64 bits
    char* end = nullptr;
    const double number = std::strtod(text.c_str(), &end);
    require(!text.empty() && *end == '\0', path + " of the setup is not a number. Its text has the names.");
    return number;
  }
  void report_progress() const {
    require(context != nullptr, "there is no setup yet. Call this during long work only.");
    context->report_progress();
  }

 private:
  enum class Turn { kit, caller };

  std::unique_lock<std::mutex> only_call() {
    std::unique_lock lock(in_a_call_, std::try_to_lock);
    require(lock.owns_lock(), "another thread is in a call for the component (one at a time). Wait for it.");
    return lock;
  }
  void give_back() {
    is_asked_ = false;
    turn_ = Turn::kit;
    changed_.notify_all();
  }

  std::mutex in_a_call_;
  std::mutex mutex_;  ///< of what follows
  std::condition_variable changed_;
  Turn turn_ = Turn::kit;
  bool is_asked_ = false;  ///< the caller has the request, and it is not answered
  bool ended_ = false;
  copepod_request request_{};
  std::exception_ptr failure_;
};

/// What fluids and bodies are asked alike.
template <class Base>
class CalledSolver : public Base {
 public:
  CalledSolver(CalledComponent& called, const auto& setup, Eigen::Index loads, std::size_t actuators = 0)
      : called_(called) {
    const std::string text = conversion::to_json(setup);
    called_.setup = nlohmann::json::parse(text);
    called_.kinematics.resize(static_cast<Eigen::Index>(setup.bodies.size()));
    called_.loads.resize(loads);
    called_.actuators = static_cast<std::int64_t>(actuators);
    called_.ask(request_to(COPEPOD_SETUP, text.c_str()));
  }
  void save(const std::string& path) override { called_.ask(request_to(COPEPOD_SAVE, path.c_str())); }
  void restore(const std::string& path) override { called_.ask(request_to(COPEPOD_RESTORE, path.c_str())); }
  SolverSummary summarise() override {
    SolverSummary summary;
    copepod_request request = request_to(COPEPOD_SUMMARISE);
    request.digest = &summary.digest;
    called_.ask(request);
    return summary;
  }

 protected:
  static void expect(auto&... answers) { (answers.setConstant(std::numeric_limits<double>::quiet_NaN()), ...); }

  CalledComponent& called_;
};

class CalledFluid final : public CalledSolver<FluidSolver> {
 public:
  CalledFluid(CalledComponent& called, const FluidSetup& setup) : CalledSolver(called, setup, setup.loads()) {}
  void exchange(const Kinematics& kinematics, Loads& loads) override {
    called_.kinematics = kinematics;
    expect(called_.loads.force_N, called_.loads.torque_N_m);
    copepod_request request = request_to(COPEPOD_EXCHANGE);
    request.step = kinematics.step;
    called_.ask(request);
    called_.loads.step = kinematics.step;
    loads = called_.loads;
  }
  void advance() override { called_.ask(request_to(COPEPOD_ADVANCE)); }
};

class CalledBodies final : public CalledSolver<BodySolver> {
 public:
  CalledBodies(CalledComponent& called, const BodySetup& setup)
      : CalledSolver(called, setup, static_cast<Eigen::Index>(setup.bodies.size()), setup.actuators.size()) {}
  [[nodiscard]] std::vector<double> driving_nodes() const override { return {0.0}; }
  void kinematics(Kinematics& kinematics) override {
    copepod_request request = request_to(COPEPOD_KINEMATICS);
    kinematics.step = -1;
    request.next_step = &kinematics.step;
    answered(request, kinematics);
  }
  void step(const AppliedLoads& applied, Kinematics& next) override {
    called_.loads = applied.hydrodynamic;
    copepod_request request = request_to(COPEPOD_STEP);
    request.step = applied.hydrodynamic.step;
    request.actuation = applied.actuation.data();
    answered(request, next);
    next.step = request.step + 1;
  }

 private:
  void answered(const copepod_request& request, Kinematics& kinematics) {
    Kinematics& answer = called_.kinematics;
    expect(answer.position_m, answer.orientation_wxyz, answer.velocity_m_per_s, answer.angular_velocity_rad_per_s);
    called_.ask(request);
    answer.step = kinematics.step;
    kinematics = answer;
  }
};

/// The component of this process; never destroyed: the kit's thread may outlast `main`.
CalledComponent* component = nullptr;

CalledComponent& opened() {
  require(component != nullptr, "no component is open. Call copepod_component_open.");
  return *component;
}

template <class Solver, class Setup, class Base>
Component<Setup, Base> served(CalledComponent& called, const Capabilities& capabilities) {
  return {capabilities, [&called](const Setup& setup, SolverContext& context) {
            called.context = &context;
            return std::make_unique<Solver>(called, setup);
          }};
}

}  // namespace
}  // namespace copepod

using namespace copepod;

int copepod_component_open(int argc, char** argv, const char* role, const char* name, const char* version,
                           const char* features) {
  return guarded([&] {
    require_arguments(argv, role, name, version, features);
    require(component == nullptr, "this process has a component already (one per process). Start another process.");
    const bool is_fluid = role == std::string("fluid");
    require(is_fluid || role == std::string("body"), "the role is neither fluid nor body. Use one of them.");
    Capabilities capabilities{name, version, {}};
    std::istringstream words(features);
    for (std::string word; words >> word;) capabilities.features.insert(word);
    CalledComponent& called = *(component = new CalledComponent);
    called.kit = std::thread([&called, argc, argv, is_fluid, capabilities] {
      const int code =
          is_fluid ? run_fluid_component(argc, argv, served<CalledFluid, FluidSetup, FluidSolver>(called, capabilities))
                   : run_body_component(argc, argv, served<CalledBodies, BodySetup, BodySolver>(called, capabilities));
      copepod_request end = request_to(COPEPOD_END);
      end.code = code;
      called.ask(end);
    });
  });
}

int copepod_component_next(copepod_request* request) {
  return guarded([&] {
    require_arguments(request);
    *request = opened().next();
  });
}

int copepod_component_fail(int code, const char* message) {
  return guarded([&] {
    require_arguments(message);
    require(code == static_cast<int>(ExitCode::solver_failed) || code == static_cast<int>(ExitCode::storage_failed),
            "the code is neither 70 nor 73. Use one of them.");
    opened().fail(code, message);
  });
}

int copepod_component_number(const char* path, double* value) {
  return guarded([&] {
    require_arguments(path, value);
    *value = opened().number(path);
  });
}

int copepod_component_report_progress() {
  return guarded([&] { opened().report_progress(); });
}
