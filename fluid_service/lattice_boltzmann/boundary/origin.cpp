#include "lattice_boltzmann/boundary/origin.hpp"

namespace copepod::fluid {

namespace {

Origin origin(const Domain& domain, const Box& block, Faces faces, int direction) {
  const auto& e = d3q19::e[direction];
  Origin result = straight(direction);
  bool bounces = false;
  for (int axis = 0; axis < 3; ++axis) {
    const bool high = e[axis] < 0;
    const std::int64_t cells = domain.cells()[axis];
    const bool through_domain_face = e[axis] != 0 && (faces & face_bit(axis, high)) != 0 &&
                                     (high ? block.high[axis] == cells : block.low[axis] == 0);
    if (!through_domain_face) continue;
    switch (domain.face(axis, high).kind) {
      case FaceKind::periodic:
        if (block.extent(axis) == cells) result.offset[axis] += high ? -cells : cells;
        break;
      case FaceKind::mirror:
        result.offset[axis] = 0;
        result.direction = d3q19::mirrored(result.direction, axis);
        break;
      case FaceKind::wall:
      case FaceKind::pressure:
        bounces = true;
        break;
    }
  }
  return bounces ? Origin{{0, 0, 0}, d3q19::opposite(direction)} : result;
}

}  // namespace

OriginRule origin_rule(const Domain& domain, const Box& block) {
  return [&domain, block](Faces faces, int direction) { return origin(domain, block, faces, direction); };
}

}  // namespace copepod::fluid
