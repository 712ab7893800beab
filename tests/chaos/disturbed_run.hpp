#pragma once

#include <memory>
#include <string>

#include "chaos_proxy.hpp"
#include "coupled_run.hpp"

namespace copepod::chaos {

/// A coupled run of the fakes with a chaos proxy before each of them.
class DisturbedRun {
 public:
  /// What a case over tcp has: a connection may be broken for 3 s, however busy the machine.
  static coupler::LinkSettings over_a_network() {
    coupler::LinkSettings settings;
    settings.silence_s = 30.0;
    return settings;
  }

  /// @param programs  the fakes if not given
  explicit DisturbedRun(const ChaosPlan& plan, coupler::LinkSettings settings = over_a_network(),
                        protocol_test::Programs programs = {});

  /// Handshake, setups, steps, summaries and goodbyes.
  protocol_test::Digests run(int steps);

  /// "drop 12, repeat 9, …" of both proxies, which end.
  std::string tell_disturbances();

  std::unique_ptr<protocol_test::CoupledRun> coupled;

 private:
  TemporaryFolder folder_;
  ChaosProxy fluid_proxy_;
  ChaosProxy body_proxy_;
};

}  // namespace copepod::chaos
