// Measures what a coupling step costs on the wire: router to "fluid" and back, router to "body" and back,
// over ZeroMQ ipc between three processes, for one way of waiting. The fluid computes for `--bulk-us` after
// each reply, as a service does after its early reply; `--neighbours` processes burn a core each meanwhile,
// as other ranks do.
//
//   exchange_latency [--yield-us 0] [--bulk-us 0] [--neighbours 0] [--steps 5000] [--bodies 3] [--endpoint
//   ipc:///…]
//
// Prints: yield, bulk, neighbours, median and 99th percentile of the step [µs], and what is left beside the
// bulk update.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <iostream>
#include <string>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

#include <CLI/CLI.hpp>

#include "transport/zeromq.hpp"

namespace {

using namespace copepod::transport;
using Clock = std::chrono::steady_clock;

struct Measurement {
  int yield_us = 0;
  int bulk_us = 0;
  int neighbours = 0;
  int steps = 5000;
  int bodies = 3;
  std::string endpoint = "ipc:///tmp/copepod-latency-" + std::to_string(getpid());

  [[nodiscard]] WaitPolicy policy() const { return {std::chrono::microseconds(yield_us)}; }
  [[nodiscard]] std::vector<std::byte> message() const {
    return std::vector<std::byte>(static_cast<std::size_t>(bodies) * 13 * sizeof(double) + 64);
  }
};

void compute_for(int microseconds) {
  const auto end = Clock::now() + std::chrono::microseconds(microseconds);
  while (Clock::now() < end) {
  }
}

[[noreturn]] void answer(const Measurement& measurement, const std::string& name, int bulk_us) {
  const auto dealer = connect_dealer(measurement.endpoint, name, measurement.policy());
  Frame frame;
  dealer->send(measurement.message());
  for (;;) {
    if (!dealer->receive(frame, std::chrono::seconds(1))) continue;
    dealer->send(frame.bytes());
    compute_for(bulk_us);
  }
}

template <class Work>
pid_t in_child(Work work) {
  const pid_t pid = fork();
  if (pid == 0) work();
  return pid;
}

void ask(Router& router, const std::string& peer, Frame& frame, const std::vector<std::byte>& message) {
  router.send(peer, message);
  while (!router.receive(frame, std::chrono::seconds(1))) {
  }
}

std::vector<double> measure_steps_us(const Measurement& measurement) {
  const auto router = bind_router(measurement.endpoint, measurement.policy());
  const auto message = measurement.message();
  Frame frame;
  for (int greeted = 0; greeted < 2;) greeted += router->receive(frame, std::chrono::seconds(1)) ? 1 : 0;
  std::vector<double> steps_us;
  for (int step = 0; step < measurement.steps; ++step) {
    const auto start = Clock::now();
    ask(*router, "fluid", frame, message);
    ask(*router, "body", frame, message);
    steps_us.push_back(std::chrono::duration<double, std::micro>(Clock::now() - start).count());
  }
  return steps_us;
}

}  // namespace

int main(int argc, char** argv) {
  Measurement measurement;
  CLI::App app{"Cost of a coupling step on the wire"};
  app.add_option("--yield-us", measurement.yield_us);
  app.add_option("--bulk-us", measurement.bulk_us);
  app.add_option("--neighbours", measurement.neighbours);
  app.add_option("--steps", measurement.steps);
  app.add_option("--bodies", measurement.bodies);
  app.add_option("--endpoint", measurement.endpoint);
  CLI11_PARSE(app, argc, argv);

  std::vector<pid_t> children;
  children.push_back(in_child([&] { answer(measurement, "fluid", measurement.bulk_us); }));
  children.push_back(in_child([&] { answer(measurement, "body", 0); }));
  for (int i = 0; i < measurement.neighbours; ++i)
    children.push_back(in_child([] {
      for (;;) compute_for(1000);
    }));
  std::vector<double> steps_us = measure_steps_us(measurement);
  for (const pid_t child : children) {
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
  }
  std::sort(steps_us.begin(), steps_us.end());
  const double median = steps_us[steps_us.size() / 2];
  double sum = 0;
  for (const double step_us : steps_us) sum += step_us;
  std::cout << "yield_us " << measurement.yield_us << "  bulk_us " << measurement.bulk_us << "  neighbours "
            << measurement.neighbours << "  mean_us " << sum / static_cast<double>(steps_us.size())
            << "  median_us " << median << "  p99_us " << steps_us[steps_us.size() * 99 / 100] << "\n";
}
