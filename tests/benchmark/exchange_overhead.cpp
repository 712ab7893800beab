// What an exchange costs, kinematics to a fluid and its loads back, beside a plain ZeroMQ echo of the same
// message sizes in the same moment, and beside the same exchange without any transport; and what it costs where
// everything is in one process: docs/results/exchange.md.
//
//   exchange_overhead [--exchanges 4000] [--any-result]
//
// Ends with 1 if a target of the project is missed, unless any result will do. Starts itself as the other
// process: `echo …` and `fluid …`. `alone BODIES EXCHANGES` makes exchanges without any transport and measures nothing:
// tests/benchmark/instructions_test.py counts their instructions.
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <sstream>
#include <unistd.h>
#include <vector>

#include <CLI/CLI.hpp>
#include <zmq.hpp>

#include "component/run_component.hpp"
#include "component/server.hpp"
#include "conversion/codec.hpp"
#include "coupled_run.hpp"
#include "fake_programs.hpp"
#include "ranks/distributed_fluid.hpp"
#include "ranks/thread_ranks.hpp"
#include "run_keys.hpp"
#include "session/component_session.hpp"
#include "session/coupler_session.hpp"

namespace {

using namespace copepod;
using Clock = std::chrono::steady_clock;
using protocol_test::ChildProcess;
using protocol_test::RunKeys;

/// Loads of nothing: what remains is the exchange.
class SilentFluid final : public FluidSolver {
 public:
  void exchange(const Kinematics& kinematics, Loads& loads) override {
    loads.step = kinematics.step;
    if (loads.bodies() == kinematics.bodies()) return;
    loads.resize(kinematics.bodies());
    loads.force_N.setZero();
    loads.torque_N_m.setZero();
  }
  void advance() override {}
  void save(const std::string&) override {}
  void restore(const std::string&) override {}
  SolverSummary summarise() override { return {}; }
};

FluidComponent silent_component() {
  return {{"silent", "1.0", {"solver:vacuum"}},
          [](const FluidSetup&, SolverContext&) { return std::make_unique<SilentFluid>(); }};
}

FluidSetup fluid_setup(Eigen::Index bodies) {
  FluidSetup setup = protocol_test::two_spheres_in_fluid();
  setup.bodies.assign(static_cast<std::size_t>(bodies), setup.bodies.front());
  return setup;
}

Kinematics kinematics_of(Eigen::Index bodies) {
  Kinematics kinematics;
  kinematics.resize(bodies);
  kinematics.step = 0;
  kinematics.position_m.setConstant(1.5e-5);
  kinematics.orientation_wxyz.setConstant(0.5);
  kinematics.velocity_m_per_s.setConstant(1e-3);
  kinematics.angular_velocity_rad_per_s.setConstant(0.1);
  return kinematics;
}

struct Statistics {
  double median_us = 0;
  double worst_percent_us = 0;  ///< 99 of 100 are faster
};

Statistics statistics_of(std::vector<double> samples_us) {
  std::sort(samples_us.begin(), samples_us.end());
  return {samples_us[samples_us.size() / 2], samples_us[samples_us.size() * 99 / 100]};
}

template <class Work>
double time_us(Work work) {
  const auto start = Clock::now();
  work();
  return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
}

/// One way to reach another process.
struct Wire {
  std::string name;
  std::string endpoint;
  std::string echo_endpoint, keeping_echo_endpoint;
  bool has_keys = false;
};

std::string own_program() { return std::filesystem::read_symlink("/proc/self/exe").string(); }

/// What the receivers of a plain echo do with a message.
enum class Receipt { ignored, kept };

std::string word_for(Receipt receipt) { return receipt == Receipt::kept ? "keep" : "ignore"; }

/// Receives one part of a message; a kept one is copied to its user's memory.
void receive_part(zmq::socket_t& socket, Receipt receipt, std::vector<std::byte>& memory) {
  if (receipt == Receipt::kept) {
    static_cast<void>(socket.recv(zmq::buffer(memory)));
  } else {
    zmq::message_t message;
    static_cast<void>(socket.recv(message));
  }
}

/// The plainest exchange there is: ROUTER sends and receives, a DEALER in another process answers. No
/// wait has a deadline, and the bytes are not read; `Receipt::kept` copies them from ZeroMQ's memory to the
/// receiver's own, as zmq_recv does.
class PlainEcho {
 public:
  PlainEcho(const Wire& wire, const std::string& endpoint, Receipt receipt, std::size_t request_bytes,
            std::size_t reply_bytes, const RunKeys& keys)
      : socket_(context_, zmq::socket_type::router), receipt_(receipt), request_(request_bytes), reply_(reply_bytes) {
    socket_.set(zmq::sockopt::linger, 0);
    if (wire.has_keys) {
      socket_.set(zmq::sockopt::curve_server, true);
      socket_.set(zmq::sockopt::curve_secretkey, keys.secret_of("coupler"));
    }
    socket_.bind(endpoint);
    std::vector<std::string> command{
        own_program(), "echo", endpoint, word_for(receipt), std::to_string(request_bytes), std::to_string(reply_bytes)};
    if (wire.has_keys) {
      for (const auto& word : {keys.public_of("fluid"), keys.secret_of("fluid"), keys.public_of("coupler")})
        command.push_back(word);  // of this measurement only: they guard nothing
    }
    child_ = std::make_unique<ChildProcess>(command);
    receive();
  }

  void exchange() {
    socket_.send(zmq::buffer(peer_), zmq::send_flags::sndmore);
    socket_.send(zmq::buffer(request_));
    receive();
  }

 private:
  void receive() {
    zmq::message_t peer;
    static_cast<void>(socket_.recv(peer));
    receive_part(socket_, receipt_, reply_);
    peer_ = peer.to_string();
  }

  zmq::context_t context_;
  zmq::socket_t socket_;
  Receipt receipt_;
  std::vector<std::byte> request_, reply_;
  std::string peer_;
  std::unique_ptr<ChildProcess> child_;
};

int echo(int argc, char** argv) {
  zmq::context_t context;
  zmq::socket_t socket(context, zmq::socket_type::dealer);
  socket.set(zmq::sockopt::routing_id, "echo");
  const std::vector<std::string> words(argv + 2, argv + argc);
  if (words.size() == 7) {
    socket.set(zmq::sockopt::curve_publickey, words[4]);
    socket.set(zmq::sockopt::curve_secretkey, words[5]);
    socket.set(zmq::sockopt::curve_serverkey, words[6]);
  }
  socket.connect(words.at(0));
  const Receipt receipt = words.at(1) == word_for(Receipt::kept) ? Receipt::kept : Receipt::ignored;
  std::vector<std::byte> request(std::stoul(words.at(2)));
  const std::vector<std::byte> reply(std::stoul(words.at(3)));
  for (;;) {
    socket.send(zmq::buffer(reply));
    receive_part(socket, receipt, request);
  }
}

/// Our exchange with a silent fluid in another process.
class OurExchange {
 public:
  OurExchange(const Wire& wire, Eigen::Index bodies, const RunKeys& keys) : kinematics_(kinematics_of(bodies)) {
    coupler::LinkSettings settings;
    settings.endpoint = wire.endpoint;
    settings.session = "secret";
    if (wire.has_keys) settings.key_file = keys.file_of("coupler");
    link_ = std::make_unique<coupler::Link>(settings);
    fluid_process_ = start({own_program(), "fluid"}, "fluid", wire, keys);
    body_process_ = start({protocol_test::kFakeBody}, "body", wire, keys);
    link_->await_components();
    fluid_ = std::make_unique<coupler::RemoteFluid>(*link_, fluid_setup(bodies), 0);
  }

  ~OurExchange() { link_->finish(); }

  void exchange() {
    fluid_->exchange(kinematics_, loads_);
    ++kinematics_.step;
  }

 private:
  static std::unique_ptr<ChildProcess> start(std::vector<std::string> command, const std::string& role,
                                             const Wire& wire, const RunKeys& keys) {
    for (const char* word : {"--endpoint", wire.endpoint.c_str(), "--session", "secret", "--log-level", "off"})
      command.emplace_back(word);
    if (wire.has_keys) command.insert(command.end(), {"--keys", keys.file_of(role)});
    return std::make_unique<ChildProcess>(command);
  }

  std::unique_ptr<coupler::Link> link_;
  std::unique_ptr<ChildProcess> fluid_process_, body_process_;
  std::unique_ptr<coupler::RemoteFluid> fluid_;
  Kinematics kinematics_;
  Loads loads_;
};

/// Everything of an exchange but the transport, both ends in this thread: encoding, checksums, decoding,
/// checks, states.
class ExchangeWithoutTransport {
 public:
  explicit ExchangeWithoutTransport(Eigen::Index bodies) : kinematics_(kinematics_of(bodies)) {
    component_session_.state = session::State::connected;
    component_session_ = on_message(component_session_, session::MessageKind::welcome, {}).session;
    coupler_session_ = welcomed(coupler_session_, 0, 0);
    const FluidSetup setup = fluid_setup(bodies);
    ask(session::MessageKind::fluid_setup,
        [&](const session::Header& header) { return request_encoder_.encode(header, setup); });
  }

  void exchange() {
    ask(session::MessageKind::kinematics,
        [&](const session::Header& header) { return request_encoder_.encode(header, kinematics_); });
    reply_decoder_.read(loads_, kinematics_.bodies());
    ++kinematics_.step;
  }

  [[nodiscard]] std::size_t request_bytes() const { return request_bytes_; }
  [[nodiscard]] std::size_t reply_bytes() const { return reply_bytes_; }

 private:
  template <class Encode>
  void ask(session::MessageKind request, Encode encode) {
    coupler_session_ = session::ask(coupler_session_, request, kinematics_.step).session;
    const auto request_frame = encode(header_of(coupler_session_));
    const auto kind = request_decoder_.parse(request_frame);
    const session::Outcome outcome = on_message(component_session_, kind, request_decoder_.header());
    session::Header reply = request_decoder_.header();
    const auto reply_frame = fluid_.perform({outcome.action.work, request_decoder_, reply, reply_encoder_});
    component_session_ = on_event(outcome.session, session::LocalEvent::work_done).session;
    coupler_session_ = hear(coupler_session_, reply_decoder_.parse(reply_frame), reply_decoder_.header()).session;
    request_bytes_ = request_frame.size();
    reply_bytes_ = reply_frame.size();
  }

  FluidComponent component_ = silent_component();
  SolverContext context_;
  component::ServedFluid fluid_{component_, context_};
  session::ComponentSession component_session_;
  session::CouplerSession coupler_session_;
  conversion::Encoder request_encoder_, reply_encoder_;
  conversion::Decoder request_decoder_, reply_decoder_;
  Kinematics kinematics_;
  Loads loads_;
  std::size_t request_bytes_ = 0, reply_bytes_ = 0;
};

struct Row {
  std::string wire;
  Eigen::Index bodies = 0;
  Statistics ours, echo, keeping_echo;
  double own_cost_us = 0;
  [[nodiscard]] double ratio() const { return ours.median_us / echo.median_us; }
  [[nodiscard]] double ratio_to_keeping() const { return ours.median_us / keeping_echo.median_us; }
};

/// Blocks of all in alternation, so that what else happens on the machine meets all of them.
Row measure(const Wire& wire, Eigen::Index bodies, int exchanges) {
  constexpr int blocks = 20;
  const RunKeys keys;
  ExchangeWithoutTransport without_transport(bodies);
  std::vector<double> own_us;
  for (int i = 0; i < 200; ++i) own_us.push_back(time_us([&] { without_transport.exchange(); }));
  const std::size_t request_bytes = without_transport.request_bytes();
  const std::size_t reply_bytes = without_transport.reply_bytes();
  OurExchange ours(wire, bodies, keys);
  PlainEcho echo(wire, wire.echo_endpoint, Receipt::ignored, request_bytes, reply_bytes, keys);
  PlainEcho keeping(wire, wire.keeping_echo_endpoint, Receipt::kept, request_bytes, reply_bytes, keys);
  std::vector<double> ours_us, echo_us, keeping_us;
  const auto time_block = [](auto& exchanging, int count, std::vector<double>& samples_us) {
    for (int i = 0; i < count; ++i) samples_us.push_back(time_us([&] { exchanging.exchange(); }));
  };
  const auto time_all = [&](int count) {
    time_block(ours, count, ours_us);
    time_block(echo, count, echo_us);
    time_block(keeping, count, keeping_us);
  };
  time_all(20);  // until all memory is in use
  for (std::vector<double>* samples : {&ours_us, &echo_us, &keeping_us}) samples->clear();
  for (int block = 0; block < blocks; ++block) time_all(std::max(1, exchanges / blocks));
  return {wire.name,
          bodies,
          statistics_of(ours_us),
          statistics_of(echo_us),
          statistics_of(keeping_us),
          statistics_of(own_us).median_us};
}

/// The targets of the project; empty if the row meets its.
std::string missed_target(const Row& row) {
  if (row.bodies == 3 && row.ratio() > 1.3) return "more than 1.3 times the echo";
  if (row.bodies == 3 && row.own_cost_us > 10) return "more than 10 µs of its own";
  if (row.bodies == 1000 && row.own_cost_us > 100) return "more than 100 µs of its own";
  if (row.bodies == 10000 && row.wire == "ipc" && row.ours.median_us > 2000) return "more than 2 ms";
  return {};
}

/// Prints the table; whether all targets are met.
bool compare(int exchanges) {
  const TemporaryFolder folder;
  const int port = 20000 + getpid() % 12000;  // below those that the kernel gives away
  const auto at = [](int number) { return "tcp://127.0.0.1:" + std::to_string(number); };
  const std::array wires = {Wire{"ipc", "ipc://" + folder.path("ours"), "ipc://" + folder.path("echo"),
                                 "ipc://" + folder.path("keeping"), false},
                            Wire{"tcp", at(port), at(port + 1), at(port + 2), false},
                            Wire{"tcp + CURVE", at(port + 3), at(port + 4), at(port + 5), true}};
  std::cout << "| wire | bodies | exchange median | 99 % | plain echo median | 99 % | ratio | echo that keeps "
               "what it gets | ratio | without transport | |\n"
               "|---|---|---|---|---|---|---|---|---|---|---|\n"
            << std::fixed;
  bool all_met = true;
  for (const Wire& wire : wires) {
    for (const Eigen::Index bodies : {3, 100, 1000, 10000}) {
      const Row row = measure(wire, bodies,
                              bodies <= 100    ? exchanges
                              : bodies == 1000 ? exchanges / 4
                                               : exchanges / 20);
      const std::string missed = missed_target(row);
      all_met = all_met && missed.empty();
      std::cout << "| " << row.wire << " | " << row.bodies << std::setprecision(0) << " | " << row.ours.median_us
                << " µs | " << row.ours.worst_percent_us << " µs | " << row.echo.median_us << " µs | "
                << row.echo.worst_percent_us << " µs | " << std::setprecision(2) << row.ratio() << " | "
                << std::setprecision(0) << row.keeping_echo.median_us << " µs | " << std::setprecision(2)
                << row.ratio_to_keeping() << " | " << std::setprecision(1) << row.own_cost_us << " µs | " << missed
                << " |" << std::endl;
    }
  }
  return all_met;
}

/// One rank of a silent fluid that sums its loads over the ranks, like the lattice Boltzmann fluid.
class SummingFluid final : public FluidSolver {
 public:
  SummingFluid(const FluidSetup& setup, fluid::Communicator& ranks)
      : ranks_(ranks), sums_(2 * (8 * setup.bodies.size() + 3)) {}
  void exchange(const Kinematics& kinematics, Loads& loads) override {
    ranks_.sum_to_leader(sums_);
    silent_.exchange(kinematics, loads);
  }
  void advance() override {}
  void save(const std::string&) override {}
  void restore(const std::string&) override {}
  SolverSummary summarise() override { return {}; }

 private:
  fluid::Communicator& ranks_;
  std::vector<std::int64_t> sums_;
  SilentFluid silent_;
};

/// Of one exchange with a fluid whose ranks are threads of this process; they have nothing else to do.
Statistics measure_in_one_process(int ranks, Eigen::Index bodies, int exchanges) {
  const auto make_solver = [](const FluidSetup& setup, fluid::Communicator& own) {
    return std::make_unique<SummingFluid>(setup, own);
  };
  SolverContext context;
  fluid::ThreadRanks team(ranks, context, [&](fluid::Communicator& own) {
    std::atomic<std::int64_t> step{0};
    fluid::follow(own, make_solver, step);
  });
  std::vector<double> samples_us;
  {
    fluid::DistributedFluid fluid(fluid_setup(bodies), team.leader(), make_solver);
    Kinematics kinematics = kinematics_of(bodies);
    Loads loads;
    for (; kinematics.step < exchanges; ++kinematics.step)
      samples_us.push_back(time_us([&] {
        fluid.exchange(kinematics, loads);
        fluid.advance();
      }));
  }
  dismiss_followers(team.leader());
  return statistics_of(samples_us);
}

/// Prints the table; whether the target is met.
bool compare_in_one_process(int exchanges) {
  std::cout << "\n| ranks in one process | bodies | exchange median | 99 % | |\n|---|---|---|---|---|\n";
  bool met = true;
  for (const int ranks : {1, 2}) {
    for (const Eigen::Index bodies : {3, 100, 1000, 10000}) {
      const Statistics measured = measure_in_one_process(ranks, bodies, exchanges);
      const bool is_met = bodies > 3 || measured.median_us <= 10.0;
      met = met && is_met;
      std::cout << "| " << ranks << " | " << bodies << std::setprecision(1) << " | " << measured.median_us << " µs | "
                << measured.worst_percent_us << " µs | " << (is_met ? "" : "more than 10 µs") << " |" << std::endl;
    }
  }
  return met;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string role = argc > 1 ? argv[1] : "";
  if (role == "echo") return echo(argc, argv);
  if (role == "fluid") return run_fluid_component(argc - 1, argv + 1, silent_component());
  if (role == "alone" && argc == 4) {
    ExchangeWithoutTransport alone(std::atoi(argv[2]));
    for (int i = 0; i < std::atoi(argv[3]); ++i) alone.exchange();
    return 0;
  }
  int exchanges = 4000;
  bool takes_any_result = false;
  CLI::App app{"Cost of an exchange beside a plain ZeroMQ echo"};
  app.add_option("--exchanges", exchanges, "Per wire, with 3 bodies; fewer with more")->check(CLI::Range(20, 1000000));
  app.add_flag("--any-result", takes_any_result, "End with 0 although a target is missed");
  CLI11_PARSE(app, argc, argv);
  const bool met_between_processes = compare(exchanges);
  const bool all_met = compare_in_one_process(exchanges) && met_between_processes;
  return all_met || takes_any_result ? 0 : 1;
}
