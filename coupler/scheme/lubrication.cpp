#include "scheme/lubrication.hpp"

#include <algorithm>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "geometry/rotation.hpp"

namespace copepod::coupler {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Velocity at a point x from that of a body: V + Ω × x, Ω.
Matrix6 moved_to(const Eigen::Vector3d& x) {
  Matrix6 matrix = Matrix6::Identity();
  matrix.topRightCorner<3, 3>() << 0, x[2], -x[1], -x[2], 0, x[0], x[1], -x[0], 0;
  return matrix;
}

/// Motion of a mirror image: velocities change sign along the mirrored axes, angular velocities along the others.
Matrix6 mirroring(const std::array<bool, 3>& mirrored) {
  Eigen::Vector3d sign(1, 1, 1);
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    if (mirrored[axis]) sign[axis] = -1.0;
  Matrix6 matrix = Matrix6::Zero();
  matrix.diagonal() << sign, sign.prod() * sign;
  return matrix;
}

/// Whether a film is counted elsewhere: by the other body, or, of a body with its own image, with the opposite image.
bool is_done(int body, const NearSurface& surface) {
  if (!surface.is_body() || surface.is_mirrored()) return false;
  if (surface.other != body) return surface.other < body;
  for (const double length_m : surface.core.centre_W_m)
    if (length_m != 0.0) return length_m < 0.0;
  return false;
}

}  // namespace

Lubrication::Lubrication(const FluidSetup& fluid, const BodySetup& bodies, double roughness_m)
    : fluid_(fluid), bodies_(bodies), limits_{roughness_m, bodies.contact.stiffness_N_per_m > 0.0} {
  if (!(fluid.film_thickness_m > 0.0)) return;
  surfaces_.emplace(fluid, FilmRange(fluid).high_m);
  response_.resize(bodies.bodies.size());
  motion_.resize(bodies.bodies.size());
  loads_.resize(bodies.bodies.size());
}

const Loads* Lubrication::loads(const Kinematics& kinematics, const Loads& applied, const Loads& drive) {
  if (!surfaces_) return nullptr;
  moved_ = kinematics;
  find_films();
  if (films_.empty()) return nullptr;
  loads_.step = kinematics.step;
  loads_.force_N.setZero();
  loads_.torque_N_m.setZero();
  double left_s = fluid_.step_s;
  while (true) {
    const double part_s = duration_s(left_s);
    predict(part_s, applied, drive);
    solve();
    add_up(part_s / fluid_.step_s);
    left_s -= part_s;
    if (left_s == 0.0) return &loads_;
    move(part_s);
    find_films();
    if (films_.empty()) return &loads_;
  }
}

/// Motion of the two surfaces, about the centre of the first body.
Lubrication::Vector6 Lubrication::Film::relative(const std::vector<Vector6>& motion) const {
  const Vector6 own = motion[body] - wall;
  return other < 0 ? own : Vector6(own - to_other * motion[other]);
}

/// M⁻¹; zero for a body that no load moves.
Lubrication::Matrix6 Lubrication::inverse_inertia(Eigen::Index body, const Kinematics& kinematics) const {
  const BodySpecification& specification = bodies_.bodies[body];
  Matrix6 result = Matrix6::Zero();
  if (specification.motion != MotionKind::free && specification.motion != MotionKind::axis) return result;
  const Eigen::Matrix3d inertia_kg_m2 = inertia_tensor_kg_m2(specification);
  const Eigen::Matrix3d R_WB = rotation_matrix(kinematics.orientation_wxyz.col(body));
  const Eigen::Matrix3d along = R_WB.col(2) * R_WB.col(2).transpose();
  result.topLeftCorner<3, 3>().diagonal().setConstant(1.0 / specification.mass_kg);
  if (specification.inertia_kg_m2.empty())
    result.bottomRightCorner<3, 3>() =
        along / inertia_kg_m2(2, 2) + (Eigen::Matrix3d::Identity() - along) / inertia_kg_m2(0, 0);
  else
    result.bottomRightCorner<3, 3>() = R_WB * inertia_kg_m2.ldlt().solve(R_WB.transpose());
  if (specification.motion == MotionKind::axis) {
    const Eigen::Matrix3d projection = specification.axis * specification.axis.transpose();
    for (const int block : {0, 3})
      result.block<3, 3>(block, block) = projection * result.block<3, 3>(block, block) * projection;
  }
  return result;
}

void Lubrication::find_films() {
  const FilmRange range(fluid_);
  const double viscosity_Pa_s = fluid_.density_kg_per_m3 * fluid_.kinematic_viscosity_m2_per_s;
  films_.clear();
  fastest_per_s_ = 0.0;
  for (Eigen::Index body = 0; body < std::ssize(motion_); ++body)
    motion_[body] << moved_.velocity_m_per_s.col(body), moved_.angular_velocity_rad_per_s.col(body);
  surfaces_->find(moved_);
  for (std::size_t body = 0; body < motion_.size(); ++body) {
    NearSurface own = surfaces_->surface_of(body);
    own.core.centre_W_m.setZero();
    for (const NearSurface& surface : surfaces_->of_body(body)) {
      if (is_done(static_cast<int>(body), surface)) continue;
      find_film(own, surface, range, viscosity_Pa_s, limits_, contacts_);
      if (!contacts_.empty()) add_film(static_cast<int>(body), surface);
    }
  }
}

void Lubrication::add_film(int body, const NearSurface& surface) {
  Film& film = films_.emplace_back();
  film.body = body;
  film.other = surface.other;
  film.image = surface.is_mirrored();
  for (const FilmContact& contact : contacts_) film.resistance += contact.resistance();
  if (surface.is_body()) {
    film.to_other = moved_to(-surface.core.centre_W_m) * mirroring(surface.mirrored);
  } else {
    const Boundary& wall = fluid_.boundaries[surface.face];
    if (wall.kind == BoundaryKind::velocity) film.wall.head<3>() = wall.velocity_in(moved_.step);
  }
  const Vector6 relative = film.relative(motion_);
  for (const FilmContact& contact : contacts_) {
    const double thickness_m = std::max(std::abs(contact.gap_m), limits_.roughness_m);
    fastest_per_s_ = std::max(fastest_per_s_, std::abs(contact.normal_velocity(relative)) / thickness_m);
  }
}

/// Of the next part of the step, in which no film gets thinner or thicker by more than a tenth.
double Lubrication::duration_s(double left_s) const {
  constexpr double most_change = 0.1;
  constexpr double shortest = 1e-5;  // of the step
  const double duration_s = std::max(most_change / fastest_per_s_, shortest * fluid_.step_s);
  return std::min(duration_s, left_s);
}

/// Of bodies beside films: how they respond to a load, and their motion after that time without films.
void Lubrication::predict(double duration_s, const Loads& applied, const Loads& drive) {
  const auto predict_body = [&](int body) {
    const BodySpecification& specification = bodies_.bodies[body];
    const double displaced_kg = bodies_.fluid_density_kg_per_m3 * volume_m3(specification.shape);
    Vector6 load;
    load << applied.force_N.col(body) + drive.force_N.col(body) +
                (specification.mass_kg - displaced_kg) * bodies_.gravity_m_per_s2,
        applied.torque_N_m.col(body) + drive.torque_N_m.col(body);
    response_[body] = duration_s * inverse_inertia(body, moved_);
    motion_[body] << moved_.velocity_m_per_s.col(body), moved_.angular_velocity_rad_per_s.col(body);
    motion_[body] += response_[body] * load;
  };
  for (Film& film : films_) {
    predict_body(film.body);
    film.response = response_[film.body];
    if (film.other >= 0) {
      predict_body(film.other);
      const Matrix6& other = response_[film.other];
      const bool itself = film.other == film.body;
      if (itself) film.response -= film.to_other * other;
      if (!film.image)
        film.response += (film.to_other * other - (itself ? other : Matrix6::Zero())) * film.to_other.transpose();
    }
    film.answer = (Matrix6::Identity() + film.resistance * film.response).partialPivLu().solve(film.resistance);
  }
}

void Lubrication::solve() {
  constexpr int most_sweeps = 1000;
  constexpr double tolerance = 1e-10;
  bool changes = true;
  for (int sweep = 0; changes && sweep < most_sweeps; ++sweep) {
    changes = false;
    for (Film& film : films_) {
      Vector6& motion = motion_[film.body];
      const Vector6 load = -film.answer * (film.relative(motion_) - film.response * film.load);
      const Vector6 change = load - film.load;
      changes = changes || change.norm() > tolerance * load.norm();
      film.load = load;
      motion += response_[film.body] * change;
      if (film.other >= 0 && !film.image)
        motion_[film.other] -= response_[film.other] * film.to_other.transpose() * change;
    }
  }
}

/// @param share  of the step
void Lubrication::add_up(double share) {
  const auto add = [&](int body, const Vector6& load) {
    loads_.force_N.col(body) += share * load.head<3>();
    loads_.torque_N_m.col(body) += share * load.tail<3>();
  };
  for (const Film& film : films_) {
    add(film.body, film.load);
    if (film.other >= 0 && !film.image) add(film.other, -film.to_other.transpose() * film.load);
  }
}

/// All bodies with their motion at the end of a part of the step.
void Lubrication::move(double duration_s) {
  for (Eigen::Index body = 0; body < std::ssize(motion_); ++body) {
    const Eigen::Vector3d velocity = motion_[body].head<3>(), angular_velocity = motion_[body].tail<3>();
    moved_.velocity_m_per_s.col(body) = velocity;
    moved_.angular_velocity_rad_per_s.col(body) = angular_velocity;
    moved_.position_m.col(body) += duration_s * velocity;
    moved_.orientation_wxyz.col(body) = rotated(duration_s * angular_velocity, moved_.orientation_wxyz.col(body));
  }
}

}  // namespace copepod::coupler
