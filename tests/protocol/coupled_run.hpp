#pragma once

#include <memory>
#include <string>
#include <vector>

#include "child_process.hpp"
#include "contract/body_setup.hpp"
#include "contract/fluid_setup.hpp"
#include "remote/link.hpp"
#include "remote/remote_solvers.hpp"
#include "temporary_folder.hpp"

namespace copepod::protocol_test {

using coupler::Link;
using coupler::LinkSettings;
using coupler::RemoteBody;
using coupler::RemoteFluid;

/// A port of this machine that other runs of the tests, at the same time, are unlikely to use.
std::string tcp_endpoint();

/// Two spheres: the first moves along x, the second rests.
FluidSetup two_spheres_in_fluid();
BodySetup two_free_spheres();

/// Drag of the first sphere times step over mass: its velocity shrinks by this share in every step.
double decay_per_step();

/// Digests of the two solvers.
struct Digests {
  std::uint64_t fluid = 0;
  std::uint64_t body = 0;

  bool operator==(const Digests&) const = default;
};

/// Of the same steps without any wire.
Digests digests_of_local_run(int steps);

/// Command line of the fake fluid, with the token of CoupledRun.
std::vector<std::string> fake_fluid_command(const std::string& endpoint, const std::vector<std::string>& options);

/// The programs that play the two roles; the fakes if not given.
struct Programs {
  std::vector<std::string> fluid = {};
  std::vector<std::string> body = {};
  std::string fluid_endpoint = {};  ///< where they connect; the coupler's if not given
  std::string body_endpoint = {};
};

/// A coupler's end in the test's own process, a fake fluid and a fake body in processes of their own.
class CoupledRun {
 public:
  /// @param endpoint  empty: ipc in the temporary folder
  CoupledRun(const std::vector<std::string>& fluid_options, const std::vector<std::string>& body_options,
             LinkSettings settings = {}, const std::string& endpoint = "", const Programs& programs = {});

  /// Hellos, setups, first kinematics.
  void begin();
  /// Steps [next, next + steps) as the serial explicit scheme does them, without averaging or driving.
  void advance(int steps);
  /// The coupler's connections break.
  void end_coupler() {
    fluid.reset();
    body.reset();
    link.reset();
  }
  /// Steps until something is thrown; gives up after half a minute. @return the error's text
  std::string advance_until_failure();

  TemporaryFolder folder;
  std::unique_ptr<Link> link;
  std::unique_ptr<ChildProcess> fluid_process;
  std::unique_ptr<ChildProcess> body_process;
  std::unique_ptr<RemoteFluid> fluid;
  std::unique_ptr<RemoteBody> body;
  Kinematics kinematics;
  Loads loads;

  /// As the coupler asks for them at the end of a run.
  Digests digests();

  [[nodiscard]] std::string fluid_log() const;
};

}  // namespace copepod::protocol_test
