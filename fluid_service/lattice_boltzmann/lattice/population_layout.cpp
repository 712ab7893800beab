#include "lattice_boltzmann/lattice/population_layout.hpp"

namespace copepod::fluid {

namespace {

constexpr std::int64_t round_up(std::int64_t value, std::int64_t multiple) {
  return (value + multiple - 1) / multiple * multiple;
}

}  // namespace

PopulationLayout::PopulationLayout(const Box& block, int value_bytes, const OriginRule& origin)
    : block_(block),
      lead_(64 / value_bytes),
      pitch_(round_up(lead_ + block.extent(2) + 1, lead_)),
      plane_(pitch_ * (block.extent(1) + 2)),
      slot_(round_up(plane_ * (block.extent(0) + 2), 4096 / value_bytes) + skew_lines * lead_) {
  for (int alpha = 0; alpha < d3q19::directions; ++alpha) home_[alpha] = slot(d3q19::opposite(alpha));
  // What enters in direction ᾱ is at home in its origin's slot; there goes f̃_α.
  for (Faces faces = 0; faces < face_sets; ++faces)
    for (int alpha = 0; alpha < d3q19::directions; ++alpha) {
      const auto& [offset, direction] = origin(faces, d3q19::opposite(alpha));
      streamed_[faces][alpha] = offset[0] * plane_ + offset[1] * pitch_ + offset[2] + slot(d3q19::opposite(direction));
    }
  constexpr Faces row_ends = face_bit(2, false) | face_bit(2, true);
  for (Faces faces = 0; faces < face_sets; ++faces)
    for (std::size_t alpha = 0; alpha < d3q19::directions; ++alpha)
      if (streamed_[faces][alpha] != streamed_[faces & ~row_ends][alpha])
        detours_[faces].push_back({streamed_[faces][alpha], streamed_[faces & ~row_ends][alpha]});
}

}  // namespace copepod::fluid
