#include "flow.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <mpi.h>

// Not palabos3D.hh: the multigrid part of Palabos 1.5 does not compile as C++20.
#include <palabos3D.h>
// clang-format off
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

namespace {

template <class T>
using D3Q19 = plb::descriptors::D3Q19Descriptor<T>;
using Vector = plb::Array<double, 3>;
using Eigen::Vector3d;

constexpr int iterations = 4;             ///< of the multi-direct forcing
constexpr int envelope = 3;               ///< cells that the kernel of a point beside a block reaches
constexpr double samples_per_cell = 250;  ///< of Palabos' tabulated kernel; points lie on them, so that it is exact

/// Depth of the outermost points below the surface for which the drag of a sphere is right. The forced layer is as
/// thick as the kernel, and fluid diffuses √ν into it in a step. Fitted to the drag of a periodic array of spheres at
/// 0.02 < ν < 0.5; the same shift holds at radii of 3.7 and 6.2 cells.
double depth_of_points(double viscosity) { return 1.190 - 1.675 * std::sqrt(viscosity) + 0.416 * viscosity; }

/// A forcing point of a body: where it is, from the centre, and the volume that it stands for.
struct Point {
  Vector3d place;
  double volume;
};

/// Adds a ring about the z axis whose points, a multiple of four, are about a cell apart.
void add_ring(std::vector<Point>& points, double radius, double z, double volume) {
  const int count = 4 * std::max(1, static_cast<int>(std::lround(std::numbers::pi * radius / 2)));
  for (int k = 0; k < count; ++k) {
    const double angle = 2 * std::numbers::pi * (k + 0.5) / count;
    points.push_back({{radius * std::cos(angle), radius * std::sin(angle), z}, volume / count});
  }
}

/// Fills a sphere or capsule with shells one cell thick, and these with rings; symmetric about x, y and z.
std::vector<Point> fill(const BodyShape& shape, double depth) {
  constexpr double pi = std::numbers::pi;
  std::vector<Point> points;
  double inner = shape.radius;
  for (double outer = shape.radius; inner > 0; outer = inner, depth = 0.5) {
    inner = outer < 1.5 ? 0.0 : outer - 1;
    const double radius = std::max(outer - depth, 0.5 * outer);
    const int bands = 2 * std::max(1, static_cast<int>(std::lround(pi * radius / 2)));
    for (int k = 0; k < bands; ++k) {
      const double share = 0.5 * (std::cos(pi * k / bands) - std::cos(pi * (k + 1) / bands));
      const double angle = pi * (k + 0.5) / bands;
      const double z = radius * std::cos(angle);
      add_ring(points, radius * std::sin(angle), z + std::copysign(shape.half_length, z),
               share * 4.0 / 3.0 * pi * (std::pow(outer, 3) - std::pow(inner, 3)));
    }
    const int rings = static_cast<int>(std::ceil(2 * shape.half_length));
    for (int k = 0; k < rings; ++k)
      add_ring(points, radius, shape.half_length * ((2 * k + 1.0) / rings - 1),
               2 * shape.half_length * pi * (outer * outer - inner * inner) / rings);
  }
  return points;
}

/// A halfway bounce-back wall that moves.
///   f_i ← f_ī + 6 t_i c_i · u
class MovingWall final : public plb::BounceBack<double, D3Q19> {
 public:
  explicit MovingWall(const std::array<double, 3>& velocity) : BounceBack(1.0), velocity_(velocity) {}
  [[nodiscard]] MovingWall* clone() const override { return new MovingWall(*this); }
  void collide(plb::Cell<double, D3Q19>& cell, plb::BlockStatistics& statistics) override {
    BounceBack::collide(cell, statistics);
    for (int i = 1; i < D3Q19<double>::q; ++i)
      for (int axis = 0; axis < 3; ++axis)
        cell[i] += 6 * D3Q19<double>::t[i] * D3Q19<double>::c[i][axis] * velocity_[axis];
  }

 private:
  std::array<double, 3> velocity_;
};

/// Gives every cell the momentum that the immersed boundary left in a field (exact difference method).
///   f_i ← f_i + f_i^eq(ρ, j) − f_i^eq(ρ, Σ c f)
class GiveMomentum final : public plb::BoxProcessingFunctional3D_LT<double, D3Q19, double, 3> {
 public:
  void process(plb::Box3D box, plb::BlockLattice3D<double, D3Q19>& lattice,
               plb::TensorField3D<double, 3>& momentum) override {
    const plb::Dot3D shift = plb::computeRelativeDisplacement(lattice, momentum);
    for (plb::plint x = box.x0; x <= box.x1; ++x)
      for (plb::plint y = box.y0; y <= box.y1; ++y)
        for (plb::plint z = box.z0; z <= box.z1; ++z) {
          plb::Cell<double, D3Q19>& cell = lattice.get(x, y, z);
          const Vector& wanted = momentum.get(x + shift.x, y + shift.y, z + shift.z);
          double density = 0.0;
          Vector found;
          plb::momentTemplates<double, D3Q19>::get_rhoBar_j(cell, density, found);
          if (wanted == found) continue;
          const auto equilibrium = [&](int i, const Vector& j) {
            return cell.getDynamics().computeEquilibrium(i, density, j, plb::normSqr(j));
          };
          for (int i = 0; i < D3Q19<double>::q; ++i) cell[i] += equilibrium(i, wanted) - equilibrium(i, found);
        }
  }
  [[nodiscard]] GiveMomentum* clone() const override { return new GiveMomentum(*this); }
  void getTypeOfModification(std::vector<plb::modif::ModifT>& modified) const override {
    modified = {plb::modif::staticVariables, plb::modif::nothing};
  }
};

Vector3d velocity_at(const Vector3d& arm, const Motions& motions, Eigen::Index body) {
  return motions.block<3, 1>(7, body) + motions.block<3, 1>(10, body).cross(arm);
}

Vector to_palabos(const Vector3d& vector) { return {vector.x(), vector.y(), vector.z()}; }

}  // namespace

struct PalabosFlow::Lattice {
  Lattice(const FlowSetup& flow, const std::vector<BodyShape>& shapes);
  void place(const Motions& motions);
  void add_images(Vector3d place);
  [[nodiscard]] std::vector<double> gather_forces() const;

  FlowSetup setup;
  Vector3d size, first;  ///< nodes; fluid cell number 0 along each axis: walls are nodes of their own
  Vector3d force;        ///< on the fluid, per volume
  plb::Box3D fluid;
  std::vector<std::vector<Point>> bodies;
  std::unique_ptr<plb::MultiBlockLattice3D<double, D3Q19>> populations;
  std::unique_ptr<plb::MultiScalarField3D<double>> density;
  std::unique_ptr<plb::MultiTensorField3D<double, 3>> momentum, body_force;
  std::unique_ptr<plb::MultiContainerBlock3D> container;
  /// All points in the world; volume and velocity of the body there.
  struct WorldPoint {
    Eigen::Index body;
    double volume;
    Vector3d arm, velocity;
  };
  std::vector<WorldPoint> points;
  // One vertex per point, and one for every periodic image of it that is near the domain.
  std::vector<Vector> vertices;
  std::vector<double> volumes;
  std::vector<std::size_t> point_of_vertex;
};

PalabosFlow::Lattice::Lattice(const FlowSetup& flow, const std::vector<BodyShape>& shapes)
    : setup(flow), force(flow.body_force.data()) {
  for (const BodyShape& shape : shapes) bodies.push_back(fill(shape, depth_of_points((1 / flow.omega - 0.5) / 3)));
  for (int axis = 0; axis < 3; ++axis) {
    first[axis] = 1 - flow.periodic[axis];
    size[axis] = flow.cells[axis] + 2 * first[axis];
  }
  const auto node = [](double number) { return static_cast<plb::plint>(number); };
  const Vector3d last = size - first - Vector3d::Ones();
  fluid = {node(first[0]), node(last[0]), node(first[1]), node(last[1]), node(first[2]), node(last[2])};
  plb::Dynamics<double, D3Q19>* bulk = nullptr;  // Palabos deletes it
  if (flow.two_relaxation_times != 0) {
    bulk = new plb::TRTdynamics<double, D3Q19>(flow.omega);
  } else {
    bulk = new plb::BGKdynamics<double, D3Q19>(flow.omega);
  }
  populations =
      std::make_unique<plb::MultiBlockLattice3D<double, D3Q19>>(node(size[0]), node(size[1]), node(size[2]), bulk);
  populations->toggleInternalStatistics(false);
  density.reset(plb::generateMultiScalarField<double>(*populations, envelope).release());
  momentum.reset(plb::generateMultiTensorField<double, 3>(*populations, envelope).release());
  container = std::make_unique<plb::MultiContainerBlock3D>(*density);
  const plb::Box3D whole = populations->getBoundingBox();
  if (!force.isZero(0)) {
    body_force.reset(plb::generateMultiTensorField<double, 3>(*populations, envelope).release());
    plb::setToConstant<double, 3>(*body_force, whole, to_palabos(force));
  }
  for (int axis = 0; axis < 3; ++axis)
    for (plb::MultiBlock3D* block :
         {static_cast<plb::MultiBlock3D*>(populations.get()), static_cast<plb::MultiBlock3D*>(momentum.get())})
      block->periodicity().toggle(axis, flow.periodic[axis] != 0);
  for (const bool at_rest : {false, true})  // where faces meet, the wall at rest counts
    for (int face = 0; face < 6; ++face) {
      const auto& velocity = flow.wall_velocity[face];
      if (flow.periodic[face / 2] != 0 || Vector3d(velocity.data()).isZero(0) != at_rest) continue;
      plb::Box3D box = whole;
      const std::array<plb::plint*, 6> bounds{&box.x0, &box.x1, &box.y0, &box.y1, &box.z0, &box.z1};
      *bounds[face ^ 1] = *bounds[face];
      plb::defineDynamics(*populations, box, new MovingWall(velocity));
    }
  plb::initializeAtEquilibrium(*populations, whole, 1.0, Vector(0., 0., 0.));
  populations->initialize();
}

/// Places the points of all bodies; Palabos' positions count from the middle of node 0.
void PalabosFlow::Lattice::place(const Motions& motions) {
  points.clear();
  vertices.clear();
  volumes.clear();
  point_of_vertex.clear();
  for (Eigen::Index body = 0; body < motions.cols(); ++body) {
    const auto q = motions.block<4, 1>(3, body);
    const Eigen::Matrix3d rotation = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
    const Vector3d centre = motions.block<3, 1>(0, body) + first - Vector3d::Constant(0.5);
    for (const Point& point : bodies[static_cast<std::size_t>(body)]) {
      const Vector3d place = ((centre + rotation * point.place) * samples_per_cell).array().round() / samples_per_cell;
      points.push_back({body, point.volume, place - centre, velocity_at(place - centre, motions, body)});
      add_images(place);
    }
  }
}

/// Vertices of the newest point: the one inside the domain, and its images that act on it across periodic faces.
void PalabosFlow::Lattice::add_images(Vector3d place) {
  const Vector3d periodic(setup.periodic.data());
  place.array() -= (periodic.array() * ((place.array() + 0.5) / size.array()).floor()) * size.array();
  for (int image = 0; image < 27; ++image) {
    const Vector3d shift(image % 3 - 1, image / 3 % 3 - 1, image / 9 - 1);
    const Vector3d x = place + shift.cwiseProduct(size);
    const bool near = (x.array() > -envelope - 1).all() && (x.array() < size.array() + envelope).all();
    if (shift.cwiseAbs().cwiseProduct(Vector3d::Ones() - periodic).any() || !near) continue;
    vertices.push_back(to_palabos(x));
    volumes.push_back(points.back().volume);
    point_of_vertex.push_back(points.size() - 1);
  }
}

/// Momentum given by every point, (points, 3). A point has one owner, so the sum over ranks only collects.
std::vector<double> PalabosFlow::Lattice::gather_forces() const {
  std::vector<double> given(3 * points.size(), 0.0), all(given.size(), 0.0);
  for (const plb::plint block : container->getLocalInfo().getBlocks()) {
    const plb::SmartBulk3D bulk(container->getMultiBlockManagement(), block);
    const auto* data = dynamic_cast<const plb::ImmersedWallData3D<double>*>(container->getComponent(block).getData());
    for (std::size_t k = 0; k < data->vertices.size(); ++k)
      if (plb::closedOpenContained(data->vertices[k], bulk.toLocal(bulk.getBulk())))
        std::copy_n(&data->g[k][0], 3, &given[3 * point_of_vertex[data->globalVertexIds[k]]]);
  }
  MPI_Reduce(given.data(), all.data(), static_cast<int>(given.size()), MPI_DOUBLE, MPI_SUM, 0, MPI_COMM_WORLD);
  return all;
}

PalabosFlow::PalabosFlow(const FlowSetup& setup, const std::vector<BodyShape>& shapes) {
  plb::global::mpi().init(MPI_COMM_WORLD);
  lattice_ = std::make_unique<Lattice>(setup, shapes);
  previous_ = Motions::Zero(13, static_cast<Eigen::Index>(shapes.size()));
}

PalabosFlow::~PalabosFlow() = default;

BodyLoads PalabosFlow::force_bodies(const Motions& motions) {
  Lattice& now = *lattice_;
  now.place(motions);
  plb::computeRhoBarJ(*now.populations, *now.density, *now.momentum, now.populations->getBoundingBox());
  if (now.body_force) plb::addInPlace(*now.momentum, *now.body_force, now.fluid);
  plb::instantiateImmersedWallData(now.vertices, now.volumes, *now.container);
  const auto velocity = [&now](plb::pluint i) { return to_palabos(now.points[now.point_of_vertex[i]].velocity); };
  for (int k = 0; k < iterations; ++k)
    plb::indexedInamuroIteration(velocity, *now.density, *now.momentum, *now.container, 1.0, true);

  const std::vector<double> given = now.gather_forces();
  BodyLoads loads = BodyLoads::Zero(6, motions.cols());
  for (std::size_t k = 0; k < now.points.size(); ++k) {
    const Lattice::WorldPoint& point = now.points[k];
    const Vector3d gain = point.velocity - velocity_at(point.arm, previous_, point.body) - now.force;
    const Vector3d load = point.volume * gain - Eigen::Map<const Vector3d>(&given[3 * k]);
    loads.block<3, 1>(0, point.body) += load;
    loads.block<3, 1>(3, point.body) += point.arm.cross(load);
  }
  previous_ = motions;
  return loads;
}

void PalabosFlow::advance() {
  plb::applyProcessingFunctional(new GiveMomentum, lattice_->fluid, *lattice_->populations, *lattice_->momentum);
  lattice_->populations->collideAndStream();
}

void PalabosFlow::save(const std::string& file) const { plb::saveBinaryBlock(*lattice_->populations, file); }

void PalabosFlow::restore(const std::string& file, const Motions& previous) {
  plb::loadBinaryBlock(*lattice_->populations, file);
  previous_ = previous;
}

std::uint64_t PalabosFlow::digest() const {
  const auto& populations = *lattice_->populations;
  std::uint64_t sum = 0, total = 0;
  for (const plb::plint block : populations.getLocalInfo().getBlocks()) {
    const plb::SmartBulk3D bulk(populations.getMultiBlockManagement(), block);
    plb::Box3D box;
    if (!plb::intersect(bulk.getBulk(), lattice_->fluid, box)) continue;
    for (plb::plint x = box.x0; x <= box.x1; ++x)
      for (plb::plint y = box.y0; y <= box.y1; ++y)
        for (plb::plint z = box.z0; z <= box.z1; ++z) {
          copepod::Digest digest;
          for (const plb::plint index : {x, y, z}) digest.add(static_cast<std::uint64_t>(index));
          const auto& component = populations.getComponent(block);
          const auto& cell = component.get(bulk.toLocalX(x), bulk.toLocalY(y), bulk.toLocalZ(z));
          for (int i = 0; i < D3Q19<double>::q; ++i) digest.add(cell[i]);
          sum += digest.value();
        }
  }
  MPI_Allreduce(&sum, &total, 1, MPI_UINT64_T, MPI_SUM, MPI_COMM_WORLD);
  copepod::Digest digest(total);
  for (const double number : previous_.reshaped()) digest.add(number);
  return digest.value();
}
