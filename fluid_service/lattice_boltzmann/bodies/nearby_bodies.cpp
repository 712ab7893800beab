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

/// A body covers a cell of the block or its ghosts if the cell's centre lies inside: half a cell beyond the block at
/// most, where also links end; and some more than rounding.
constexpr double cells_beyond_block = 0.6;

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

bool fits_64_bits(fixed_point::Sum sum) {
  return sum >= std::numeric_limits<std::int64_t>::min() && sum <= std::numeric_limits<std::int64_t>::max();
}

}  // namespace

NearBlocks::NearBlocks(const Domain& domain, const BlockPartition& partition, double film_reach_lu)
    : domain_(domain), grid_(partition.grid()), margin_lu_(cells_beyond_block + film_reach_lu) {
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double>& starts = starts_[axis];
    for (std::int64_t index = 0; index < domain.cells()[axis]; ++index)
      if (partition.place(axis, index) == std::ssize(starts)) starts.push_back(static_cast<double>(index));
    starts.push_back(static_cast<double>(domain.cells()[axis]));
    if (domain.periodic(axis)) continue;
    starts.front() = -std::numeric_limits<double>::infinity();
    starts.back() = std::numeric_limits<double>::infinity();
  }
}

NearBlocks::Found NearBlocks::around(const Eigen::Vector3d& position_lu, double bounding_radius_lu) const {
  constexpr double rounding = 1e-6;  // more than that of a position in cells
  Found found;
  BlockRange& range = found.blocks;
  if (!position_lu.allFinite()) {
    range.count = {1, 1, 1};
    return found;
  }
  const double half = bounding_radius_lu + margin_lu_;
  for (int axis = 0; axis < 3; ++axis) {
    const auto cells = static_cast<double>(domain_.cells()[axis]);
    const double low = position_lu[axis] - half;
    const double high = position_lu[axis] + half;
    double low_image = 0.0;
    double high_image = 0.0;
    if (domain_.periodic(axis)) {
      if (high - low >= cells - 2.0) {
        range.count[axis] = grid_[axis];
        found.stays_lu.min()[axis] = -std::numeric_limits<double>::infinity();
        found.stays_lu.max()[axis] = std::numeric_limits<double>::infinity();
        continue;
      }
      low_image = cells * std::floor(low / cells);
      high_image = cells * std::floor(high / cells);
    }
    const std::vector<double>& starts = starts_[axis];
    const auto place = [&](double at) {
      const auto after = std::ranges::upper_bound(starts, at) - starts.begin();
      return std::clamp(static_cast<int>(after) - 1, 0, grid_[axis] - 1);
    };
    const int first = place(low - low_image);
    const int last = place(high - high_image);
    range.first[axis] = first;
    // Around the end it may come back to the block in which it began.
    const int steps = last - first + (low - low_image <= high - high_image ? 0 : grid_[axis]);
    range.count[axis] = std::min(grid_[axis], steps + 1);
    const auto end_of = [&](int block) { return starts[static_cast<std::size_t>(block) + 1]; };
    const auto start_of = [&](int block) { return starts[block]; };
    found.stays_lu.min()[axis] =
        std::max(start_of(first) + low_image + half, start_of(last) + high_image - half) + rounding;
    found.stays_lu.max()[axis] =
        std::min(end_of(first) + low_image + half, end_of(last) + high_image - half) - rounding;
  }
  return found;
}

NearbyBodies::NearbyBodies(const FluidSetup& setup, const LatticeUnits& units, const Domain& domain,
                           const BlockPartition& partition, bool returns_mass, Communicator& communicator)
    : communicator_(communicator),
      units_(units),
      near_blocks_(domain, partition, film_reach_lu(setup)),
      has_orientations_(std::ranges::any_of(setup.bodies, has_orientation)),
      returns_mass_(returns_mass),
      record_bytes_(sizeof(std::int32_t) + (9 + (has_orientations_ ? 4 : 0) + (returns_mass ? 1 : 0)) * sizeof(double)),
      components_(returns_mass ? load_components : mass_component),
      behind_(ranks_behind(communicator.rank(), communicator.size())),
      relays_(relays_after(behind_)) {
  for (const Shape& shape : setup.bodies) bounding_radius_lu_.push_back(units.length_lu(bounding_radius_m(shape)));
  if (communicator.rank() != 0) return;
  near_.resize(setup.bodies.size());
  stays_m_.resize(setup.bodies.size());
  listed_.resize(communicator.size());
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
  kinematics_.step = kinematics.step;
  if (bodies == 0) return;
  finish();
  const bool leads = communicator_.rank() == 0;
  if (leads) {
    update_lists(kinematics.position_m);
  } else {
    communicator_.receive(relay_before(communicator_.rank()), records_);
    find_sections();
  }
  for (const Relay& relay : relays_) {
    for (std::size_t place = relay.first; leads && place < relay.end; ++place)
      write_section(place, kinematics, returned_mass);
    const std::size_t start = section_starts_[relay.first];
    sends_.push_back(
        communicator_.start_send(relay.rank, std::span(records_).subspan(start, section_starts_[relay.end] - start)));
  }
  if (leads) write_section(0, kinematics, returned_mass);
  take_own_section();
}

void NearbyBodies::update_lists(const Eigen::Matrix3Xd& position_m) {
  const auto place_in = [](std::vector<std::int32_t>& list, std::int32_t body) {
    return std::ranges::lower_bound(list, body);
  };
  for (const auto& [rank, body] : leaving_) {
    auto& list = listed_[rank];
    list.erase(place_in(list, body));
  }
  leaving_.clear();
  for (std::int32_t body = 0; body < std::ssize(near_); ++body) {
    if (stays_m_[body].contains(position_m.col(body))) continue;
    const auto [now, stays_lu] =
        near_blocks_.around(units_.position_lu(position_m.col(body)), bounding_radius_lu_[body]);
    near_blocks_.for_each_rank(now, near_[body], [&](int rank) {
      auto& list = listed_[rank];
      list.insert(place_in(list, body), body);
    });
    near_blocks_.for_each_rank(near_[body], now, [&](int rank) { leaving_.emplace_back(rank, body); });
    near_[body] = now;
    stays_m_[body] = {units_.position_m(stays_lu.min()), units_.position_m(stays_lu.max())};
  }
  section_starts_.assign(1, 0);
  for (const int rank : behind_)
    section_starts_.push_back(section_starts_.back() + sizeof(std::uint64_t) + listed_[rank].size() * record_bytes_);
  records_.resize(section_starts_.back());
}

void NearbyBodies::write_section(std::size_t place, const Kinematics& kinematics,
                                 std::span<const double> returned_mass) {
  constexpr std::size_t ahead = 8;
  const auto& list = listed_[behind_[place]];
  std::byte* to = records_.data() + section_starts_[place];
  to = put(to, std::uint64_t{list.size()});
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::int32_t soon = list[std::min(i + ahead, list.size() - 1)];
    __builtin_prefetch(kinematics.position_m.col(soon).data());
    __builtin_prefetch(kinematics.velocity_m_per_s.col(soon).data());
    __builtin_prefetch(kinematics.angular_velocity_rad_per_s.col(soon).data());
    to = write_record(to, kinematics, list[i], returned_mass);
  }
}

std::byte* NearbyBodies::write_record(std::byte* to, const Kinematics& kinematics, std::int32_t body,
                                      std::span<const double> returned_mass) const {
  to = put(to, body);
  to = put_column(to, kinematics.position_m, body);
  if (has_orientations_) to = put_column(to, kinematics.orientation_wxyz, body);
  to = put_column(to, kinematics.velocity_m_per_s, body);
  to = put_column(to, kinematics.angular_velocity_rad_per_s, body);
  if (returns_mass_) to = put(to, returned_mass[body]);
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
  kinematics_.resize(records);
  returned_mass_.assign(records, 0.0);
  for (std::size_t place = 0; place < records; ++place) {
    from = take(from, bodies_[place]);
    from = take_record(from, kinematics_, place, returned_mass_[place]);
  }
}

/// Reads what follows the number of the body.
const std::byte* NearbyBodies::take_record(const std::byte* from, Kinematics& kinematics, Eigen::Index column,
                                           double& returned_mass) const {
  from = take_column(from, kinematics.position_m, column);
  if (has_orientations_) from = take_column(from, kinematics.orientation_wxyz, column);
  from = take_column(from, kinematics.velocity_m_per_s, column);
  from = take_column(from, kinematics.angular_velocity_rad_per_s, column);
  return returns_mass_ ? take(from, returned_mass) : from;
}

Kinematics NearbyBodies::all_kinematics() const {
  Kinematics all;
  all.step = kinematics_.step;
  if (communicator_.rank() != 0) return all;
  all.resize(std::ssize(near_));
  all.orientation_wxyz.colwise() = Eigen::Vector4d::UnitX();
  for (std::size_t place = 0; place + 1 < section_starts_.size(); ++place) {
    const std::byte* from = records_.data() + section_starts_[place] + sizeof(std::uint64_t);
    const std::byte* const end = records_.data() + section_starts_[place + 1];
    double returned_mass = 0.0;
    for (std::int32_t body = 0; from != end;) {
      from = take(from, body);
      from = take_record(from, all, body, returned_mass);
    }
  }
  return all;
}

void NearbyBodies::gather(std::span<const LoadSums> loads, MomentumSums& gained) {
  if (bounding_radius_lu_.empty()) return;
  const bool leads = communicator_.rank() == 0;
  total_low_.assign(near_.size() * components_, 0);
  total_high_.clear();
  loads_.resize(sizeof(MomentumSums));
  for (std::size_t place = 0; place < bodies_.size(); ++place) {
    const auto body = static_cast<std::size_t>(bodies_[place]);
    for (std::size_t i = 0; leads && i < components_; ++i) add_to_total(body * components_ + i, loads[place][i]);
    if (!leads && loads[place] != LoadSums{}) append_loads(bodies_[place], loads[place]);
  }
  for (const Relay& relay : relays_) {
    communicator_.receive(relay.rank, received_);
    add_loads(received_, gained);
  }
  if (leads) return;
  put(loads_.data(), gained);
  sends_.push_back(communicator_.start_send(relay_before(communicator_.rank()), loads_));
}

inline void NearbyBodies::add_to_total(std::size_t at, fixed_point::Sum value) {
  const auto low = static_cast<std::int64_t>(value);
  auto high = static_cast<std::int64_t>((value - low) >> 64);
  if (__builtin_add_overflow(total_low_[at], low, &total_low_[at])) high += low > 0 ? 1 : -1;
  if (high != 0) add_to_high(at, high);
}

[[gnu::cold]] void NearbyBodies::add_to_high(std::size_t at, std::int64_t value) {
  total_high_.resize(total_low_.size());
  total_high_[at] += value;
}

/// 2 · body, and its sums as 64-bit integers; or 2 · body + 1, and all of 128 bits.
void NearbyBodies::append_loads(std::int32_t body, const LoadSums& sums) {
  std::array<std::byte, sizeof(std::uint32_t) + sizeof(LoadSums)> loads{};
  const auto used = std::span(sums).first(components_);
  const bool wide = !std::ranges::all_of(used, fits_64_bits);
  std::byte* end = put(loads.data(), 2 * static_cast<std::uint32_t>(body) + (wide ? 1U : 0U));
  for (const fixed_point::Sum sum : used) end = wide ? put(end, sum) : put(end, static_cast<std::int64_t>(sum));
  loads_.insert(loads_.end(), loads.data(), end);
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
  const auto add = [&]<class Value>(std::size_t at, Value value) {
    for (std::size_t i = 0; i < components_; ++i) {
      from = take(from, value);
      add_to_total(at + i, value);
    }
  };
  const auto ahead = static_cast<std::ptrdiff_t>(8 * (sizeof(std::uint32_t) + components_ * sizeof(std::int64_t)));
  while (from != end) {
    std::uint32_t body_and_width = 0;
    if (end - from > ahead) {
      take(from + ahead, body_and_width);  // of another entry, if those between are narrow
      const std::int64_t* const soon =
          &total_low_[std::min<std::size_t>(body_and_width / 2, near_.size() - 1) * components_];
      __builtin_prefetch(soon, 1);
      __builtin_prefetch(soon + components_ - 1, 1);
    }
    from = take(from, body_and_width);
    const std::size_t at = body_and_width / 2 * components_;
    if (body_and_width % 2 == 1)
      add(at, fixed_point::Sum{});
    else
      add(at, std::int64_t{});
  }
}

}  // namespace copepod::fluid
