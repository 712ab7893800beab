#include "lattice_boltzmann/output/state_digest.hpp"

namespace copepod::fluid {

std::uint64_t digest_of_mean(const Cell& cells, const MeanField& mean) {
  if (mean.samples() == 0) return 0;
  const FieldBlock& sums = mean.sums();
  const auto samples = static_cast<std::uint64_t>(mean.samples());
  std::uint64_t sum = 0;
  std::size_t cell = 0;
  for (std::int64_t x = sums.box.low[0]; x < sums.box.high[0]; ++x) {
    for (std::int64_t y = sums.box.low[1]; y < sums.box.high[1]; ++y)
      for (std::int64_t z = sums.box.low[2]; z < sums.box.high[2]; ++z, ++cell) {
        Digest digest(static_cast<std::uint64_t>((x * cells[1] + y) * cells[2] + z));
        digest.add(samples);
        digest.add(sums.density_kg_per_m3[cell]);
        for (std::size_t axis = 0; axis < 3; ++axis) digest.add(sums.velocity_m_per_s[3 * cell + axis]);
        digest.add(static_cast<std::uint64_t>(sums.body[cell]));
        sum += digest.value();
      }
    report_progress();
  }
  return sum;
}

std::uint64_t digest_of_kinematics(const Kinematics& kinematics) {
  Digest digest(static_cast<std::uint64_t>(kinematics.step));
  const auto add = [&](const auto& matrix) {
    for (Eigen::Index i = 0; i < matrix.size(); ++i) digest.add(matrix.data()[i]);
  };
  add(kinematics.position_m);
  add(kinematics.orientation_wxyz);
  add(kinematics.velocity_m_per_s);
  add(kinematics.angular_velocity_rad_per_s);
  return digest.value();
}

}  // namespace copepod::fluid
