#include "model/case_digest.hpp"

#include "contract/digest.hpp"

namespace copepod::body {

namespace {

template <typename Matrix>
void add_numbers(Digest& digest, const Matrix& numbers) {
  for (Eigen::Index i = 0; i < numbers.size(); ++i) digest.add(numbers.data()[i]);
}

void add_text(Digest& digest, const std::string& text) {
  digest.add(std::uint64_t{text.size()});
  for (const char c : text) digest.add(static_cast<std::uint64_t>(static_cast<unsigned char>(c)));
}

}  // namespace

std::uint64_t case_digest(const BodySetup& setup) {
  Digest digest;
  digest.add(setup.step_s);
  digest.add(static_cast<std::uint64_t>(setup.integrator));
  add_numbers(digest, setup.gravity_m_per_s2);
  digest.add(setup.fluid_density_kg_per_m3);
  digest.add(std::uint64_t{setup.bodies.size()});
  for (const auto& body : setup.bodies) {
    add_text(digest, body.name);
    digest.add(static_cast<std::uint64_t>(body.shape.kind));
    digest.add(body.shape.radius_m);
    digest.add(body.shape.length_m);
    digest.add(body.mass_kg);
    digest.add(static_cast<std::uint64_t>(body.motion));
    if (body.motion == MotionKind::axis) add_numbers(digest, body.axis);
  }
  for (const auto& spring : setup.springs) {
    digest.add(static_cast<std::uint64_t>(spring.body_A));
    digest.add(static_cast<std::uint64_t>(spring.body_B));
    digest.add(spring.stiffness_N_per_m);
    digest.add(spring.damping_N_s_per_m);
    digest.add(spring.rest_length_m);
    add_numbers(digest, spring.anchor_A_m);
    add_numbers(digest, spring.anchor_B_m);
  }
  return digest.value();
}

std::uint64_t state_digest(std::int64_t step, const MotionState& state) {
  Digest digest;
  digest.add(static_cast<std::uint64_t>(step));
  add_numbers(digest, state.position_m);
  add_numbers(digest, state.orientation_wxyz);
  add_numbers(digest, state.velocity_m_per_s);
  add_numbers(digest, state.angular_momentum_N_m_s);
  return digest.value();
}

}  // namespace copepod::body
