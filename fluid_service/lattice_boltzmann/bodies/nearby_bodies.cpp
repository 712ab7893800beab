#include "lattice_boltzmann/bodies/nearby_bodies.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include "contract/errors.hpp"
#include "contract/shape.hpp"
#include "geometry/near_surfaces.hpp"

namespace copepod::fluid {

namespace {

/// A body covers a cell if its centre lies inside, of the block or its ghosts: at most one cell and a half beyond it.
constexpr double cells_beyond_block = 2.0;

double film_reach_lu(const FluidSetup& setup) {
  return setup.film_thickness_m > 0.0 ? FilmRange(setup).high_m / setup.cell_size_m : 0.0;
}

template <class Value>
std::byte* put(std::byte* to, const Value& value) {
  std::memcpy(to, &value, sizeof(Value));
  return to + sizeof(Value);
}

template <class Value>
const std::byte* take(const std::byte* from, Value& value) {
  std::memcpy(&value, from, sizeof(Value));
  return from + sizeof(Value);
}

template <class Columns>
std::byte* put_column(std::byte* to, const Columns& columns, Eigen::Index column) {
  const std::size_t size = static_cast<std::size_t>(columns.rows()) * sizeof(double);
  std::memcpy(to, columns.data() + columns.rows() * column, size);
  return to + size;
}

template <class Columns>
const std::byte* take_column(const std::byte* from, Columns& columns, Eigen::Index column) {
  const std::size_t size = static_cast<std::size_t>(columns.rows()) * sizeof(double);
  std::memcpy(columns.data() + columns.rows() * column, from, size);
  return from + size;
}

// Loads of a body in a message: 2 · body, and its sums as 64-bit integers; or 2 · body + 1, and all of 128 bits.
constexpr std::size_t most_bytes_of_loads = sizeof(std::int64_t) + sizeof(LoadSums);

bool fits_64_bits(fixed_point::Sum sum) {
  return sum >= std::numeric_limits<std::int64_t>::min() && sum <= std::numeric_limits<std::int64_t>::max();
}

void append_loads(std::vector<std::byte>& message, std::int32_t body, const LoadSums& sums) {
  std::array<std::byte, most_bytes_of_loads> loads{};
  std::byte* end = loads.data();
  const bool wide = !std::ranges::all_of(sums, fits_64_bits);
  end = put(end, 2 * std::int64_t{body} + (wide ? 1 : 0));
  for (const fixed_point::Sum sum : sums) end = wide ? put(end, sum) : put(end, static_cast<std::int64_t>(sum));
  message.insert(message.end(), loads.data(), end);
}

}  // namespace

NearBlocks::NearBlocks(const Domain& domain, const BlockPartition& partition, double film_reach_lu)
    : domain_(domain), grid_(partition.grid()), margin_lu_(cells_beyond_block + film_reach_lu) {
  for (int axis = 0; axis < 3; ++axis)
    for (std::int64_t index = 0; index < domain.cells()[axis]; ++index)
      place_[axis].push_back(partition.place(axis, index));
}

BlockRange NearBlocks::around(const Eigen::Vector3d& position_lu, double bounding_radius_lu) const {
  BlockRange range;
  if (!position_lu.allFinite()) {
    range.count = {1, 1, 1};
    return range;
  }
  const double half = bounding_radius_lu + margin_lu_;
  for (int axis = 0; axis < 3; ++axis) {
    const auto cells = static_cast<double>(domain_.cells()[axis]);
    double low = std::floor(position_lu[axis] - half);
    double high = std::floor(position_lu[axis] + half);
    range.count[axis] = grid_[axis];
    if (domain_.periodic(axis)) {
      if (high - low + 1.0 >= cells) continue;
      low -= cells * std::floor(low / cells);
      high -= cells * std::floor(high / cells);
    }
    const auto place = [&](double cell) {
      return place_[axis][static_cast<std::size_t>(std::clamp(cell, 0.0, cells - 1.0))];
    };
    range.first[axis] = place(low);
    const int steps = place(high) - range.first[axis];
    // Around the end it may come back to the block in which it began.
    range.count[axis] = std::min(grid_[axis], low <= high ? steps + 1 : steps + 1 + grid_[axis]);
  }
  return range;
}

NearbyBodies::NearbyBodies(const FluidSetup& setup, const LatticeUnits& units, const Domain& domain,
                           const BlockPartition& partition, bool returns_mass, Communicator& communicator)
    : communicator_(communicator),
      units_(units),
      near_blocks_(domain, partition, film_reach_lu(setup)),
      has_capsules_(std::ranges::any_of(setup.bodies, [](const Shape& s) { return s.kind == ShapeKind::capsule; })),
      returns_mass_(returns_mass),
      record_bytes_(sizeof(std::int64_t) + (9 + (has_capsules_ ? 4 : 0) + (returns_mass ? 1 : 0)) * sizeof(double)),
      relays_(relays_after(communicator.rank(), communicator.size())) {
  for (const Shape& shape : setup.bodies) bounding_radius_lu_.push_back(units.length_lu(bounding_radius_m(shape)));
  if (communicator.rank() != 0) return;
  before_.resize(setup.bodies.size());
  now_.resize(setup.bodies.size());
  total_.resize(setup.bodies.size());
}

std::size_t NearbyBodies::place_of(std::int32_t body) const {
  const auto found = std::ranges::lower_bound(bodies_, body);
  assert(found != bodies_.end() && *found == body);
  return static_cast<std::size_t>(found - bodies_.begin());
}

void NearbyBodies::finish() {
  for (const auto& finish_send : sends_) finish_send();
  sends_.clear();
}

void NearbyBodies::scatter(const Kinematics& kinematics, std::span<const double> returned_mass) {
  const auto bodies = static_cast<Eigen::Index>(bounding_radius_lu_.size());
  if (communicator_.rank() == 0 && kinematics.bodies() != bodies)
    throw SolverError("kinematics of " + std::to_string(kinematics.bodies()) + " bodies (the setup named " +
                      std::to_string(bodies) + "). Send all bodies in the order of the setup.");
  if (bodies == 0) return;
  finish();
  if (communicator_.rank() == 0) {
    write_records(kinematics, returned_mass);
  } else {
    communicator_.receive(relay_before(communicator_.rank()), records_);
  }
  find_sections();
  const auto start = [this](int rank) {
    return section_starts_[static_cast<std::size_t>(rank - communicator_.rank())];
  };
  for (const RankRange& relay : relays_)
    sends_.push_back(communicator_.start_send(
        relay.first, std::span(records_).subspan(start(relay.first), start(relay.end) - start(relay.first))));
  take_own_section();
}

template <class Visit>
void NearbyBodies::for_each_rank_of(std::size_t body, const Visit& visit) const {
  near_blocks_.for_each_rank(now_[body], {}, visit);
  if (before_[body] != now_[body]) near_blocks_.for_each_rank(before_[body], now_[body], visit);
}

void NearbyBodies::write_records(const Kinematics& kinematics, std::span<const double> returned_mass) {
  std::vector<std::uint64_t> count(static_cast<std::size_t>(communicator_.size()), 0);
  for (std::size_t body = 0; body < now_.size(); ++body) {
    now_[body] = near_blocks_.around(units_.position_lu(kinematics.position_m.col(static_cast<Eigen::Index>(body))),
                                     bounding_radius_lu_[body]);
    for_each_rank_of(body, [&](int rank) { ++count[static_cast<std::size_t>(rank)]; });
  }
  std::size_t bytes = 0;
  for (const std::uint64_t records : count) bytes += sizeof(std::uint64_t) + records * record_bytes_;
  records_.resize(bytes);
  std::vector<std::byte*> next;
  std::byte* section = records_.data();
  for (const std::uint64_t records : count) {
    next.push_back(put(section, records));
    section = next.back() + records * record_bytes_;
  }
  for (std::size_t body = 0; body < now_.size(); ++body)
    for_each_rank_of(body, [&](int rank) {
      std::byte*& to = next[static_cast<std::size_t>(rank)];
      to = write_record(to, kinematics, static_cast<Eigen::Index>(body), returned_mass);
    });
  before_.swap(now_);
}

std::byte* NearbyBodies::write_record(std::byte* to, const Kinematics& kinematics, Eigen::Index body,
                                      std::span<const double> returned_mass) const {
  to = put(to, std::int64_t{body});
  to = put_column(to, kinematics.position_m, body);
  if (has_capsules_) to = put_column(to, kinematics.orientation_wxyz, body);
  to = put_column(to, kinematics.velocity_m_per_s, body);
  to = put_column(to, kinematics.angular_velocity_rad_per_s, body);
  if (returns_mass_) to = put(to, returned_mass[static_cast<std::size_t>(body)]);
  return to;
}

/// Where the records of each rank begin, and behind them the end of all.
void NearbyBodies::find_sections() {
  section_starts_.assign(1, 0);
  while (section_starts_.back() < records_.size()) {
    std::uint64_t records = 0;
    take(records_.data() + section_starts_.back(), records);
    section_starts_.push_back(section_starts_.back() + sizeof(records) + records * record_bytes_);
  }
}

void NearbyBodies::take_own_section() {
  std::uint64_t records = 0;
  const std::byte* from = take(records_.data(), records);
  bodies_.resize(records);
  kinematics_.resize(static_cast<Eigen::Index>(records));
  returned_mass_.assign(records, 0.0);
  for (std::size_t place = 0; place < records; ++place) {
    const auto column = static_cast<Eigen::Index>(place);
    std::int64_t body = 0;
    from = take(from, body);
    bodies_[place] = static_cast<std::int32_t>(body);
    from = take_column(from, kinematics_.position_m, column);
    if (has_capsules_) from = take_column(from, kinematics_.orientation_wxyz, column);
    from = take_column(from, kinematics_.velocity_m_per_s, column);
    from = take_column(from, kinematics_.angular_velocity_rad_per_s, column);
    if (returns_mass_) from = take(from, returned_mass_[place]);
  }
}

std::span<const LoadSums> NearbyBodies::gather(std::span<const LoadSums> loads, MomentumSums& gained) {
  if (bounding_radius_lu_.empty()) return total_;
  const bool leads = communicator_.rank() == 0;
  std::ranges::fill(total_, LoadSums{});
  loads_.resize(sizeof(MomentumSums));
  for (std::size_t place = 0; place < bodies_.size(); ++place) {
    if (leads)
      total_[static_cast<std::size_t>(bodies_[place])] = loads[place];
    else if (loads[place] != LoadSums{})
      append_loads(loads_, bodies_[place], loads[place]);
  }
  for (const RankRange& relay : relays_) {
    communicator_.receive(relay.first, received_);
    add_loads(received_, gained);
  }
  if (leads) return total_;
  put(loads_.data(), gained);
  sends_.push_back(communicator_.start_send(relay_before(communicator_.rank()), loads_));
  return {};
}

/// Rank 0 adds up the loads of a body, relays pass on what they receive.
void NearbyBodies::add_loads(std::span<const std::byte> message, MomentumSums& gained) {
  MomentumSums gained_there;
  const std::byte* from = take(message.data(), gained_there);
  for (std::size_t axis = 0; axis < gained.size(); ++axis) gained[axis] += gained_there[axis];
  const std::byte* const end = message.data() + message.size();
  if (communicator_.rank() != 0) {
    loads_.insert(loads_.end(), from, end);
    return;
  }
  while (from != end) {
    std::int64_t body_and_width = 0;
    from = take(from, body_and_width);
    for (fixed_point::Sum& sum : total_[static_cast<std::size_t>(body_and_width / 2)]) {
      fixed_point::Sum wide = 0;
      std::int64_t narrow = 0;
      from = body_and_width % 2 == 1 ? take(from, wide) : take(from, narrow);
      sum += body_and_width % 2 == 1 ? wide : narrow;
    }
  }
}

}  // namespace copepod::fluid
