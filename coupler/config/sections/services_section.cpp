#include <algorithm>
#include <regex>
#include <set>

#include <nlohmann/json.hpp>

#include "config/sections/sections.hpp"
#include "transport/endpoint.hpp"

namespace copepod::coupler {
namespace {

/// The sum of the fluid's ranks on all hosts, each "name" (one rank) or "name:ranks".
int ranks_of_hosts(Reader& services, const std::vector<std::string>& hosts) {
  static const std::regex form("([A-Za-z0-9][A-Za-z0-9_.-]*)(:([0-9]{1,5}))?");
  int ranks = 0;
  std::set<std::string> names;
  for (const std::string& host : hosts) {
    std::smatch parts;
    if (!std::regex_match(host, parts, form)) {
      services.reject("hosts", "has '" + host + "' (not a host). Write name, or name:ranks.");
    } else if (!names.insert(parts[1]).second) {
      services.reject("hosts", "has " + parts[1].str() + " twice (a host has one number of ranks). Write it once.");
    } else {
      ranks += parts[3].matched ? std::stoi(parts[3]) : 1;
    }
  }
  return ranks;
}

}  // namespace

ServicesCase read_services(Reader services) {
  ServicesCase result;
  {
    Reader fluid = services.section("fluid");
    const std::int64_t ranks = fluid.integer("ranks", Range::positive, 1);
    constexpr std::int64_t most_ranks = 1'000'000;
    if (ranks > most_ranks) {
      fluid.reject("ranks", "is " + std::to_string(ranks) + " (no machine has so many). Give the number of processes.");
    }
    result.fluid_ranks = static_cast<int>(std::min(ranks, most_ranks));
    result.fluid_command = fluid.command("command");
  }
  {
    Reader body = services.section("body");
    result.body_command = body.command("command");
    const std::int64_t threads = body.integer("threads", Range::positive, 1);
    if (threads > most_threads)
      body.reject("threads", "is " + std::to_string(threads) + " (at most " + std::to_string(most_threads) +
                                 "). Use at most the number of cores.");
    result.body_threads = static_cast<int>(std::min<std::int64_t>(threads, most_threads));
  }
  result.transport = services.text("transport", "ipc");
  if (result.transport != "ipc" && result.transport != in_process_transport &&
      !result.transport.starts_with("tcp://")) {
    services.reject("transport", "is '" + result.transport +
                                     "' (known: ipc, tcp, in_process). Write ipc, tcp://host:port or in_process.");
  }
  try {
    if (result.transport.starts_with("tcp://")) transport::check_endpoint(result.transport);
  } catch (const CaseError& error) {
    services.problems().error(services.path_of("transport"), error.what());
  }
  result.hosts = services.words("hosts");
  if (!result.hosts.empty()) {
    result.fluid_ranks = ranks_of_hosts(services, result.hosts);
    if (result.fluid_ranks == 0)
      services.reject("hosts", "leaves the fluid without a rank. Give one of them ranks: name:ranks.");
    if (result.transport == in_process_transport)
      services.reject("hosts", "needs processes (services.transport is in_process). Write transport: ipc.");
  }
  result.connect_deadline_s = services.number("connect_deadline_s", Range::positive, 60.0);
  result.progress_deadline_s = services.number("progress_deadline_s", Range::positive, 60.0);
  // A network may be cut for a while.
  const bool has_network = result.transport.starts_with("tcp://") || !result.hosts.empty();
  result.silence_s = services.number("silence_s", Range::positive, has_network ? 30.0 : 3.0);
  return result;
}

nlohmann::ordered_json resolved_services(const ServicesCase& services) {
  return {{"fluid", {{"ranks", services.fluid_ranks}, {"command", services.fluid_command}}},
          {"body", {{"command", services.body_command}, {"threads", services.body_threads}}},
          {"hosts", services.hosts},
          {"transport", services.transport},
          {"connect_deadline_s", services.connect_deadline_s},
          {"progress_deadline_s", services.progress_deadline_s},
          {"silence_s", services.silence_s}};
}

}  // namespace copepod::coupler
