#include "remote/link.hpp"

#include <chrono>
#include <future>

#include "recording/recording_router.hpp"
#include "remote/exchange.hpp"
#include "transport/zeromq.hpp"

namespace copepod {

using session::MessageKind;
using session::Role;

namespace {

constexpr std::chrono::milliseconds kMoment{20};  ///< most work is over by then

session::Patience patience_of(const LinkSettings& settings) {
  session::Patience patience;
  patience.silence_s = settings.silence_s;
  patience.progress_deadline_s = settings.progress_deadline_s;
  return patience;
}

std::optional<transport::CouplerKeys> keys_of(const LinkSettings& settings) {
  if (settings.key_file.empty()) return std::nullopt;
  return transport::read_coupler_keys(settings.key_file);
}

std::unique_ptr<transport::Router> make_router(const LinkSettings& settings) {
  auto router = transport::bind_router(settings.endpoint, transport::kDataLanePolicy, keys_of(settings));
  if (settings.wire_file.empty()) return router;
  return std::make_unique<recording::RecordingRouter>(std::move(router), settings.wire_file);
}

}  // namespace

Link::Link(const LinkSettings& settings) : Link(settings, make_router(settings)) {}

Link::Link(const LinkSettings& settings, std::unique_ptr<transport::Router> router)
    : connect_deadline_s_(settings.connect_deadline_s),
      router_(std::move(router)),
      parties_(std::make_unique<remote::Parties>()),
      exchange_(std::make_unique<remote::Exchange>(*router_, *parties_, settings.session,
                                                   patience_of(settings), settings.stop_signal)) {}

Link::~Link() = default;

void Link::await_components() { exchange_->await_components(connect_deadline_s_); }

const Capabilities& Link::fluid_capabilities() const { return parties_->of(Role::fluid).hello.capabilities; }
const Capabilities& Link::body_capabilities() const { return parties_->of(Role::body).hello.capabilities; }

void Link::stay_in_touch_during(const std::function<void()>& work) {
  std::future<void> done = std::async(std::launch::async, work);
  while (done.wait_for(kMoment) != std::future_status::ready) exchange_->attend();
  done.get();
}

void Link::finish() {
  for (const Role role : {Role::fluid, Role::body}) {
    const std::int64_t step = parties_->of(role).session.step;
    exchange_->ask(role, MessageKind::finish, step,
                   [](conversion::Encoder& encoder, const session::Header& header) {
                     return encoder.encode(header, MessageKind::finish);
                   });
  }
}

void Link::abort(const FailureReport& report) noexcept {
  try {
    exchange_->abort(report);
  } catch (...) {  // the run is over already; components notice by themselves that the coupler is gone
  }
}

}  // namespace copepod
