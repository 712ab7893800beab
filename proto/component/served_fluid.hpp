#pragma once

#include <memory>

#include "component/served_solver.hpp"
#include "contract/component.hpp"

namespace copepod::component {

/// A FluidSolver behind the messages of the fluid role. Kinematics are answered with loads first; the bulk
/// update comes after the reply, in the shadow of everybody else's work.
class ServedFluid final : public ServedSolver {
 public:
  explicit ServedFluid(const FluidComponent& component) : component_(component) {}

  [[nodiscard]] session::Role role() const override { return session::Role::fluid; }
  std::span<const std::byte> perform(session::Work work, const conversion::Decoder& request,
                                     const session::Header& header, conversion::Encoder& encoder) override;
  void follow_up(session::Work work) override;

 private:
  void make_solver(const conversion::Decoder& request);
  void compute_loads(const conversion::Decoder& request);

  const FluidComponent& component_;
  std::unique_ptr<FluidSolver> solver_;
  Eigen::Index bodies_ = 0;
  Kinematics kinematics_;
  Loads loads_;
};

}  // namespace copepod::component
