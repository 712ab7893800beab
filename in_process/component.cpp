#include <condition_variable>
#include <cstdlib>
#include <limits>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "c_border.hpp"
#include "component/run_component.hpp"
#include "contract/features.hpp"
#include "conversion/codec.hpp"
#include "conversion/limits.hpp"
#include "copepod_component.h"

namespace copepod {
namespace {

/// A component whose solver is the caller of the C interface. The kit serves it in a thread of its own, which asks one
/// request at a time and waits for the answer.
class CalledComponent {
 public:
  // Of the kit's thread.

  /// @throws what the caller answers by copepod_component_fail
  void ask(std::int32_t kind, const char* text = nullptr, int code = 0) {
    std::unique_lock lock(mutex_);
    request_.kind = kind;
    request_.code = code;
    request_.step = loads.step;
    request_.bodies = kinematics.bodies();
    request_.loads = loads.bodies();
    request_.actuators = actuation.rows();
    request_.text = text;
    request_.position_m = kinematics.position_m.data();
    request_.orientation_wxyz = kinematics.orientation_wxyz.data();
    request_.velocity_m_per_s = kinematics.velocity_m_per_s.data();
    request_.angular_velocity_rad_per_s = kinematics.angular_velocity_rad_per_s.data();
    request_.force_N = loads.force_N.data();
    request_.torque_N_m = loads.torque_N_m.data();
    request_.actuation = actuation.data();
    request_.digest = &summary.digest;
    request_.next_step = &kinematics.step;
    state_ = State::offered;
    changed_.notify_all();
    if (kind == COPEPOD_END) return;
    changed_.wait(lock, [&] { return state_ == State::kit_works; });
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
  }

  Kinematics kinematics;  ///< asked for or to be answered, like the loads
  Loads loads;
  Eigen::MatrixXd actuation;  ///< of one node
  SolverSummary summary;      ///< its digest
  SolverContext* context = nullptr;
  nlohmann::json setup;

  // Of the caller's thread.

  std::thread kit;

  copepod_request next() {
    const std::unique_lock in_a_call = only_call();
    std::unique_lock lock(mutex_);
    require(state_ != State::ended, "the component has ended (COPEPOD_END was its last request). End the process.");
    if (state_ == State::asked) give_back();
    changed_.wait(lock, [&] { return state_ == State::offered; });
    state_ = request_.kind == COPEPOD_END ? State::ended : State::asked;
    lock.unlock();
    if (request_.kind == COPEPOD_END) kit.join();  // the process is about to end
    return request_;
  }

  void fail(int code, const std::string& reason) {
    const std::unique_lock in_a_call = while_asked();
    const std::lock_guard lock(mutex_);
    failure_ = code == static_cast<int>(ExitCode::storage_failed)
                   ? std::make_exception_ptr(StorageError(reason))
                   : std::make_exception_ptr(SolverError(reason, 0, request_.step));
    give_back();
  }

  [[nodiscard]] double number(const std::string& path) {
    const std::unique_lock in_a_call = while_asked();
    const nlohmann::json& value = at(path);
    const std::string text = value.is_string() ? value.get<std::string>() : value.dump();  // text: also of 64 bits
    char* end = nullptr;
    const double number = std::strtod(text.c_str(), &end);
    require(!text.empty() && *end == '\0', path + " of the setup is not a number. Its text has the names.");
    return number;
  }
  void report_progress() {
    const std::unique_lock in_a_call = while_asked();
    context->report_progress();
  }

 private:
  enum class State { kit_works, offered, asked, ended };  ///< asked: the caller has a request that is not answered

  [[nodiscard]] const nlohmann::json& at(const std::string& path) const {
    try {
      return setup.at(nlohmann::json::json_pointer(path));
    } catch (const nlohmann::json::exception&) {  // no path, or one that leads nowhere
      throw Misuse("the setup has no " + path + " (see its text). Use a name from there.");
    }
  }
  std::unique_lock<std::mutex> only_call() {
    std::unique_lock lock(in_a_call_, std::try_to_lock);
    require(lock.owns_lock(), "another thread is in a call for the component (one at a time). Wait for it.");
    return lock;
  }
  /// The same, with a request that is not answered: the kit's thread waits, and what it made stays as it is.
  std::unique_lock<std::mutex> while_asked() {
    std::unique_lock in_a_call = only_call();
    const std::lock_guard lock(mutex_);
    require(state_ == State::asked, "no request waits for an answer (next gives one). Call copepod_component_next.");
    return in_a_call;
  }
  void give_back() {
    state_ = State::kit_works;
    changed_.notify_all();
  }

  std::mutex in_a_call_;
  std::mutex mutex_;  ///< of what follows
  std::condition_variable changed_;
  State state_ = State::kit_works;
  copepod_request request_{};
  std::exception_ptr failure_;
};

/// What fluids and bodies are asked alike.
template <class Base>
class CalledSolver : public Base {
 public:
  CalledSolver(CalledComponent& called, const auto& setup, Eigen::Index loads, Eigen::Index actuators = 0)
      : called_(called) {
    const std::string text = conversion::to_json(setup);
    called_.setup = nlohmann::json::parse(text);
    called_.kinematics.resize(setup.bodies.size());
    called_.loads.resize(loads);
    called_.actuation.resize(actuators, 1);
    called_.ask(COPEPOD_SETUP, text.c_str());
  }
  void save(const std::string& path) override { called_.ask(COPEPOD_SAVE, path.c_str()); }
  void restore(const std::string& path) override { called_.ask(COPEPOD_RESTORE, path.c_str()); }
  SolverSummary summarise() override {
    called_.ask(COPEPOD_SUMMARISE);
    return std::exchange(called_.summary, {});
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
    called_.loads.step = kinematics.step;
    called_.ask(COPEPOD_EXCHANGE);
    loads = called_.loads;
  }
  void advance() override { called_.ask(COPEPOD_ADVANCE); }
};

class CalledBodies final : public CalledSolver<BodySolver> {
 public:
  CalledBodies(CalledComponent& called, const BodySetup& setup)
      : CalledSolver(called, setup, setup.bodies.size(), setup.actuators.size()) {}
  [[nodiscard]] std::vector<double> driving_nodes() const override { return {0.0}; }
  void kinematics(Kinematics& kinematics) override { answered(COPEPOD_KINEMATICS, kinematics); }
  void step(const AppliedLoads& applied, Kinematics& next) override {
    called_.loads = applied.hydrodynamic;
    called_.actuation = applied.actuation;
    answered(COPEPOD_STEP, next);
    next.step = applied.hydrodynamic.step + 1;
  }

 private:
  void answered(std::int32_t kind, Kinematics& kinematics) {
    Kinematics& answer = called_.kinematics;
    expect(answer.position_m, answer.orientation_wxyz, answer.velocity_m_per_s, answer.angular_velocity_rad_per_s);
    answer.step = -1;
    called_.ask(kind);
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
    require(argc >= 1, "argc is below 1 (the program's name comes first). Pass the command line of the process.");
    for (int i = 0; i < argc; ++i) require_arguments(argv[i]);
    for (const std::string text : {name, version, features})
      require(conversion::as_utf8(text, text.size()) == text, "a text is not UTF-8 (wrongly encoded). Give UTF-8.");
    const Capabilities capabilities{name, version, features_in(features)};
    CalledComponent& called = *(component = new CalledComponent);
    called.kit = std::thread([&called, argc, argv, is_fluid, capabilities] {
      const int code =
          is_fluid ? run_fluid_component(argc, argv, served<CalledFluid, FluidSetup, FluidSolver>(called, capabilities))
                   : run_body_component(argc, argv, served<CalledBodies, BodySetup, BodySolver>(called, capabilities));
      called.ask(COPEPOD_END, nullptr, code);
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
