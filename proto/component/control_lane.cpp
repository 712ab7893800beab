#include "component/control_lane.hpp"

#include <chrono>
#include <unistd.h>

#include "contract/errors.hpp"
#include "conversion/codec.hpp"
#include "system/process.hpp"

namespace copepod::component {

using session::Header;
using session::MessageKind;

namespace {

constexpr std::chrono::milliseconds kLaneSlice{100};
constexpr double kRepeatLaneHello_s = 1.0;
constexpr double kGrace_s = 2.0;  ///< for the solver's thread, after a stop request

/// Everything the thread owns.
class Conversation {
 public:
  Conversation(std::unique_ptr<transport::Dealer> dealer, const Vitals& vitals, spdlog::logger& log,
               session::Hello hello, session::OrphanPatience patience)
      : dealer_(std::move(dealer)), vitals_(vitals), log_(log), hello_(std::move(hello)), patience_(patience) {
    hello_.lane = session::Lane::control;
  }

  void run(const std::atomic<bool>& leaving) {
    while (!leaving.load()) {
      if (!welcomed_) say_hello();
      if (dealer_->receive(frame_, kLaneSlice)) handle();
      if (welcomed_) look_for_coupler();
      enforce_stop();
    }
  }

 private:
  void say_hello() {
    if (now_s() - last_hello_s_ < kRepeatLaneHello_s) return;
    last_hello_s_ = now_s();
    dealer_->send(encoder_.encode(Header{}, hello_));
  }

  void handle() {
    try {
      const MessageKind kind = decoder_.parse(frame_.bytes());
      if (kind == MessageKind::welcome) accept_welcome();
      const bool ours = decoder_.header().session_id == header_.session_id && decoder_.header().epoch == header_.epoch;
      if (!welcomed_ || !ours) return;
      if (kind == MessageKind::ping) answer_ping();
      if (kind == MessageKind::abort) accept_abort();
    } catch (const Error& error) {
      log_.warn("On the control lane: {}", error.what());
    }
  }

  void accept_welcome() {
    session::Welcome welcome;
    decoder_.read(welcome);
    header_.session_id = welcome.session_id;
    header_.epoch = welcome.epoch;
    welcomed_ = true;
    signs_ = {now_s(), -1, now_s()};
  }

  void answer_ping() {
    session::Ping ping;
    decoder_.read(ping);
    signs_.last_ping_s = now_s();
    dealer_->send(encoder_.encode(header_, vitals_.pong(ping)));
  }

  void accept_abort() {
    FailureReport report;
    decoder_.read(report);
    log_.error("Aborted by the coupler: {}", report.reason);
    request_stop(report.code);
  }

  void look_for_coupler() {
    signs_ = on_look(signs_, dealer_->connected(), patience_, now_s());
    const std::string reason = orphan_reason(signs_, patience_, now_s());
    if (reason.empty() || vitals_.context.stop_requested() != 0) return;
    log_.error("{}", reason);
    request_stop(ExitCode::component_lost);
  }

  void request_stop(ExitCode code) { vitals_.context.request_stop(static_cast<int>(code)); }

  /// The solver may be deep in a computation or in MPI; its result is no longer needed.
  void enforce_stop() {
    if (vitals_.context.stop_requested() == 0) return;
    if (stopping_since_s_ < 0) stopping_since_s_ = now_s();
    if (now_s() - stopping_since_s_ < kGrace_s) return;
    log_.error("The solver did not stop within {} s; ending the process.", kGrace_s);
    log_.flush();
    _exit(vitals_.context.stop_requested());
  }

  std::unique_ptr<transport::Dealer> dealer_;
  const Vitals& vitals_;
  spdlog::logger& log_;
  session::Hello hello_;
  session::OrphanPatience patience_;
  transport::Frame frame_;
  conversion::Encoder encoder_;
  conversion::Decoder decoder_;
  Header header_;
  bool welcomed_ = false;
  double last_hello_s_ = -1e300;
  double stopping_since_s_ = -1;
  session::CouplerSigns signs_;
};

}  // namespace

ControlLane::ControlLane(std::unique_ptr<transport::Dealer> dealer, const Vitals& vitals, spdlog::logger& log,
                         session::Hello hello, session::OrphanPatience patience) {
  auto conversation = std::make_unique<Conversation>(std::move(dealer), vitals, log, std::move(hello), patience);
  thread_ = std::thread([this, conversation = std::move(conversation)] {
    block_signals();
    conversation->run(leaving_);
  });
}

ControlLane::~ControlLane() {
  leaving_ = true;
  thread_.join();
}

}  // namespace copepod::component
