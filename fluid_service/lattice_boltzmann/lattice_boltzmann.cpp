#include "lattice_boltzmann/lattice_boltzmann.hpp"

#include <algorithm>
#include <cmath>

#include "contract/errors.hpp"
#include "lattice_boltzmann/boundary/domain.hpp"

namespace copepod::fluid {

namespace {

std::vector<LatticeBody> make_bodies(const FluidSetup& setup) {
  std::vector<LatticeBody> bodies;
  for (const Shape& shape : setup.bodies) bodies.emplace_back(shape, setup.cell_size_m);
  auto obstacle = bodies.end() - std::ssize(setup.obstacles);
  for (const ObstacleSpecification& specification : setup.obstacles) (obstacle++)->has_loads = specification.loads;
  return bodies;
}

std::vector<std::string> names_of_obstacles(const FluidSetup& setup) {
  std::vector<std::string> names;
  for (const ObstacleSpecification& obstacle : setup.obstacles) names.push_back(obstacle.name);
  return names;
}

}  // namespace

template <class T>
LatticeBoltzmann<T>::LatticeBoltzmann(const FluidSetup& setup, Communicator& communicator)
    : setup_(setup),
      communicator_(communicator),
      units_(setup),
      domain_(setup, units_),
      partition_(domain_.cells(), communicator.size(), setup.bodies.size()),
      layout_(partition_.block(communicator.rank()), sizeof(T),
              origin_rule(domain_, partition_.block(communicator.rank()))),
      populations_(layout_.values()),
      constants_(collision_constants<T>(setup.collision, units_.relaxation_time(setup.kinematic_viscosity_m2_per_s),
                                        units_.body_force_lu(setup.body_force_N_per_m3))),
      has_force_(!setup.body_force_N_per_m3.isZero(0.0)),
      stream_collide_(choose_kernels<T>().stream_collide),
      halo_(domain_, partition_, layout_, communicator),
      moving_walls_(domain_, layout_),
      open_faces_(domain_, layout_),
      map_(domain_, layout_, make_bodies(setup), names_of_obstacles(setup)),
      refill_(make_refiller<T>(setup.refill, domain_, partition_, layout_, communicator)),
      films_(setup),
      exchange_momentum_(make_momentum_exchange<T>(setup.moving_boundary, constants_, layout_, map_, films_)),
      links_(map_, layout_, exchange_momentum_->uses_second_cell),
      nearby_(setup, units_, domain_, partition_, exchange_momentum_->conserving, communicator),
      absorbed_mass_(Eigen::Matrix2Xd::Zero(2, setup.bodies.size())),
      timer_(communicator.context().timeline()),
      output_(setup, communicator),
      sample_flow_(setup, domain_, layout_.block(), communicator) {
  populations_.touch(showing_progress());  // or the first step would wait for memory
  if (setup.initial_flow.kind == InitialFlowKind::file)
    start_from_file();
  else if (setup.initial_flow.kind != InitialFlowKind::rest || has_force_)
    initialise([&](const Cell& cell) { return initial_flow(setup_, units_, cell); });
  std::int64_t ready[] = {0};
  communicator.sum_to_all(ready);  // no rank is late for the first step
}

template <class T>
void LatticeBoltzmann<T>::start_from_file() {
  const FieldBlock block = read_flow(setup_, layout_.block(), communicator_.context());
  const VelocityGradient gradient(setup_, block, communicator_);
  const double to_lu = setup_.step_s / setup_.cell_size_m;
  std::size_t i = 0;
  initialise([&](const Cell& cell) {
    LocalFlow flow;
    flow.excess_density = block.density_kg_per_m3[i] / setup_.density_kg_per_m3 - 1.0;
    flow.velocity = to_lu * Eigen::Map<const Eigen::Vector3d>(&block.velocity_m_per_s[3 * i++]);
    flow.gradient = to_lu * gradient(cell);
    flow.gradient.diagonal().array() -= flow.gradient.trace() / 3.0;  // compression is the density's
    return flow;
  });
}

template <class T>
void LatticeBoltzmann<T>::map_bodies(const Kinematics& kinematics) {
  nearby_.scatter(kinematics, returned_mass());
  for (std::size_t place = 0; place < nearby_.bodies().size(); ++place)
    map_.bodies()[nearby_.bodies()[place]].move(nearby_.kinematics(), place, units_);
  if (map_.update(nearby_.bodies())) links_.update();
  films_.find(nearby_.bodies(), nearby_.kinematics());
}

template <class T>
void LatticeBoltzmann<T>::exchange(const Kinematics& kinematics, Loads& loads) {
  timer_.start();
  domain_.set_step(step_);
  map_bodies(kinematics);
  timer_.book(Phase::map);
  load_sums_.assign(nearby_.bodies().size(), LoadSums{});
  gained_momentum_ = {};
  (*refill_)(populations_.data(), placement_, map_);
  map_.accept_fresh_cells();
  timer_.book(Phase::refill);

  has_halo_ = false;
  if (exchange_momentum_->uses_second_cell) {
    start_halo();
    receive_halo();
  }
  count_changed_cells();
  links_.fetch(populations_.data(), placement_);
  MomentumSums kept_back{};
  (*exchange_momentum_)(nearby_.bodies(), links_, nearby_.returned_mass(), load_sums_, kept_back);
  for (std::size_t axis = 0; axis < 3; ++axis) gained_momentum_[axis] -= kept_back[axis];
  timer_.book(Phase::momentum);
  sum_loads(kinematics, loads);
  timer_.book(Phase::reduce);
  loads.flow.resize(0);
  if (setup_.flow.values_in(kinematics.step) == 0) return;
  if (!setup_.flow.faces.empty() && !has_halo_) {
    start_halo();
    receive_halo();
  }
  loads.flow = sample_flow_([this](const Box& box) { return fields(box); },
                            [this](const FlowSampler::VisitCrossing& visit) { visit_crossings(visit); });
  timer_.book(Phase::output);
}

/// Between cells of fluid of this rank and faces of the domain, in the next update. What crosses a mirror comes back to
/// some other cell; the sum over the mirror is that of what leaves. It is reflected twice where a body is beyond.
template <class T>
void LatticeBoltzmann<T>::visit_crossings(const FlowSampler::VisitCrossing& visit) {
  std::map<std::int64_t, double> let_in;
  for_each_let_in([&](std::int64_t place, T value) { let_in[place] = value; });
  for_each_entering(layout_.block(), [&](const Cell& ghost, int direction) {
    const auto& e = d3q19::e[direction];
    const Site site = layout_.site(Cell{ghost[0] + e[0], ghost[1] + e[1], ghost[2] + e[2]});
    if (domain_.box().contains(ghost) || map_.owner(site.index) != BodyMap::fluid) return;
    const GhostSource source = ghost_source(domain_, ghost, direction);
    const auto place = static_cast<std::size_t>(layout_.location(site, d3q19::opposite(direction), placement_));
    const double leaving = (map_.owner(layout_.cell(ghost)) > BodyMap::fluid ? 2.0 : 1.0) * populations_[place];
    const bool is_open = source.kind == GhostSource::Kind::open;
    visit({ghost, direction, leaving,
           is_open ? let_in.at(layout_.entry(site, direction, placement_)) : leaving + source.addition});
  });
}

/// Mass and momentum of covered cells leave the fluid, those of refilled cells enter it.
template <class T>
void LatticeBoltzmann<T>::count_changed_cells() {
  const auto add = [this](const BodyMap::ChangedCell& changed, fixed_point::Sum sign) {
    if (!layout_.block().contains(changed.cell())) return;
    const Moments<double> m = moments_of(layout_.site(changed.cell()));
    load_sums_[nearby_.place_of(changed.body)][mass_component] += sign * fixed_point::from_double(m.excess_density);
    for (std::size_t axis = 0; axis < 3; ++axis)
      gained_momentum_[axis] -= sign * fixed_point::from_double(m.momentum[axis]);
  };
  for (const BodyMap::ChangedCell& covered : map_.covered()) add(covered, 1);
  for (const BodyMap::ChangedCell& uncovered : map_.uncovered()) add(uncovered, -1);
}

template <class T>
std::vector<double> LatticeBoltzmann<T>::returned_mass() const {
  constexpr double share = 1.0 / 16.0;  // all of it would excite an oscillation of period two
  std::vector<double> returned;
  if (communicator_.rank() != 0 || !exchange_momentum_->conserving) return returned;
  for (const auto& of_body : absorbed_mass_.colwise())
    returned.push_back(of_body[1] > 0.0 ? share * of_body[0] / of_body[1] : 0.0);
  return returned;
}

template <class T>
void LatticeBoltzmann<T>::sum_loads(const Kinematics& kinematics, Loads& loads) {
  nearby_.gather(load_sums_, gained_momentum_);
  if (communicator_.rank() != 0) return;
  for (std::size_t axis = 0; axis < 3; ++axis) momentum_.gained[axis] += fixed_point::to_double(gained_momentum_[axis]);
  report_loads(kinematics, loads);
  if (!exchange_momentum_->conserving) return;
  for (Eigen::Index b = 0; b < absorbed_mass_.cols(); ++b) {
    absorbed_mass_(0, b) += total_lu(b, mass_component);
    absorbed_mass_(1, b) = total_lu(b, weight_component);
  }
}

/// Sums to SI units, for whole bodies.
template <class T>
void LatticeBoltzmann<T>::report_loads(const Kinematics& kinematics, Loads& loads) {
  const LatticeUnits units = units_;  // a copy: its factors are computed once, whatever the loads overwrite
  loads.step = kinematics.step;
  loads.resize(kinematics.bodies());
  for (Eigen::Index b = 0; b < kinematics.bodies(); ++b) {
    WholeBody whole;
    double images = 1.0;
    for (int plane = 0; plane < 3; ++plane) {
      if (!domain_.symmetric(plane)) continue;
      if (domain_.cut_by_symmetry_plane(units.position_lu(kinematics.position_m.col(b)), plane))
        whole.cut(plane);
      else
        images *= 2.0;
    }
    Eigen::Vector3d force_lu;
    for (int axis = 0; axis < 3; ++axis) {
      force_lu[axis] = total_lu(b, axis) * whole.force[axis];
      loads.force_N(axis, b) = units.force_N(force_lu[axis]);
      loads.torque_N_m(axis, b) = units.torque_N_m(total_lu(b, 3 + axis) * whole.torque[axis]);
    }
    momentum_.exchanged += images * force_lu.norm();
  }
}

template <class T>
void LatticeBoltzmann<T>::update(const Box& region) {
  const RowsBesideBodies<T> rows = links_.rows();
  stream_collide_(populations_.data(), layout_, placement_, region, constants_, has_force_,
                  setup_.bodies.empty() ? nullptr : &rows);
}

template <class T>
void LatticeBoltzmann<T>::receive_halo() {
  halo_.wait();
  timer_.book(Phase::wait);
  halo_.finish(populations_.data(), placement_);
  has_halo_ = true;
  timer_.book(Phase::halo);
}

template <class T>
template <class Visit>
void LatticeBoltzmann<T>::for_each_let_in(const Visit& visit) {
  if (setup_.bodies.empty())
    open_faces_.for_each_entering(
        populations_.data(), placement_, [](std::int64_t) { return false; }, visit);
  else
    open_faces_.for_each_entering(
        populations_.data(), placement_, [this](std::int64_t cell) { return map_.owner(cell) > BodyMap::fluid; },
        visit);
}

template <class T>
void LatticeBoltzmann<T>::advance() {
  timer_.start();
  if (step_ == 0) {
    output_.after_step(0, [this] { return fields(); });  // the exchange has put the bodies in place
    timer_.book(Phase::output);
  }
  if (!has_halo_) start_halo();
  if (!has_halo_ && !open_faces_.empty()) receive_halo();
  // Before walls: it needs the moments of populations that no wall has changed.
  for_each_let_in([this](std::int64_t place, T value) { populations_[place] = value; });
  moving_walls_.apply(populations_.data(), placement_);
  timer_.book(Phase::halo);
  update(halo_.interior());
  timer_.book(Phase::bulk);
  nearby_.finish();
  if (!has_halo_) receive_halo();
  for (const Box& slab : halo_.border()) update(slab);
  placement_ = other(placement_);
  ++step_;
  timer_.book(Phase::bulk);
  check_rows();
  timer_.book(Phase::check);
  output_.after_step(step_, [this] { return fields(); });
  timer_.book(Phase::output);
}

/// Looks at one row of 1024 of the domain, or of as many as there are, another one in each step: every cell is seen
/// within 1024 steps, in a step that does not depend on the ranks.
template <class T>
void LatticeBoltzmann<T>::check_rows() const {
  const Box& block = layout_.block();
  const std::int64_t width = domain_.cells()[1];
  const std::int64_t interval = std::min<std::int64_t>(1024, domain_.cells()[0] * width);
  for (std::int64_t x = block.low[0]; x < block.high[0]; ++x) {
    const std::int64_t first = block.low[1] + wrapped(step_ - x * width - block.low[1], interval);
    for (std::int64_t y = first; y < block.high[1]; y += interval) check_row(x, y);
  }
}

/// Before anything is saved or summed up: no run ends well with a flow that diverged since its row was seen.
template <class T>
void LatticeBoltzmann<T>::check_all_rows() const {
  const Box& block = layout_.block();
  for (std::int64_t x = block.low[0]; x < block.high[0]; ++x) {
    for (std::int64_t y = block.low[1]; y < block.high[1]; ++y) check_row(x, y);
    communicator_.context().report_progress();
  }
}

template <class T>
void LatticeBoltzmann<T>::check_row(std::int64_t x, std::int64_t y) const {
  const Box& block = layout_.block();
  for (std::int64_t z = block.low[2]; z < block.high[2]; ++z)
    if (map_.owner(layout_.cell(Cell{x, y, z})) == BodyMap::fluid) static_cast<void>(checked_moments({x, y, z}));
}

template <class T>
Moments<double> LatticeBoltzmann<T>::checked_moments(const Cell& cell) const {
  constexpr double largest_excess_density = 0.5;
  const Moments<double> m = moments_of(layout_.site(cell));
  const double momentum = m.momentum_vector().norm();
  if (std::abs(m.excess_density) < largest_excess_density && momentum < largest_speed_lu) return m;
  throw SolverError("the flow diverged at cell (" + std::to_string(cell[0]) + ", " + std::to_string(cell[1]) + ", " +
                        std::to_string(cell[2]) + ") (density " + std::to_string(1.0 + m.excess_density) +
                        ", momentum " + std::to_string(momentum) +
                        " in lattice units). Use collision: central_moments, a relaxation time nearer to 1, "
                        "or slower motion.",
                    communicator_.rank(), step_ - 1);
}

template <class T>
FieldBlock LatticeBoltzmann<T>::fields(const Box& box) const {
  FieldBlock result{.box = box, .density_kg_per_m3 = {}, .velocity_m_per_s = {}, .body = {}};
  const auto cells = static_cast<std::size_t>(box.volume());
  result.density_kg_per_m3.reserve(cells);
  result.velocity_m_per_s.reserve(3 * cells);
  result.body.reserve(cells);
  // Half of the force that the collision added belongs to the next half step [Guo, Zheng, Shi 2002].
  const Eigen::Vector3d half_force = 0.5 * units_.body_force_lu(setup_.body_force_N_per_m3);
  const auto add = [&](const Cell& cell) {
    const std::int32_t owner = map_.owner(layout_.cell(cell));
    Eigen::Vector3d velocity;
    double density = 1.0;
    if (owner > BodyMap::fluid) {
      const LatticeBody& body = map_.bodies()[owner - 1];
      velocity = body.surface_velocity(domain_.from_position(body.position, cell));
    } else {
      const Moments<double> m = checked_moments(cell);
      density += m.excess_density;
      velocity = (m.momentum_vector() - half_force) / density;
    }
    result.density_kg_per_m3.push_back(units_.density_kg_per_m3(density));
    for (int axis = 0; axis < 3; ++axis) result.velocity_m_per_s.push_back(units_.velocity_m_per_s(velocity[axis]));
    result.body.push_back(owner);
  };
  for_each_cell(box, add, showing_progress());
  return result;
}

/// Of the fluid cells of this rank: their digest, and their mass over fluid of the reference density.
template <class T>
auto LatticeBoltzmann<T>::total_of_cells() const -> Total {
  Total total;
  const auto add = [&](const Cell& cell) {
    const Site site = layout_.site(cell);
    if (map_.owner(site.index) != BodyMap::fluid) return;
    total.excess_mass += fixed_point::from_double(checked_moments(cell).excess_density);
    total.digest += digest_of_cell(domain_.cells(), cell,
                                   [&](int alpha) { return populations_[layout_.location(site, alpha, placement_)]; });
  };
  for_each_cell(layout_.block(), add, showing_progress());
  return total;
}

/// Of the whole domain, relative to what its bodies exchanged; none if they exchanged nothing.
template <class T>
std::optional<double> LatticeBoltzmann<T>::momentum_drift() const {
  if (momentum_.exchanged == 0.0) return std::nullopt;
  Eigen::Vector3d gained = momentum_.gained;
  for (int plane = 0; plane < 3; ++plane) {
    if (!domain_.symmetric(plane)) continue;
    gained[plane] = 0.0;
    gained *= 2.0;
  }
  return gained.norm() / momentum_.exchanged;
}

template <class T>
SolverSummary LatticeBoltzmann<T>::summarise() {
  SolverSummary summary;
  timer_.start();
  const Total total = total_of_cells();
  const auto [excess_low, excess_high] = fixed_point::halves(total.excess_mass);
  std::int64_t sums[] = {static_cast<std::int64_t>(total.digest), excess_low, excess_high};
  communicator_.sum_to_leader(sums);
  summary.digest = static_cast<std::uint64_t>(sums[0]);
  summary.mass_drift =
      fixed_point::to_double(fixed_point::from_halves(sums[1], sums[2])) / static_cast<double>(domain_.box().volume());
  summary.momentum_drift = momentum_drift();
  summary.cell_updates = static_cast<std::uint64_t>(domain_.box().volume() * step_);
  summary.ranks = communicator_.size();
  timer_.book(Phase::summary);
  summary.seconds = timer_.seconds();
  summary.body_phases = {"map", "refill", "momentum", "reduce"};
  summary.waiting_phases = {"wait"};
  return summary;
}

// A checkpoint holds populations by cell and direction, wherever the step's parity stored them, and the
// kinematics of the last exchange: which cells were covered decides which are uncovered next.

template <class T>
template <class Visit>
void LatticeBoltzmann<T>::for_each_population(const Box& piece, Placement placement, const Visit& visit) const {
  for_each_cell(piece, [&](const Cell& cell) {
    for (int alpha = 0; alpha < d3q19::directions; ++alpha)
      visit(layout_.location(layout_.site(cell), alpha, placement));
  });
}

template <class T>
void LatticeBoltzmann<T>::save(const std::string& path) {
  check_all_rows();
  const auto get = [this](const Box& piece, std::span<T> populations) {
    auto next = populations.begin();
    for_each_population(piece, placement_, [&](std::size_t location) { *next++ = populations_[location]; });
  };
  save_populations<T>(path, communicator_, {layout_digest(setup_), domain_.cells(), step_}, layout_.block(), get,
                      {nearby_.all_kinematics(), absorbed_mass_, output_.mean(), output_.sampling(), momentum_});
}

template <class T>
void LatticeBoltzmann<T>::restore(const std::string& path) {
  const auto placement_after = [](std::int64_t step) { return step % 2 == 0 ? Placement::home : Placement::streamed; };
  const auto take = [&](const PopulationHeader& header, const Box& piece, std::span<const T> populations) {
    auto next = populations.begin();
    for_each_population(piece, placement_after(header.step),
                        [&](std::size_t location) { populations_[location] = *next++; });
  };
  FluidState state;
  step_ = restore_populations<T>(path, communicator_, {layout_digest(setup_), domain_.cells(), 0}, layout_.block(),
                                 take, state)
              .step;
  placement_ = placement_after(step_);
  output_.restore(step_, state.sampling, std::move(state.mean));
  absorbed_mass_ = state.absorbed_mass;
  momentum_ = state.momentum;
  map_bodies(state.kinematics);
  nearby_.finish();
  map_.accept_fresh_cells();
  links_.forget_populations();
}

template class LatticeBoltzmann<float>;
template class LatticeBoltzmann<double>;

namespace {

std::unique_ptr<FluidSolver> of_precision(const FluidSetup& setup, Communicator& communicator) {
  if (setup.precision == Precision::single_precision)
    return std::make_unique<LatticeBoltzmann<float>>(setup, communicator);
  return std::make_unique<LatticeBoltzmann<double>>(setup, communicator);
}

/// Obstacles are bodies after the others, which stay where the setup has them.
class WithObstacles final : public FluidSolver {
 public:
  WithObstacles(const FluidSetup& setup, Communicator& communicator)
      : obstacles_(setup.obstacles), solver_(of_precision(as_bodies(setup), communicator)) {}

  void exchange(const Kinematics& kinematics, Loads& loads) override {
    const Eigen::Index bodies = kinematics.bodies();
    const auto all = bodies + static_cast<Eigen::Index>(obstacles_.size());
    if (all_.bodies() != all) place(all);
    all_.step = kinematics.step;
    all_.position_m.leftCols(bodies) = kinematics.position_m;
    all_.orientation_wxyz.leftCols(bodies) = kinematics.orientation_wxyz;
    all_.velocity_m_per_s.leftCols(bodies) = kinematics.velocity_m_per_s;
    all_.angular_velocity_rad_per_s.leftCols(bodies) = kinematics.angular_velocity_rad_per_s;
    solver_->exchange(all_, loads);
    if (loads.bodies() == all) keep_wanted(loads, bodies);  // rank 0 has them
  }
  void advance() override { solver_->advance(); }
  void save(const std::string& path) override { solver_->save(path); }
  void restore(const std::string& path) override { solver_->restore(path); }
  SolverSummary summarise() override { return solver_->summarise(); }

 private:
  /// Of the columns behind those of the bodies: those of obstacles with loads.
  void keep_wanted(Loads& loads, Eigen::Index bodies) const {
    Eigen::Index kept = bodies;
    for (const ObstacleSpecification& obstacle : obstacles_) {
      const Eigen::Index column = bodies++;
      if (!obstacle.loads) continue;
      loads.force_N.col(kept) = loads.force_N.col(column);
      loads.torque_N_m.col(kept++) = loads.torque_N_m.col(column);
    }
    loads.force_N.conservativeResize(Eigen::NoChange, kept);
    loads.torque_N_m.conservativeResize(Eigen::NoChange, kept);
  }
  /// Those that are not placed as compounds, which have images, and no films.
  static FluidSetup as_bodies(FluidSetup setup) {
    for (const ObstacleSpecification& obstacle : setup.obstacles) {
      const Shape& shape = obstacle.shape;
      setup.bodies.push_back(is_placed(shape) ? shape
                                              : Shape{.kind = ShapeKind::compound, .parts = {{.shape = shape}}});
    }
    return setup;
  }
  void place(Eigen::Index all) {
    all_.resize(all);
    Eigen::Index column = all - static_cast<Eigen::Index>(obstacles_.size());
    for (const ObstacleSpecification& obstacle : obstacles_) {
      all_.position_m.col(column) = obstacle.position_m;
      all_.orientation_wxyz.col(column) = obstacle.orientation_wxyz;
      all_.velocity_m_per_s.col(column).setZero();
      all_.angular_velocity_rad_per_s.col(column++).setZero();
    }
  }

  std::vector<ObstacleSpecification> obstacles_;
  std::unique_ptr<FluidSolver> solver_;
  Kinematics all_;
};

}  // namespace

std::unique_ptr<FluidSolver> make_lattice_boltzmann(const FluidSetup& setup, Communicator& communicator) {
  if (!setup.obstacles.empty()) return std::make_unique<WithObstacles>(setup, communicator);
  return of_precision(setup, communicator);
}

}  // namespace copepod::fluid
