#include "disturbed_run.hpp"

namespace copepod::chaos {

namespace {

/// The two proxies draw different fates.
ChaosPlan with_seed(ChaosPlan plan, std::uint64_t seed) {
  plan.seed = seed;
  return plan;
}

}  // namespace

DisturbedRun::DisturbedRun(const ChaosPlan& plan, coupler::LinkSettings settings, protocol_test::Programs programs)
    : fluid_proxy_("ipc://" + folder_.path("coupler.ipc"), folder_.path(""), "fluid", with_seed(plan, 2 * plan.seed)),
      body_proxy_("ipc://" + folder_.path("coupler.ipc"), folder_.path(""), "body",
                  with_seed(plan, 2 * plan.seed + 1)) {
  programs.fluid_endpoint = fluid_proxy_.endpoint();
  programs.body_endpoint = body_proxy_.endpoint();
  const std::vector<std::string> options;
  coupled = std::make_unique<protocol_test::CoupledRun>(options, options, settings,
                                                        "ipc://" + folder_.path("coupler.ipc"), programs);
}

protocol_test::Digests DisturbedRun::run(int steps) {
  coupled->begin();
  coupled->advance(steps);
  const protocol_test::Digests digests = coupled->digests();
  coupled->link->finish();
  return digests;
}

std::string DisturbedRun::tell_disturbances() {
  std::map<Disturbance, std::int64_t> total;
  for (ChaosProxy* proxy : {&fluid_proxy_, &body_proxy_}) {
    proxy->stop();
    for (const auto& [kind, count] : proxy->counts()) total[kind] += count;
  }
  std::string text;
  for (const auto& [kind, count] : total) {
    text += (text.empty() ? "" : ", ") + std::string(name_of(kind)) + " " + std::to_string(count);
  }
  return text;
}

}  // namespace copepod::chaos
