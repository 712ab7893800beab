// Palabos as a fluid of Copepod: rank 0 speaks to the coupler and tells the other ranks what to do.
//   deploy/copepod run CASE.yaml --fluid /tmp/palabos_fluid/palabos_fluid --ranks 2
#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <sys/prctl.h>
#include <time.h>
#include <utility>

#include <mpi.h>

#include "component/run_component.hpp"
#include "contract/digest.hpp"
#include "contract/errors.hpp"
#include "flow.hpp"

namespace {

using namespace copepod;

enum class Order { construct, step, save, restore, summarise, stop };

/// Sends bytes from rank 0 to all. MPI would wait with all of a core; this sleeps ever longer, up to 1 ms.
void broadcast(void* bytes, std::size_t count) {
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Ibcast(bytes, static_cast<int>(count), MPI_BYTE, 0, MPI_COMM_WORLD, &request);
  long pause_ns = 0;
  for (int done = 0;;) {
    MPI_Test(&request, &done, MPI_STATUS_IGNORE);
    if (done != 0) return;
    const timespec pause{0, pause_ns / 8};
    nanosleep(&pause, nullptr);
    pause_ns = std::min(pause_ns + pause.tv_nsec + 500, 8'000'000L);
  }
}

template <class T>
void broadcast(std::vector<T>& items) {
  std::size_t count = items.size();
  broadcast(&count, sizeof(count));
  items.resize(count);
  broadcast(items.data(), count * sizeof(T));
}

/// What every rank does, rank 0 included; arguments matter on rank 0 only.
class Ranks {
 public:
  /// Carries out the orders of rank 0 until it says stop.
  void follow() {
    for (;;) {
      Order order{};
      broadcast(&order, sizeof(order));
      if (order == Order::stop) return;
      if (order == Order::construct) construct({}, {});
      if (order == Order::step) force_bodies({}), flow_->advance();
      if (order == Order::save) save({});
      if (order == Order::restore) restore({}, {});
      if (order == Order::summarise) static_cast<void>(flow_->digest());
    }
  }
  static void give(Order order) { broadcast(&order, sizeof(order)); }

  void construct(FlowSetup setup, std::vector<BodyShape> shapes) {
    broadcast(&setup, sizeof(setup));
    broadcast(shapes);
    flow_ = std::make_unique<PalabosFlow>(setup, shapes);
  }
  std::vector<BodyLoad> force_bodies(std::vector<BodyMotion> motions) {
    broadcast(motions);
    return flow_->force_bodies(motions);
  }
  void save(const std::string& file) { flow_->save(from_rank_0(file)); }
  void restore(const std::string& file, std::vector<BodyMotion> previous) {
    broadcast(previous);
    flow_->restore(from_rank_0(file), previous);
  }
  PalabosFlow& flow() { return *flow_; }

 private:
  static std::string from_rank_0(const std::string& text) {
    std::vector<char> letters(text.begin(), text.end());
    broadcast(letters);
    return {letters.begin(), letters.end()};
  }
  std::unique_ptr<PalabosFlow> flow_;
};

std::array<double, 3> scaled(const Eigen::Vector3d& vector, double factor) {
  return {factor * vector.x(), factor * vector.y(), factor * vector.z()};
}

std::string content_of(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream content;
  content << stream.rdbuf();
  return content.str();
}

/// The fluid as the kit calls it, on rank 0. Converts SI units to lattice units, in which the fluid's density is 1.
class PalabosFluid final : public FluidSolver {
 public:
  PalabosFluid(const FluidSetup& setup, Ranks& ranks)
      : ranks_(ranks), setup_(setup), speed_m_per_s_(setup.cell_size_m / setup.step_s) {
    FlowSetup flow;
    flow.cells = setup.domain_cells;
    for (std::size_t face = 0; face < 6; ++face) {
      const Boundary& boundary = setup.boundaries[face];
      flow.periodic[face / 2] = boundary.kind == BoundaryKind::periodic;
      flow.wall_velocity[face] = scaled(boundary.velocity_m_per_s, 1 / speed_m_per_s_);
    }
    flow.body_force = scaled(setup.body_force_N_per_m3, setup.step_s / speed_m_per_s_ / setup.density_kg_per_m3);
    const double viscosity = setup.kinematic_viscosity_m2_per_s / (speed_m_per_s_ * setup.cell_size_m);
    flow.omega = 1 / (3 * viscosity + 0.5);
    flow.two_relaxation_times = setup.collision == CollisionKind::trt;
    std::vector<BodyShape> shapes;
    for (const Shape& shape : setup.bodies)
      shapes.push_back({shape.radius_m / setup.cell_size_m, core_half_length_m(shape) / setup.cell_size_m});
    Ranks::give(Order::construct);
    ranks_.construct(flow, shapes);
  }

  /// The other ranks are in the bulk update already if only its order is missing here.
  ~PalabosFluid() override {
    if (advance_due_) ranks_.flow().advance();
  }

  void exchange(const Kinematics& kinematics, Loads& loads) override {
    std::vector<BodyMotion> motions;
    for (Eigen::Index i = 0; i < kinematics.bodies(); ++i) motions.push_back(motion_of(kinematics, i));
    Ranks::give(Order::step);
    advance_due_ = true;
    const std::vector<BodyLoad> found = ranks_.force_bodies(motions);
    const double force_N = setup_.density_kg_per_m3 * std::pow(speed_m_per_s_ * setup_.cell_size_m, 2);
    loads.resize(kinematics.bodies());
    loads.step = kinematics.step;
    for (Eigen::Index i = 0; i < kinematics.bodies(); ++i) {
      const BodyLoad& load = found[static_cast<std::size_t>(i)];
      if (!load.force.allFinite() || !load.torque.allFinite())
        throw SolverError("the flow diverged (the load on a body is not finite). Use smaller steps or lower speeds.", 0,
                          kinematics.step);
      loads.force_N.col(i) = force_N * load.force;
      loads.torque_N_m.col(i) = force_N * setup_.cell_size_m * load.torque;
    }
  }

  void advance() override {
    advance_due_ = false;
    ranks_.flow().advance();
    ++steps_;
  }

  void save(const std::string& path) override {
    std::error_code problem;
    std::filesystem::create_directory(path, problem);
    const std::string populations = path + "/populations";
    std::ofstream bodies(path + "/bodies");
    if (problem || !bodies)
      throw StorageError("The folder " + path + " cannot be written (" + problem.message() + "). Choose another path.");
    Ranks::give(Order::save);
    ranks_.save(populations);
    bodies.precision(17);
    bodies << digest_of(content_of(populations)) << ' ' << steps_ << '\n';
    for (BodyMotion motion : ranks_.flow().previous()) {
      for_each_number(motion, [&](double& number) { bodies << number << ' '; });
      bodies << '\n';
    }
    bodies << "end" << std::endl;
    if (!bodies) throw StorageError("The folder " + path + " cannot be written (full disk?). Choose another path.");
  }

  void restore(const std::string& path) override {
    std::ifstream bodies(path + "/bodies");
    std::uint64_t digest = 0;
    bodies >> digest >> steps_;
    std::vector<BodyMotion> previous(setup_.bodies.size());
    for (BodyMotion& motion : previous) for_each_number(motion, [&](double& number) { bodies >> number; });
    std::string end;
    bodies >> end;
    if (end != "end" || digest != digest_of(content_of(path + "/populations")))
      throw StorageError("The folder " + path + " cannot be read (missing or damaged). Choose another one.");
    Ranks::give(Order::restore);
    ranks_.restore(path + "/populations", previous);
  }

  SolverSummary summarise() override {
    int ranks = 1;
    MPI_Comm_size(MPI_COMM_WORLD, &ranks);
    Ranks::give(Order::summarise);
    const auto cells =
        static_cast<std::uint64_t>(setup_.domain_cells[0] * setup_.domain_cells[1] * setup_.domain_cells[2]);
    return {ranks_.flow().digest(), cells * steps_, ranks, {}};
  }

 private:
  template <class Action>
  static void for_each_number(BodyMotion& motion, const Action& action) {
    for (double& number : motion.position) action(number);
    for (double& number : motion.orientation_wxyz) action(number);
    for (double& number : motion.velocity) action(number);
    for (double& number : motion.spin) action(number);
  }

  [[nodiscard]] BodyMotion motion_of(const Kinematics& kinematics, Eigen::Index i) const {
    BodyMotion motion;
    motion.position = scaled(kinematics.position_m.col(i), 1 / setup_.cell_size_m);
    for (Eigen::Index k = 0; k < 4; ++k) motion.orientation_wxyz[k] = kinematics.orientation_wxyz(k, i);
    motion.velocity = scaled(kinematics.velocity_m_per_s.col(i), 1 / speed_m_per_s_);
    motion.spin = scaled(kinematics.angular_velocity_rad_per_s.col(i), setup_.step_s);
    const Eigen::Map<const Eigen::Vector3d> velocity(motion.velocity.data());
    bool fine = velocity.norm() < largest_speed_lu;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const bool periodic = setup_.boundaries[2 * axis].kind == BoundaryKind::periodic;
      fine = fine && (periodic || (motion.position[axis] > 0 &&
                                   motion.position[axis] < static_cast<double>(setup_.domain_cells[axis])));
    }
    if (!fine)
      throw SolverError("body " + std::to_string(i) +
                            " left the domain or moves faster than 0.4 cells per step. "
                            "Use smaller steps or weaker forces.",
                        0, kinematics.step);
    return motion;
  }

  Ranks& ranks_;
  FluidSetup setup_;
  double speed_m_per_s_;  ///< of one cell per step
  std::uint64_t steps_ = 0;
  bool advance_due_ = false;
};

}  // namespace

int main(int argc, char** argv) {
  Ranks ranks;
  const FluidComponent component{
      {"Palabos",
       "1.5",
       {"solver:external", "collision:bgk", "collision:trt", "precision:double", "boundary:no_slip",
        "boundary:periodic", "boundary:velocity", "body_force", "shape:sphere", "shape:capsule", "checkpoint", "mpi"}},
      [&](const FluidSetup& setup, SolverContext&) { return std::make_unique<PalabosFluid>(setup, ranks); }};
  if (!starts_service(argc, argv)) return run_fluid_component(argc, argv, component);

  prctl(PR_SET_PDEATHSIG, SIGKILL);  // a killed mpirun leaves no rank behind
  MPI_Init(nullptr, nullptr);
  start_palabos();
  int rank = 0, size = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  int code = 0;
  if (rank == 0) {
    SolverContext context;
    code = run_fluid_component(argc, argv, component, size, context);
    Ranks::give(Order::stop);
  } else {
    ranks.follow();
  }
  MPI_Finalize();
  return code;
}
