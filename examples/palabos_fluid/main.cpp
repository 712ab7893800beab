// Palabos as a fluid of Copepod: every rank holds its part of the lattice, and rank 0 serves the coupler.
//   deploy/copepod run CASE.yaml --fluid /tmp/palabos_fluid/palabos_fluid --ranks 2
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <span>
#include <unistd.h>

#include <Eigen/Geometry>

#include "contract/digest.hpp"
#include "contract/errors.hpp"
#include "forcing_points.hpp"
#include "lattice.hpp"
#include "ranks/fluid_program.hpp"
#include "system/durable_file.hpp"

namespace {

using namespace copepod;
using Eigen::Vector3d;

constexpr int iterations = 4;             ///< of the multi-direct forcing
constexpr int envelope = 3;               ///< cells that the kernel of a point beside a block reaches
constexpr double samples_per_cell = 250;  ///< of Palabos' tabulated kernel; points lie on them, so that it is exact

/// One column per body: position, orientation (w, x, y, z), velocity, angular velocity.
using Motions = Eigen::Matrix<double, 13, Eigen::Dynamic>;

std::span<double> numbers_of(Motions& motions) { return {motions.data(), static_cast<std::size_t>(motions.size())}; }

Vector3d velocity_at(const Vector3d& arm, const Motions& motions, Eigen::Index body) {
  return motions.block<3, 1>(7, body) + motions.block<3, 1>(10, body).cross(arm);
}

/// Of the files of a checkpoint.
std::uint64_t digest_of_files(const std::string& folder) {
  std::string content;
  for (const char* name : {"/populations", "/motions"}) {
    std::ifstream file(folder + name, std::ios::binary);
    content.append(std::istreambuf_iterator<char>(file), {});
  }
  return digest_of(content);
}

/// One rank's part of Palabos' D3Q19 lattice with rigid bodies by its immersed boundary (multi-direct forcing). All
/// calls are collective. Inside, everything is in lattice units, in which the density of the fluid is 1.
///
/// Forcing points fill each body. A step moves the momentum at point k, of volume w_k, to that of the body:
///   g_k = w_k (v_k − j(x_k)),   v_k = U + Ω × r_k,   repeated until the points agree with each other.
/// The fluid inside a body thus moves with it, and what that takes does not belong to the load on the body:
///   load = Σ_k w_k (v_k − v_k' − f) − g_k,   v' of the step before, f the body force per volume.
class PalabosFluid final : public FluidSolver {
 public:
  PalabosFluid(const FluidSetup& setup, fluid::Communicator& ranks)
      : setup_(setup),
        ranks_(ranks),
        speed_m_per_s_(setup.cell_size_m / setup.step_s),
        force_(setup.step_s / speed_m_per_s_ / setup.density_kg_per_m3 * setup.body_force_N_per_m3),
        previous_(Motions::Zero(13, static_cast<Eigen::Index>(setup.bodies.size()))) {
    int has_mpi = 0;
    MPI_Initialized(&has_mpi);  // by the kit, unless this process is the only one
    if (has_mpi == 0) MPI_Init(nullptr, nullptr);
    plb::global::mpi().init(MPI_COMM_WORLD);
    const double viscosity = setup.kinematic_viscosity_m2_per_s / (speed_m_per_s_ * setup.cell_size_m);
    const double omega = 1 / (3 * viscosity + 0.5);
    for (const Shape& shape : setup.bodies)
      bodies_.push_back(fill(shape.radius_m / setup.cell_size_m, core_half_length_m(shape) / setup.cell_size_m,
                             depth_of_points((1 / omega - 0.5) / 3)));
    for (int axis = 0; axis < 3; ++axis) {
      periodic_[axis] = setup.boundaries[2 * axis].kind == BoundaryKind::periodic ? 1 : 0;
      first_[axis] = 1 - periodic_[axis];
      size_[axis] = static_cast<double>(setup.domain_cells[axis]) + 2 * first_[axis];
    }
    make_lattice(omega);
  }

  void exchange(const Kinematics& kinematics, Loads& loads) override {
    const Motions motions = share(kinematics);
    place(motions);
    plb::computeRhoBarJ(*populations_, *density_, *momentum_, populations_->getBoundingBox());
    if (body_force_) plb::addInPlace(*momentum_, *body_force_, cells_);
    plb::instantiateImmersedWallData(vertices_, volumes_, *container_);
    const auto velocity = [this](plb::pluint i) { return to_palabos(points_[i].velocity); };
    for (int k = 0; k < iterations; ++k)
      plb::indexedInamuroIteration(velocity, *density_, *momentum_, *container_, 1.0, true);

    const std::vector<double> given = gather_forces();
    Eigen::Matrix<double, 6, Eigen::Dynamic> sum = Eigen::MatrixXd::Zero(6, motions.cols());
    for (std::size_t k = 0; k < points_.size(); ++k) {
      const WorldPoint& point = points_[k];
      if (!point.counts) continue;
      const Vector3d gain = point.velocity - velocity_at(point.arm, previous_, point.body) - force_;
      const Vector3d load = point.volume * gain - Eigen::Map<const Vector3d>(&given[3 * k]);
      sum.block<3, 1>(0, point.body) += load;
      sum.block<3, 1>(3, point.body) += point.arm.cross(load);
    }
    if (!sum.allFinite())
      throw SolverError("the flow diverged (a load is not finite). Use a smaller step or slower bodies.", 0,
                        kinematics.step);
    previous_ = motions;
    const double force_N = setup_.density_kg_per_m3 * std::pow(speed_m_per_s_ * setup_.cell_size_m, 2);
    loads.step = kinematics.step;
    loads.force_N = force_N * sum.topRows<3>();
    loads.torque_N_m = force_N * setup_.cell_size_m * sum.bottomRows<3>();
  }

  void advance() override {
    plb::applyProcessingFunctional(new GiveMomentum, cells_, *populations_, *momentum_);
    populations_->collideAndStream();
    ++steps_;
  }

  /// Palabos' own file of the populations, the last motions, and the step with a digest of both.
  void save(const std::string& path) override {
    std::error_code problem;
    std::filesystem::create_directory(path, problem);  // by whichever rank comes first
    if (problem) throw StorageError("The folder " + path + " cannot be made. Choose another path.");
    plb::saveBinaryBlock(*populations_, path + "/populations");
    if (ranks_.rank() != 0) return;
    sync_to_disk(path + "/populations");
    write_durably(path + "/motions", std::as_bytes(numbers_of(previous_)));
    write_durably(path + "/state", std::to_string(steps_) + " " + std::to_string(digest_of_files(path)));
  }

  void restore(const std::string& path) override {
    std::uint64_t digest = 0;
    std::ifstream(path + "/state") >> steps_ >> digest;
    std::ifstream motions(path + "/motions", std::ios::binary);
    motions.read(reinterpret_cast<char*>(previous_.data()), 8 * previous_.size());
    if (!motions || digest != digest_of_files(path))
      throw StorageError("The folder " + path + " cannot be read (missing or damaged). Choose another one.");
    plb::loadBinaryBlock(*populations_, path + "/populations");
  }

  SolverSummary summarise() override {
    std::int64_t sum = digest_of_cells();
    ranks_.sum_to_all({&sum, 1});
    Digest digest(static_cast<std::uint64_t>(sum));
    digest.add_all(previous_);
    std::uint64_t updates = steps_;
    for (const std::int64_t cells : setup_.domain_cells) updates *= static_cast<std::uint64_t>(cells);
    return {digest.value(), updates, ranks_.size(), {}};
  }

 private:
  /// A forcing point in the world with the velocity of its body there, or an image of it beyond a periodic face.
  struct WorldPoint {
    Eigen::Index body;
    double volume;
    Vector3d arm, velocity;
    bool counts;  ///< it is inside the domain
  };

  void make_lattice(double omega) {
    const Vector3d last = size_ - Vector3d::Ones();
    const plb::Box3D whole = box_of(Vector3d::Zero(), last);
    cells_ = box_of(first_, last - first_);
    plb::Dynamics<double, D3Q19>* bulk = new plb::BGKdynamics<double, D3Q19>(omega);  // Palabos deletes it
    if (setup_.collision == CollisionKind::trt) bulk = new plb::TRTdynamics<double, D3Q19>(omega);
    populations_ = std::make_unique<Lattice>(whole.getNx(), whole.getNy(), whole.getNz(), bulk);
    populations_->toggleInternalStatistics(false);
    density_.reset(plb::generateMultiScalarField<double>(*populations_, envelope).release());
    momentum_.reset(plb::generateMultiTensorField<double, 3>(*populations_, envelope).release());
    container_ = std::make_unique<plb::MultiContainerBlock3D>(*density_);
    if (!force_.isZero(0)) {
      body_force_.reset(plb::generateMultiTensorField<double, 3>(*populations_, envelope).release());
      plb::setToConstant<double, 3>(*body_force_, whole, to_palabos(force_));
    }
    for (int axis = 0; axis < 3; ++axis) {
      populations_->periodicity().toggle(axis, periodic_[axis] != 0);
      momentum_->periodicity().toggle(axis, periodic_[axis] != 0);
    }
    for (const bool at_rest : {false, true})  // where faces meet, the wall at rest counts
      for (int face = 0; face < 6; ++face) {
        const Vector3d velocity = 1 / speed_m_per_s_ * setup_.boundaries[face].velocity_m_per_s;
        if (periodic_[face / 2] != 0 || velocity.isZero(0) != at_rest) continue;
        Vector3d low = Vector3d::Zero(), high = last;
        (face % 2 == 0 ? high : low)[face / 2] = face % 2 == 0 ? 0 : last[face / 2];
        plb::defineDynamics(*populations_, box_of(low, high), new MovingWall(velocity));
      }
    plb::initializeAtEquilibrium(*populations_, whole, 1.0, Vector(0., 0., 0.));
    populations_->initialize();
  }

  /// The motions that rank 0 received.
  /// @throws SolverError if a body is too fast, or beyond a face that is not periodic
  Motions share(const Kinematics& kinematics) {
    Motions motions(13, previous_.cols());
    if (ranks_.rank() == 0) {
      motions.topRows<3>() = kinematics.position_m / setup_.cell_size_m;
      motions.middleRows<4>(3) = kinematics.orientation_wxyz;
      motions.middleRows<3>(7) = kinematics.velocity_m_per_s / speed_m_per_s_;
      motions.bottomRows<3>() = kinematics.angular_velocity_rad_per_s * setup_.step_s;
    }
    ranks_.broadcast(std::as_writable_bytes(numbers_of(motions)));
    for (const auto& motion : motions.colwise()) {
      bool fine = motion.segment<3>(7).norm() < largest_speed_lu;
      for (int axis = 0; axis < 3; ++axis)
        fine = fine && (periodic_[axis] != 0 || (motion[axis] > 0 && motion[axis] < size_[axis] - 2));
      if (!fine)
        throw SolverError("a body left the domain or is too fast (above 0.4 cells per step). Use a smaller step.", 0,
                          kinematics.step);
    }
    return motions;
  }

  /// Places the points of all bodies; Palabos' positions count from the middle of node 0.
  void place(const Motions& motions) {
    points_.clear();
    vertices_.clear();
    volumes_.clear();
    for (Eigen::Index body = 0; body < motions.cols(); ++body) {
      const auto q = motions.block<4, 1>(3, body);
      const Eigen::Matrix3d rotation = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
      const Vector3d centre = motions.block<3, 1>(0, body) + first_ - Vector3d::Constant(0.5);
      for (const Point& point : bodies_[static_cast<std::size_t>(body)]) {
        const Vector3d exact = centre + rotation * point.place;
        const Vector3d place = (exact * samples_per_cell).array().round() / samples_per_cell;
        add_images({body, point.volume, place - centre, velocity_at(place - centre, motions, body), false}, place);
      }
    }
  }

  /// Adds a point inside the domain, and its images that act on it across periodic faces.
  void add_images(WorldPoint point, Vector3d place) {
    place.array() -= (periodic_.array() * ((place.array() + 0.5) / size_.array()).floor()) * size_.array();
    for (int image = 0; image < 27; ++image) {
      const Vector3d shift(image % 3 - 1, image / 3 % 3 - 1, image / 9 - 1);
      const Vector3d x = place + shift.cwiseProduct(size_);
      const bool near = (x.array() > -envelope - 1).all() && (x.array() < size_.array() + envelope).all();
      if (shift.cwiseAbs().cwiseProduct(Vector3d::Ones() - periodic_).any() || !near) continue;
      vertices_.push_back(to_palabos(x));
      volumes_.push_back(point.volume);
      point.counts = shift.isZero(0);
      points_.push_back(point);
    }
  }

  /// Momentum given by every point, (points, 3). A point has one owner, so the sum over ranks only collects.
  [[nodiscard]] std::vector<double> gather_forces() const {
    std::vector<double> given(3 * points_.size(), 0.0);
    for (const plb::plint block : container_->getLocalInfo().getBlocks()) {
      const plb::SmartBulk3D bulk(container_->getMultiBlockManagement(), block);
      const auto* data = dynamic_cast<plb::ImmersedWallData3D<double>*>(container_->getComponent(block).getData());
      for (std::size_t k = 0; k < data->vertices.size(); ++k)
        if (plb::closedOpenContained(data->vertices[k], bulk.toLocal(bulk.getBulk())))
          std::copy_n(&data->g[k][0], 3, &given[3 * data->globalVertexIds[k]]);
    }
    plb::global::mpi().allReduceVect(given, MPI_SUM);
    return given;
  }

  /// Sum over the cells of this rank, modulo 2^64: it does not depend on the number of ranks.
  [[nodiscard]] std::int64_t digest_of_cells() const {
    std::uint64_t sum = 0;
    for (const plb::plint block : populations_->getLocalInfo().getBlocks()) {
      const plb::SmartBulk3D bulk(populations_->getMultiBlockManagement(), block);
      plb::Box3D box;
      if (!plb::intersect(bulk.getBulk(), cells_, box)) continue;
      for (plb::plint x = box.x0; x <= box.x1; ++x)
        for (plb::plint y = box.y0; y <= box.y1; ++y)
          for (plb::plint z = box.z0; z <= box.z1; ++z) {
            Digest digest;
            for (const plb::plint index : {x, y, z}) digest.add(static_cast<std::uint64_t>(index));
            const auto& component = populations_->getComponent(block);
            const auto& cell = component.get(bulk.toLocalX(x), bulk.toLocalY(y), bulk.toLocalZ(z));
            for (int i = 0; i < D3Q19<double>::q; ++i) digest.add(cell[i]);
            sum += digest.value();
          }
    }
    return static_cast<std::int64_t>(sum);
  }

  FluidSetup setup_;
  fluid::Communicator& ranks_;
  double speed_m_per_s_;  ///< of one cell per step
  Vector3d force_;        ///< on the fluid, per volume
  // Along each axis: nodes; 1 if it is periodic, else 0; the node of the first cell, as walls are nodes of their own.
  Vector3d size_, periodic_, first_;
  plb::Box3D cells_;
  std::vector<std::vector<Point>> bodies_;
  std::unique_ptr<Lattice> populations_;
  std::unique_ptr<plb::MultiScalarField3D<double>> density_;
  std::unique_ptr<plb::MultiTensorField3D<double, 3>> momentum_, body_force_;
  std::unique_ptr<plb::MultiContainerBlock3D> container_;
  std::vector<WorldPoint> points_;
  std::vector<Vector> vertices_;  ///< their places
  std::vector<double> volumes_;
  Motions previous_;  ///< of the last step
  std::uint64_t steps_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  const Capabilities capabilities{
      "Palabos",
      "1.5",
      {"solver:external", "collision:bgk", "collision:trt", "precision:double", "boundary:no_slip", "boundary:periodic",
       "boundary:velocity", "body_force", "shape:sphere", "shape:capsule", "checkpoint", "mpi"}};
  return fluid::run_fluid_program(
      argc, argv, {capabilities, {}},
      [](const FluidSetup& setup, fluid::Communicator& ranks) { return std::make_unique<PalabosFluid>(setup, ranks); });
}
