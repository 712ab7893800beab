#pragma once

#include <memory>

#include "component/served_solver.hpp"
#include "contract/component.hpp"

namespace copepod::component {

/// A BodySolver behind the messages of the body role.
class ServedBody final : public ServedSolver {
 public:
  explicit ServedBody(const BodyComponent& component) : component_(component) {}

  [[nodiscard]] session::Role role() const override { return session::Role::body; }
  std::span<const std::byte> perform(session::Work work, const conversion::Decoder& request,
                                     const session::Header& header, conversion::Encoder& encoder) override;
  void follow_up(session::Work) override {}

 private:
  session::Configured make_solver(const conversion::Decoder& request);
  void advance_bodies(const conversion::Decoder& request);

  const BodyComponent& component_;
  std::unique_ptr<BodySolver> solver_;
  Eigen::Index bodies_ = 0;
  Eigen::Index driving_nodes_ = 1;
  AppliedLoads applied_;
  Kinematics kinematics_;
};

}  // namespace copepod::component
