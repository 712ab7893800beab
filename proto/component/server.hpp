#pragma once

#include <memory>

#include <spdlog/logger.h>

#include "component/control_lane.hpp"
#include "contract/component.hpp"
#include "contract/errors.hpp"
#include "conversion/codec.hpp"
#include "session/component_session.hpp"
#include "session/messages.hpp"
#include "session/transition_table.hpp"
#include "transport/lanes.hpp"

namespace copepod::component {

/// What a message asks for, and how to answer it.
struct Request {
  session::Work work;
  const conversion::Decoder& message;
  const session::Header& header;  ///< of the reply
  conversion::Encoder& encoder;   ///< owns the bytes of the reply
};

/// A solver behind the messages of its role.
class ServedSolver {
 public:
  virtual ~ServedSolver() = default;

  [[nodiscard]] virtual session::Role role() const = 0;

  /// Does what a request asks for, up to the reply, and returns that.
  /// @throws whatever the solver throws; MalformedMessage if the request makes no sense
  virtual conversion::Bytes perform(const Request& request) = 0;

  /// The bulk update after the reply to `work`, if there is one.
  virtual void follow_up(session::Work /*work*/) {}
};

/// What both roles do alike.
template <class Setup, class Solver>
class Served : public ServedSolver {
 public:
  /// Both outlive this object.
  Served(const Component<Setup, Solver>& component, SolverContext& context)
      : component_(component), context_(context) {}

  conversion::Bytes perform(const Request& request) final;

 protected:
  /// The answer to the setup, now that the solver is there.
  virtual session::Configured configured(const Setup& setup) = 0;

  /// Does what only this role is asked for.
  virtual conversion::Bytes exchange(const Request& request) = 0;

  const Component<Setup, Solver>& component_;
  SolverContext& context_;
  std::unique_ptr<Solver> solver_;
  Eigen::Index bodies_ = 0;
  Kinematics kinematics_;
};

/// A FluidSolver behind the messages of the fluid role. Kinematics are answered with loads first; the bulk
/// update comes after the reply, while the others work.
class ServedFluid final : public Served<FluidSetup, FluidSolver> {
 public:
  using Served::Served;
  [[nodiscard]] session::Role role() const override { return session::Role::fluid; }
  void follow_up(session::Work work) override {
    if (work == session::Work::compute_loads) solver_->advance();
  }

 private:
  session::Configured configured(const FluidSetup& setup) override;
  conversion::Bytes exchange(const Request& request) override;

  Eigen::Index columns_ = 0;  ///< of the loads
  FlowSampling flow_;
  Loads loads_;
};

/// A Controller behind the messages of its role.
class ServedController final : public Served<ControllerSetup, Controller> {
 public:
  using Served::Served;
  [[nodiscard]] session::Role role() const override { return session::Role::controller; }

 private:
  session::Configured configured(const ControllerSetup& setup) override;
  conversion::Bytes exchange(const Request& request) override;

  std::size_t actuators_ = 0;
  Eigen::Index flow_ = 0;  ///< values of a sample
  Observation observation_;
};

/// A BodySolver behind the messages of the body role.
class ServedBody final : public Served<BodySetup, BodySolver> {
 public:
  using Served::Served;
  [[nodiscard]] session::Role role() const override { return session::Role::body; }

 private:
  session::Configured configured(const BodySetup& setup) override;
  conversion::Bytes exchange(const Request& request) override;

  Eigen::Index actuators_ = 0;
  Eigen::Index driving_nodes_ = 1;
  AppliedLoads applied_;
};

/// The data lane of a component: sends Hello, then answers requests until the run ends. Messages that were
/// damaged on their way count as lost.
///
/// The session table decides what a message means; this class does what it decides. Single-threaded: a
/// request that arrives during a bulk update waits in the transport's queue.
class Server {
 public:
  /// @param hello  to send; its lane is set here
  /// All references outlive the server.
  Server(transport::Dealer& dealer, ServedSolver& solver, Vitals& vitals, spdlog::logger& log, session::Hello hello,
         double connect_deadline_s);

  /// @return how the process should end; never throws
  ExitCode run() noexcept;

 private:
  void shake_hands();
  void stay_for_repeated_goodbyes();
  void handle(const transport::Frame& frame);
  void act(const session::Action& action);
  void do_work(const session::Action& action);
  bool wait_for_message(double seconds);
  void enter(session::Phase phase);
  void send(std::span<const std::byte> bytes);
  void give_up(ExitCode code, const char* reason);
  /// @param step  negative: the current one
  void fail(ExitCode code, const std::string& reason, int rank = 0, std::int64_t step = -1);
  [[nodiscard]] session::Header header(std::uint64_t sequence) const {
    return {.session_id = session_.session_id, .epoch = session_.epoch, .sequence = sequence};
  }

  transport::Dealer& dealer_;
  ServedSolver& solver_;
  Vitals& vitals_;
  spdlog::logger& log_;
  session::Hello hello_;
  double connect_deadline_s_;

  session::ComponentSession session_;
  transport::Frame frame_;
  conversion::Decoder decoder_;
  conversion::Encoder replies_;  ///< keeps the bytes of the last reply for a request that is repeated
  conversion::Encoder handshake_;
  std::span<const std::byte> last_reply_;
  Timeline::Clock::time_point phase_since_ = Timeline::Clock::now();
  ExitCode exit_code_ = ExitCode::finished;
};

}  // namespace copepod::component
