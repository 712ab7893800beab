#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "config/sections/case.hpp"
#include "observers/observer.hpp"
#include "storage/table_file.hpp"

namespace copepod::coupler {

/// A rigid motion of a group of points: p → c + t + R (p − c), c the centroid.
struct RigidMotion {
  Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();  ///< t, of the centroid
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();   ///< R, proper
};

/// The rigid motion that takes points as close as possible, in the sense of least squares, to where they are later
/// (Kabsch, Acta Cryst. A 32, 922 (1976); docs/theory.md, (C13)).
///   H = Σ (p − c)(p' − c')ᵀ = U S Vᵀ,   R = V diag(1, 1, det(V Uᵀ)) Uᵀ
/// For points on a line the rotation about that line is undetermined, and the shortest rotation that turns the line is
/// returned; the same holds where the points leave their line by less than a thousandth of its length, before or after.
/// A single point does not rotate.
/// @param before, after  shape (3, points), at least one point, equal weights
RigidMotion fit_rigid_motion(const Eigen::Matrix3Xd& before, const Eigen::Matrix3Xd& after);

/// Axis times angle of a rotation, the angle in [0, π] [rad].
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& rotation);

/// What the analysis requires of a swimmer: its bodies as columns of the kinematics, and which cycles to measure.
/// Cycle k takes steps [k T, (k + 1) T), counted from the start of the run, so that cycles of several swimmers are
/// simultaneous and the phase within a cycle is that of time itself.
struct Group {
  std::string name;
  std::vector<int> bodies;
  std::vector<std::string> body_names;
  std::vector<std::array<int, 2>> arms;             ///< columns of the bodies at both ends
  Eigen::Matrix3Xd placed_m;                        ///< where the case places the bodies, shape (3, bodies)
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< own axis there, a unit vector in the world
  double length_m = 0.0;                            ///< greatest extent there, from surface to surface
  std::vector<double> radii_m;                      ///< equivalent radii of the bodies
  std::int64_t period_steps = 0;                    ///< T; 0: no periodic drive, nothing to measure
  std::int64_t first_cycle = 0;                     ///< the first that is driven from its start
  std::int64_t stop_cycle = 0;                      ///< after the last that is driven to its end
  std::string note;                                 ///< remark on the period, for readers of the figures
  /// Power of the forces of the paper's tables; empty where nothing published is compared with.
  std::function<double(const StepRecord& record, const Eigen::Vector3d& axis)> power_as_in_paper_W;
};

/// What was measured of a swimmer in one full cycle; SI units, world frame.
struct Cycle {
  std::int64_t number = -1;                                 ///< −1: none
  Eigen::Vector3d centroid_m = Eigen::Vector3d::Zero();     ///< at the start
  Eigen::Matrix3d turned = Eigen::Matrix3d::Identity();     ///< rotation from the case's placement to the start
  Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();  ///< of the centroid, from start to end
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();   ///< from start to end
  Eigen::Matrix3Xd displacement_m;                          ///< of every body
  Eigen::Matrix3Xd arms;       ///< l̄ [m], d [m], φ [rad] of l(t) = l̄ + d cos(ωt + φ), a column per arm
  double power_W = 0.0;        ///< mean power of the drive
  double dissipation_W = 0.0;  ///< mean power given to the fluid
  std::optional<double> power_as_in_paper_W;
  Eigen::VectorXd max_speed_m_per_s;        ///< of every body
  Eigen::VectorXd max_speed_along_m_per_s;  ///< the same, along the own axis at the start
};

/// What follows from a cycle; absent in vacuum: efficiency and Reynolds number.
struct CycleFigures {
  Eigen::Vector3d axis;                ///< own axis at the start
  Eigen::Vector3d velocity_m_per_s;    ///< mean velocity of the centroid
  double along_m_per_s = 0.0;          ///< its component along the own axis at the start
  Eigen::Vector3d across_m_per_s;      ///< what remains of it
  Eigen::Vector3d rotation_rad;        ///< rotation vector from start to end
  double tilt_rad = 0.0;               ///< angle between the own axis at the start and in the case
  std::optional<double> u_GA_m_per_s;  ///< (C9) of docs/theory.md; absent but for three bodies in a row with two arms
  std::optional<double> efficiency;    ///< 6π η r u² / P, r the sum of the radii, u the mean speed of the centroid
  std::optional<double> Re;            ///< u l / ν
};

CycleFigures evaluate(const Cycle& cycle, const Group& group, const FluidCase& fluid, double step_s);

/// Motion in a cycle below which a swimmer rests and changes from cycle to cycle are noise: of its centroid in its own
/// lengths, and its rotation [rad].
constexpr double rest_in_a_cycle = 1e-9;

/// Relative changes from one cycle to the next, in the swimmer's own frame at the start of each:
///   |Rᵀu − R'ᵀu'| / |u|, likewise of the rotation vector; absent if it rests in the later one.
struct CycleChange {
  std::optional<double> velocity;
  std::optional<double> rotation;
};
CycleChange change(const Cycle& before, const Cycle& after, double length_m);

/// The larger of the changes of translation (in lengths) and rotation, over the larger of both: what does not move is
/// periodic, and so is the rounding of a swimmer's turn beside its way. 0 at rest.
double change_of_motion(const Cycle& before, const Cycle& after, double length_m);

/// Writes cycles.csv: one row per swimmer and full cycle, in the order in which cycles end.
///
/// Columns: swimmer, cycle, its first step and time; centroid and own axis at its start, angle of that axis to the one
/// in the case; mean velocity along and across that axis and in the world; rotation vector from start to end; mean
/// power of the drive and mean power given to the fluid; efficiency and Reynolds number (empty in vacuum); mean,
/// amplitude and phase of each arm, counted from 0 (empty beyond a swimmer's last).
class CycleTable {
 public:
  /// @param end  where to continue the table of a run that was interrupted; absent: starts a new one
  /// @throws StorageError if the file cannot be written
  CycleTable(const std::string& path, const std::vector<Group>& groups, const FluidCase& fluid, double step_s,
             const std::optional<TableEnd>& end);

  void add(const Group& group, const Cycle& cycle);
  TableEnd sync() { return file_.sync(); }

 private:
  const FluidCase& fluid_;
  double step_s_;
  std::int64_t most_arms_;
  CsvFile file_;
};

}  // namespace copepod::coupler
