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

/// A number of processes or threads.
void declare_number_of(Keys& keys, const char* key, int& value, std::int64_t most, const std::string& problem,
                       const char* description) {
  std::int64_t number = value;
  keys.integer(key, number, Range::positive, description);
  if (Reader* reader = keys.reader(); reader != nullptr && number > most)
    reader->reject(key, "is " + std::to_string(number) + " (" + problem);
  value = static_cast<int>(std::min(number, most));
}

void check_transport(Reader& services, const std::string& transport) {
  if (transport != "ipc" && transport != in_process_transport && !transport.starts_with("tcp://"))
    services.reject("transport",
                    "is '" + transport + "' (known: ipc, tcp, in_process). Write ipc, tcp://host:port or in_process.");
  try {
    if (transport.starts_with("tcp://")) transport::check_endpoint(transport);
  } catch (const CaseError& error) {
    services.problems().error(services.path_of("transport"), error.what());
  }
}

void settle_hosts(Reader& reader, ServicesCase& services) {
  if (services.hosts.empty()) return;
  services.fluid_ranks = ranks_of_hosts(reader, services.hosts);
  if (services.fluid_ranks == 0)
    reader.reject("hosts", "leaves the fluid without a rank. Give one of them ranks: name:ranks.");
  if (services.transport == in_process_transport)
    reader.reject("hosts", "needs processes (services.transport is in_process). Write transport: ipc.");
}

}  // namespace

void declare(Keys& keys, ServicesCase& services) {
  const char* command = "Words of the command that starts another component; empty: the built-in one.";
  keys.section("fluid", "The fluid service.", [&](Keys& fluid) {
    declare_number_of(fluid, "ranks", services.fluid_ranks, 1'000'000,
                      "no machine has so many). Give the number of processes.",
                      "Number of MPI processes. stokes and vacuum use one.");
    fluid.command("command", services.fluid_command, command);
  });
  keys.section("body", "The body service.", [&](Keys& body) {
    body.command("command", services.body_command, command);
    declare_number_of(
        body, "threads", services.body_threads, most_threads,
        "at most " + std::to_string(most_threads) + "). Use at most the number of cores.",
        "Threads in which our solver moves bodies that nothing joins; results do not depend on it. Worth it "
        "from some thousand bodies on, with a core that the fluid's ranks leave free. Other components "
        "ignore it.");
    body.describe_also("threads", {{"maximum", most_threads}});
  });
  keys.words(
      "hosts", services.hosts, 0,
      "Hosts of the fluid's ranks: name (one rank) or name:ranks, instead of fluid.ranks. The first one runs the "
      "command, the coupler and the bodies. See docs/hosts.md. Default: this machine alone.");
  keys.describe_also("hosts",
                     {{"items", {{"type", "string"}, {"pattern", "^[A-Za-z0-9][A-Za-z0-9_.-]*(:[0-9]{1,5})?$"}}}});
  keys.text(
      "transport", services.transport,
      "ipc, tcp://host:port, or in_process: coupler, our own bodies and fluid in one process, the ranks of the fluid "
      "as threads. Fastest for small cases.");
  keys.describe_also("transport", {{"pattern", "^(ipc|in_process|tcp://.+)$"}});
  if (Reader* reader = keys.reader()) {
    check_transport(*reader, services.transport);
    settle_hosts(*reader, services);
    const bool has_network = services.transport.starts_with("tcp://") || !services.hosts.empty();
    services.silence_s = has_network ? 30.0 : 3.0;  // a network may be cut for a while
  }
  keys.number("connect_deadline_s", services.connect_deadline_s, Range::positive,
              "Maximum wait of the coupler for both components at the start.");
  keys.number(
      "progress_deadline_s", services.progress_deadline_s, Range::positive,
      "A component is considered hung if its step, phase and progress do not change for this long while work is "
      "due.");
  keys.number(
      {"silence_s", Need::in_some_cases}, services.silence_s, Range::positive,
      "A component is considered frozen, or its host lost, if it does not answer for this long (default: 3, over "
      "tcp 30). A network may be cut for half of it.");
}

}  // namespace copepod::coupler
