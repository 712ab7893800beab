#include "flow.hpp"

#include <cmath>

#include <mpi.h>

// Not palabos3D.hh: the multigrid part of Palabos 1.5 does not compile as C++20.
// clang-format off
#include <palabos3D.h>
#include <parallelism/headers3D.hh>
#include <latticeBoltzmann/headers3D.hh>
#include <core/headers3D.hh>
#include <basicDynamics/headers3D.hh>
#include <complexDynamics/trtDynamics.hh>
#include <io/headers3D.hh>
#include <atomicBlock/headers3D.hh>
#include <multiBlock/headers3D.hh>
#include <algorithm/headers3D.hh>
#include <dataProcessors/headers3D.hh>
#include <coProcessors/headers3D.hh>
#include <offLattice/immersedWalls3D.hh>
// clang-format on

#include "contract/digest.hpp"
#include "points.hpp"

namespace {

template <class T>
using D3Q19 = plb::descriptors::D3Q19Descriptor<T>;
using Vector = plb::Array<double, 3>;

constexpr int iterations = 4;             ///< of the multi-direct forcing
constexpr double retraction = 0.5;        ///< of the outermost points: Palabos' kernel is four cells wide
constexpr int envelope = 3;               ///< cells that the kernel of a point beside a block reaches
constexpr double samples_per_cell = 250;  ///< of Palabos' tabulated kernel; points lie on them, so that it is exact

/// A halfway bounce-back wall that moves.
///   f_i ← f_ī + 6 t_i c_i · u
class MovingWall final : public plb::BounceBack<double, D3Q19> {
 public:
  explicit MovingWall(const Vector& velocity) : BounceBack(1.0), velocity_(velocity) {}
  [[nodiscard]] MovingWall* clone() const override { return new MovingWall(*this); }
  void collide(plb::Cell<double, D3Q19>& cell, plb::BlockStatistics& statistics) override {
    BounceBack::collide(cell, statistics);
    for (int i = 1; i < D3Q19<double>::q; ++i) {
      const auto& c = D3Q19<double>::c[i];
      cell[i] += 6 * D3Q19<double>::t[i] * (c[0] * velocity_[0] + c[1] * velocity_[1] + c[2] * velocity_[2]);
    }
  }

 private:
  Vector velocity_;
};

/// Gives every cell the momentum that the immersed boundary left in a field (exact difference method).
///   f_i ← f_i + f_i^eq(ρ, j) − f_i^eq(ρ, Σ c f)
class GiveMomentum final : public plb::BoxProcessingFunctional3D_LT<double, D3Q19, double, 3> {
 public:
  void process(plb::Box3D domain, plb::BlockLattice3D<double, D3Q19>& lattice,
               plb::TensorField3D<double, 3>& momentum) override {
    const plb::Dot3D shift = plb::computeRelativeDisplacement(lattice, momentum);
    for (plb::plint x = domain.x0; x <= domain.x1; ++x)
      for (plb::plint y = domain.y0; y <= domain.y1; ++y)
        for (plb::plint z = domain.z0; z <= domain.z1; ++z)
          give(lattice.get(x, y, z), momentum.get(x + shift.x, y + shift.y, z + shift.z));
  }
  [[nodiscard]] GiveMomentum* clone() const override { return new GiveMomentum(*this); }
  void getTypeOfModification(std::vector<plb::modif::ModifT>& modified) const override {
    modified[0] = plb::modif::staticVariables;
    modified[1] = plb::modif::nothing;
  }

 private:
  static void give(plb::Cell<double, D3Q19>& cell, const Vector& wanted) {
    double density = 0.0;
    Vector found;
    plb::momentTemplates<double, D3Q19>::get_rhoBar_j(cell, density, found);
    if (wanted == found) return;
    const double wanted_square = plb::normSqr(wanted);
    const double found_square = plb::normSqr(found);
    for (int i = 0; i < D3Q19<double>::q; ++i)
      cell[i] += cell.getDynamics().computeEquilibrium(i, density, wanted, wanted_square) -
                 cell.getDynamics().computeEquilibrium(i, density, found, found_square);
  }
};

Eigen::Map<const Eigen::Vector3d> map(const std::array<double, 3>& vector) {
  return Eigen::Map<const Eigen::Vector3d>(vector.data());
}

Eigen::Vector3d velocity_at(const BodyMotion& motion, const Eigen::Vector3d& arm) {
  return map(motion.velocity) + map(motion.spin).cross(arm);
}

/// A forcing point in the world.
struct WorldPoint {
  std::size_t body = 0;
  double volume = 0.0;
  Eigen::Vector3d arm;       ///< from the centre of its body
  Eigen::Vector3d velocity;  ///< of the body there
};

}  // namespace

struct PalabosFlow::Lattice {
  explicit Lattice(const FlowSetup& flow);
  void place(const std::vector<BodyMotion>& motions);
  void add_images(const Eigen::Vector3d& place);
  [[nodiscard]] std::vector<double> gather_forces() const;

  FlowSetup setup;
  std::array<plb::plint, 3> size{};
  std::array<plb::plint, 3> first{};  ///< fluid cell along each axis: walls are nodes of their own
  std::vector<std::vector<Point>> bodies;
  std::unique_ptr<plb::MultiBlockLattice3D<double, D3Q19>> populations;
  std::unique_ptr<plb::MultiScalarField3D<double>> density;
  std::unique_ptr<plb::MultiTensorField3D<double, 3>> momentum;
  std::unique_ptr<plb::MultiTensorField3D<double, 3>> body_force;  ///< none: zero
  std::unique_ptr<plb::MultiContainerBlock3D> container;
  std::vector<WorldPoint> points;
  // One vertex per point, and one for every periodic image of it that is near the domain.
  std::vector<Vector> vertices;
  std::vector<double> volumes;
  std::vector<std::size_t> point_of_vertex;

  [[nodiscard]] plb::Box3D fluid() const {
    return {first[0], first[0] + setup.cells[0] - 1, first[1], first[1] + setup.cells[1] - 1,
            first[2], first[2] + setup.cells[2] - 1};
  }
  [[nodiscard]] plb::Box3D face(int number) const {
    plb::Box3D box = populations->getBoundingBox();
    std::array<plb::plint*, 6> bounds{&box.x0, &box.x1, &box.y0, &box.y1, &box.z0, &box.z1};
    *bounds[number ^ 1] = *bounds[number];
    return box;
  }
};

PalabosFlow::Lattice::Lattice(const FlowSetup& flow) : setup(flow) {
  for (int axis = 0; axis < 3; ++axis) {
    first[axis] = flow.periodic[axis] ? 0 : 1;
    size[axis] = flow.cells[axis] + 2 * first[axis];
  }
  using BGK = plb::BGKdynamics<double, D3Q19>;
  using TRT = plb::TRTdynamics<double, D3Q19>;
  plb::Dynamics<double, D3Q19>* bulk = nullptr;  // Palabos takes it over
  if (flow.two_relaxation_times) {
    bulk = new TRT(flow.omega);
  } else {
    bulk = new BGK(flow.omega);
  }
  populations = std::make_unique<plb::MultiBlockLattice3D<double, D3Q19>>(size[0], size[1], size[2], bulk);
  populations->toggleInternalStatistics(false);
  density.reset(plb::generateMultiScalarField<double>(*populations, envelope).release());
  momentum.reset(plb::generateMultiTensorField<double, 3>(*populations, envelope).release());
  container = std::make_unique<plb::MultiContainerBlock3D>(*density);
  for (int axis = 0; axis < 3; ++axis) {
    for (plb::MultiBlock3D* block :
         std::initializer_list<plb::MultiBlock3D*>{populations.get(), density.get(), momentum.get()})
      block->periodicity().toggle(axis, flow.periodic[axis]);
  }
  for (const bool moving : {true, false}) {  // where faces meet, the wall at rest counts
    for (int number = 0; number < 6; ++number) {
      const auto& velocity = flow.wall_velocity[number];
      if (flow.periodic[number / 2] || map(velocity).isZero(0) == moving) continue;
      plb::defineDynamics(*populations, face(number), new MovingWall({velocity[0], velocity[1], velocity[2]}));
    }
  }
  if (const auto& f = flow.body_force; !map(f).isZero(0)) {
    body_force.reset(plb::generateMultiTensorField<double, 3>(*populations, envelope).release());
    plb::setToConstant<double, 3>(*body_force, body_force->getBoundingBox(), Vector(f[0], f[1], f[2]));
  }
  plb::initializeAtEquilibrium(*populations, populations->getBoundingBox(), 1.0, Vector(0., 0., 0.));
  populations->initialize();
}

/// Places the points of all bodies; positions count from the middle of node 0.
void PalabosFlow::Lattice::place(const std::vector<BodyMotion>& motions) {
  points.clear();
  vertices.clear();
  volumes.clear();
  point_of_vertex.clear();
  for (std::size_t body = 0; body < motions.size(); ++body) {
    const BodyMotion& motion = motions[body];
    const auto& q = motion.orientation_wxyz;
    const Eigen::Matrix3d rotation = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
    const Eigen::Vector3d centre =
        map(motion.position) + Eigen::Vector3d(first[0] - 0.5, first[1] - 0.5, first[2] - 0.5);
    for (const Point& point : bodies[body]) {
      const Eigen::Vector3d place =
          ((centre + rotation * point.place_lu) * samples_per_cell).array().round() / samples_per_cell;
      const Eigen::Vector3d arm = place - centre;
      points.push_back({body, point.volume_lu, arm, velocity_at(motion, arm)});
      add_images(place);
    }
  }
}

/// Vertices of the newest point: the one inside the domain, and its images that act on it across periodic faces.
void PalabosFlow::Lattice::add_images(const Eigen::Vector3d& place) {
  std::array<std::vector<double>, 3> along;
  for (int axis = 0; axis < 3; ++axis) {
    const auto length = static_cast<double>(size[axis]);
    double x = place[axis];
    if (setup.periodic[axis]) x -= length * std::floor((x + 0.5) / length);
    along[axis].push_back(x);
    if (!setup.periodic[axis]) continue;
    if (x < envelope) along[axis].push_back(x + length);
    if (x >= length - envelope - 1) along[axis].push_back(x - length);
  }
  for (const double x : along[0])
    for (const double y : along[1])
      for (const double z : along[2]) {
        vertices.emplace_back(x, y, z);
        volumes.push_back(points.back().volume);
        point_of_vertex.push_back(points.size() - 1);
      }
}

/// Momentum given by every point, (points, 3). A point has one owner, so the sum over ranks only collects.
std::vector<double> PalabosFlow::Lattice::gather_forces() const {
  std::vector<double> given(3 * points.size(), 0.0);
  const auto& management = container->getMultiBlockManagement();
  for (const plb::plint block : management.getLocalInfo().getBlocks()) {
    const plb::SmartBulk3D bulk(management, block);
    const plb::Box3D domain = bulk.toLocal(bulk.getBulk());
    const auto* data = dynamic_cast<const plb::ImmersedWallData3D<double>*>(container->getComponent(block).getData());
    for (std::size_t k = 0; k < data->vertices.size(); ++k) {
      if (!plb::closedOpenContained(data->vertices[k], domain)) continue;
      for (int axis = 0; axis < 3; ++axis)
        given[3 * point_of_vertex[data->globalVertexIds[k]] + axis] = data->g[k][axis];
    }
  }
  std::vector<double> all(given.size(), 0.0);
  MPI_Reduce(given.data(), all.data(), static_cast<int>(given.size()), MPI_DOUBLE, MPI_SUM, 0, MPI_COMM_WORLD);
  return all;
}

void start_palabos() { plb::global::mpi().init(MPI_COMM_WORLD); }

PalabosFlow::PalabosFlow(const FlowSetup& setup, const std::vector<BodyShape>& shapes)
    : lattice_(std::make_unique<Lattice>(setup)), previous_(shapes.size()) {
  for (const BodyShape& shape : shapes)
    lattice_->bodies.push_back(fill_body(shape.radius, shape.half_length, retraction));
}

PalabosFlow::~PalabosFlow() = default;

std::vector<BodyLoad> PalabosFlow::force_bodies(const std::vector<BodyMotion>& motions) {
  Lattice& now = *lattice_;
  now.place(motions);
  plb::computeRhoBarJ(*now.populations, *now.density, *now.momentum, now.populations->getBoundingBox());
  const auto& f = now.setup.body_force;
  if (now.body_force) plb::addInPlace(*now.momentum, *now.body_force, now.fluid());
  plb::instantiateImmersedWallData(now.vertices, now.volumes, *now.container);
  const auto velocity_of = [&now](plb::pluint vertex) {
    const Eigen::Vector3d& v = now.points[now.point_of_vertex[vertex]].velocity;
    return Vector(v.x(), v.y(), v.z());
  };
  for (int k = 0; k < iterations; ++k)
    plb::indexedInamuroIteration(velocity_of, *now.density, *now.momentum, *now.container, 1.0, true);

  const std::vector<double> given = now.gather_forces();
  std::vector<BodyLoad> loads(motions.size());
  for (std::size_t k = 0; k < now.points.size(); ++k) {
    const WorldPoint& point = now.points[k];
    const Eigen::Vector3d gain = point.velocity - velocity_at(previous_[point.body], point.arm) - map(f);
    const Eigen::Vector3d force = point.volume * gain - Eigen::Map<const Eigen::Vector3d>(&given[3 * k]);
    loads[point.body].force += force;
    loads[point.body].torque += point.arm.cross(force);
  }
  previous_ = motions;
  return loads;
}

void PalabosFlow::advance() {
  Lattice& now = *lattice_;
  plb::applyProcessingFunctional(new GiveMomentum, now.fluid(), *now.populations, *now.momentum);
  now.populations->collideAndStream();
}

void PalabosFlow::save(const std::string& file) const { plb::saveBinaryBlock(*lattice_->populations, file); }

void PalabosFlow::restore(const std::string& file, const std::vector<BodyMotion>& previous) {
  plb::loadBinaryBlock(*lattice_->populations, file);
  previous_ = previous;
}

std::uint64_t PalabosFlow::digest() const {
  const auto& populations = *lattice_->populations;
  std::uint64_t sum = 0;
  for (const plb::plint block : populations.getLocalInfo().getBlocks()) {
    const plb::SmartBulk3D bulk(populations.getMultiBlockManagement(), block);
    plb::Box3D cells;
    if (!plb::intersect(bulk.getBulk(), lattice_->fluid(), cells)) continue;
    const auto& component = populations.getComponent(block);
    for (plb::plint x = cells.x0; x <= cells.x1; ++x)
      for (plb::plint y = cells.y0; y <= cells.y1; ++y)
        for (plb::plint z = cells.z0; z <= cells.z1; ++z) {
          copepod::Digest digest;
          for (const plb::plint index : {x, y, z}) digest.add(static_cast<std::uint64_t>(index));
          const auto& cell = component.get(bulk.toLocalX(x), bulk.toLocalY(y), bulk.toLocalZ(z));
          for (int i = 0; i < D3Q19<double>::q; ++i) digest.add(cell[i]);
          sum += digest.value();
        }
  }
  std::uint64_t total = 0;
  MPI_Allreduce(&sum, &total, 1, MPI_UINT64_T, MPI_SUM, MPI_COMM_WORLD);
  copepod::Digest digest(total);
  for (const BodyMotion& motion : previous_) {
    for (const auto* numbers : {&motion.position, &motion.velocity, &motion.spin})
      for (const double number : *numbers) digest.add(number);
    for (const double number : motion.orientation_wxyz) digest.add(number);
  }
  return digest.value();
}
