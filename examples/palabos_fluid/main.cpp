// Palabos as a fluid of Copepod: rank 0 serves the coupler and gives orders to the other ranks.
//   deploy/copepod run CASE.yaml --fluid /tmp/palabos_fluid/palabos_fluid --ranks 2
#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sys/prctl.h>
#include <time.h>
#include <unistd.h>

#include <mpi.h>

#include "component/run_component.hpp"
#include "contract/digest.hpp"
#include "contract/errors.hpp"
#include "flow.hpp"

namespace {

using namespace copepod;

/// Sends bytes from rank 0 to all. MPI would wait with all of a core; this sleeps ever longer, up to 1 ms.
void broadcast(void* bytes, std::size_t count) {
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Ibcast(bytes, static_cast<int>(count), MPI_BYTE, 0, MPI_COMM_WORLD, &request);
  int done = 0;
  for (long waited_ns = 0;; waited_ns += 1000 + waited_ns / 8) {
    MPI_Test(&request, &done, MPI_STATUS_IGNORE);
    if (done != 0) return;
    const timespec pause{0, std::min(waited_ns / 8, 1'000'000L)};
    nanosleep(&pause, nullptr);
  }
}

template <class Items>
void broadcast_all(Items& items) {
  std::size_t count = items.size();
  broadcast(&count, sizeof(count));
  items.resize(count);
  broadcast(items.data(), count * sizeof(items[0]));
}

enum class Order { construct, force_bodies, advance, save, restore, digest, stop };

/// An order and what belongs to it: the flow and its bodies, or motions; the path of a file.
struct Message {
  Order order = Order::stop;
  std::vector<double> numbers = {};
  std::string path = {};
};

/// The flow on all ranks.
class Ranks {
 public:
  /// Carries out an order of rank 0; collective. @return false if it was the last one
  bool carry_out(Message message = {}) {
    broadcast(&message.order, sizeof(message.order));
    broadcast_all(message.numbers);
    broadcast_all(message.path);
    if (message.order == Order::construct) construct(message.numbers);
    if (message.order == Order::force_bodies) loads = flow->force_bodies(motions_of(message.numbers));
    if (message.order == Order::advance) flow->advance();
    if (message.order == Order::save) flow->save(message.path);
    if (message.order == Order::restore) flow->restore(message.path, motions_of(message.numbers));
    if (message.order == Order::digest) digest = flow->digest();
    return message.order != Order::stop;
  }

  std::unique_ptr<PalabosFlow> flow;
  BodyLoads loads;
  std::uint64_t digest = 0;

 private:
  void construct(const std::vector<double>& numbers) {
    FlowSetup setup{};
    std::vector<BodyShape> shapes((numbers.size() * sizeof(double) - sizeof(setup)) / sizeof(BodyShape));
    std::memcpy(&setup, numbers.data(), sizeof(setup));
    std::memcpy(shapes.data(), numbers.data() + sizeof(setup) / sizeof(double), shapes.size() * sizeof(BodyShape));
    flow = std::make_unique<PalabosFlow>(setup, shapes);
  }
  static Motions motions_of(const std::vector<double>& numbers) {
    return Eigen::Map<const Motions>(numbers.data(), 13, static_cast<Eigen::Index>(numbers.size()) / 13);
  }
};

std::array<double, 3> scaled(const Eigen::Vector3d& vector, double factor) {
  return {factor * vector.x(), factor * vector.y(), factor * vector.z()};
}

std::vector<double> numbers_of(const Motions& motions) { return {motions.data(), motions.data() + motions.size()}; }

std::uint64_t digest_of_file(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  return digest_of(std::string(std::istreambuf_iterator<char>(stream), {}));
}

/// The fluid as the kit calls it, on rank 0. Converts SI units to lattice units, in which the fluid's density is 1.
class PalabosFluid final : public FluidSolver {
 public:
  PalabosFluid(const FluidSetup& setup, Ranks& ranks)
      : ranks_(ranks), setup_(setup), speed_m_per_s_(setup.cell_size_m / setup.step_s) {
    const double viscosity = setup.kinematic_viscosity_m2_per_s / (speed_m_per_s_ * setup.cell_size_m);
    FlowSetup flow{};
    std::copy(setup.domain_cells.begin(), setup.domain_cells.end(), flow.cells.begin());
    for (std::size_t face = 0; face < 6; ++face) {
      const Boundary& boundary = setup.boundaries[face];
      flow.periodic[face / 2] = boundary.kind == BoundaryKind::periodic ? 1.0 : 0.0;
      flow.wall_velocity[face] = scaled(boundary.velocity_m_per_s, 1 / speed_m_per_s_);
    }
    flow.body_force = scaled(setup.body_force_N_per_m3, setup.step_s / speed_m_per_s_ / setup.density_kg_per_m3);
    flow.omega = 1 / (3 * viscosity + 0.5);
    flow.two_relaxation_times = setup.collision == CollisionKind::trt ? 1.0 : 0.0;
    std::vector<double> numbers(sizeof(flow) / sizeof(double));
    std::memcpy(numbers.data(), &flow, sizeof(flow));
    for (const Shape& shape : setup.bodies)
      for (const double length_m : {shape.radius_m, core_half_length_m(shape)})
        numbers.push_back(length_m / setup.cell_size_m);
    ranks_.carry_out({Order::construct, numbers});
  }

  void exchange(const Kinematics& kinematics, Loads& loads) override {
    Motions motions(13, kinematics.bodies());
    motions.topRows<3>() = kinematics.position_m / setup_.cell_size_m;
    motions.middleRows<4>(3) = kinematics.orientation_wxyz;
    motions.middleRows<3>(7) = kinematics.velocity_m_per_s / speed_m_per_s_;
    motions.bottomRows<3>() = kinematics.angular_velocity_rad_per_s * setup_.step_s;
    for (Eigen::Index i = 0; i < motions.cols(); ++i) check(motions.col(i), kinematics.step);
    ranks_.carry_out({Order::force_bodies, numbers_of(motions)});
    if (!ranks_.loads.allFinite())
      throw SolverError("the flow diverged (a load is not finite). Use a smaller step or slower bodies.", 0,
                        kinematics.step);
    const double force_N = setup_.density_kg_per_m3 * std::pow(speed_m_per_s_ * setup_.cell_size_m, 2);
    loads.step = kinematics.step;
    loads.force_N = force_N * ranks_.loads.topRows<3>();
    loads.torque_N_m = force_N * setup_.cell_size_m * ranks_.loads.bottomRows<3>();
  }

  void advance() override {
    ranks_.carry_out({Order::advance});
    ++steps_;
  }

  void save(const std::string& path) override {
    std::error_code problem;
    std::filesystem::create_directory(path, problem);
    std::ofstream bodies(path + "/bodies", std::ios::binary);
    if (bodies) ranks_.carry_out({Order::save, {}, path + "/populations"});
    const std::uint64_t digest = digest_of_file(path + "/populations");
    const std::vector<double> previous = numbers_of(ranks_.flow->previous());
    bodies.write(reinterpret_cast<const char*>(&digest), sizeof(digest));
    bodies.write(reinterpret_cast<const char*>(&steps_), sizeof(steps_));
    bodies.write(reinterpret_cast<const char*>(previous.data()), static_cast<std::streamsize>(8 * previous.size()));
    bodies.close();
    sync();
    if (!bodies) throw StorageError("The folder " + path + " cannot be written (full disk?). Choose another path.");
  }

  void restore(const std::string& path) override {
    std::ifstream bodies(path + "/bodies", std::ios::binary);
    std::uint64_t digest = 0;
    std::vector<double> previous(13 * setup_.bodies.size());
    bodies.read(reinterpret_cast<char*>(&digest), sizeof(digest));
    bodies.read(reinterpret_cast<char*>(&steps_), sizeof(steps_));
    bodies.read(reinterpret_cast<char*>(previous.data()), static_cast<std::streamsize>(8 * previous.size()));
    if (!bodies || digest != digest_of_file(path + "/populations"))
      throw StorageError("The folder " + path + " cannot be read (missing or damaged). Choose another one.");
    ranks_.carry_out({Order::restore, previous, path + "/populations"});
  }

  SolverSummary summarise() override {
    int ranks = 1;
    MPI_Comm_size(MPI_COMM_WORLD, &ranks);
    ranks_.carry_out({Order::digest});
    std::uint64_t updates = steps_;
    for (const std::int64_t cells : setup_.domain_cells) updates *= static_cast<std::uint64_t>(cells);
    return {ranks_.digest, updates, ranks, {}};
  }

 private:
  /// @throws SolverError if a body is too fast, or beyond a face that is not periodic
  void check(const Eigen::Matrix<double, 13, 1>& motion, std::int64_t step) const {
    bool fine = motion.segment<3>(7).norm() < largest_speed_lu;
    for (int axis = 0; axis < 3; ++axis)
      fine = fine && (setup_.boundaries[2 * axis].kind == BoundaryKind::periodic ||
                      (motion[axis] > 0 && motion[axis] < static_cast<double>(setup_.domain_cells[axis])));
    if (!fine)
      throw SolverError("a body left the domain or is too fast (above 0.4 cells per step). Use a smaller step.", 0,
                        step);
  }

  Ranks& ranks_;
  FluidSetup setup_;
  double speed_m_per_s_;  ///< of one cell per step
  std::uint64_t steps_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  Ranks ranks;
  const FluidComponent component{
      {"Palabos",
       "1.5",
       {"solver:external", "collision:bgk", "collision:trt", "precision:double", "boundary:no_slip",
        "boundary:periodic", "boundary:velocity", "body_force", "shape:sphere", "shape:capsule", "checkpoint", "mpi"}},
      [&ranks](const FluidSetup& setup, SolverContext&) { return std::make_unique<PalabosFluid>(setup, ranks); }};
  if (!starts_service(argc, argv)) return run_fluid_component(argc, argv, component);

  prctl(PR_SET_PDEATHSIG, SIGKILL);  // a killed mpirun leaves no rank behind
  MPI_Init(nullptr, nullptr);
  int rank = 0, size = 1, code = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  if (rank == 0) {
    SolverContext context;
    code = run_fluid_component(argc, argv, component, size, context);
    alarm(10);  // the others may no longer answer after an error
    ranks.carry_out({Order::stop});
  } else {
    while (ranks.carry_out()) {
    }
  }
  MPI_Finalize();
  return code;
}
