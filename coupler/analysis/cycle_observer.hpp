#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "config/sections/case.hpp"
#include "config/sections/sections.hpp"
#include "contract/body_setup.hpp"
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

/// The swimmers of a case, then its groups, as the analysis sees them. Arms are the springs between their bodies.
///
/// The period is that of all periodic signals on a swimmer's bodies. If they differ, it is, with a note, their least
/// common multiple, or the longest of them where that is more than ten times as long. Cycles count that lie between the
/// first start of these signals and the first stop.
std::vector<Group> groups_of(const Case& the_case, const Assembly& assembly);

/// Whether any has a period.
bool have_cycles(const std::vector<Group>& groups);

constexpr Eigen::Index most_latest_cycles = 5;  ///< of which summaries have mean and spread

/// Sums over the cycle that is being measured, and the last two measured; everything needed to continue bit for bit.
struct CycleSums {
  std::int64_t number = -1;                              ///< of the cycle being measured; −1: none
  std::int64_t samples = 0;                              ///< steps of it so far
  Eigen::Matrix3d turned = Eigen::Matrix3d::Identity();  ///< from the case's placement to its start
  Eigen::Matrix3Xd first_position_m;                     ///< of the bodies at its start
  Eigen::VectorXd first_arm_m;
  Eigen::VectorXd arm_m;         ///< Σ (l − l at start); small numbers sum up with less rounding
  Eigen::VectorXd arm_cosine_m;  ///< Σ (l − l at start) cos ωt
  Eigen::VectorXd arm_sine_m;
  double power_W = 0.0;        ///< Σ F_dri · v
  double dissipation_W = 0.0;  ///< −Σ (F · v + T · ω), loads of the fluid
  std::optional<double> power_as_in_paper_W;
  Eigen::VectorXd max_speed_m_per_s;
  Eigen::VectorXd max_speed_along_m_per_s;
  Cycle last, before_last;
  Eigen::VectorXd latest_along_m;  ///< way along the own axis in up to most_latest_cycles, without the very first
};

/// Measures every swimmer over each full cycle of its drive, from every step, storing none
/// [docs/theory.md, (C7), (C8), (C13)–(C15)].
class CycleObserver final : public Observer {
 public:
  explicit CycleObserver(std::vector<Group> groups) : groups_(std::move(groups)), sums_(groups_.size()) {}

  /// @param table  receives every cycle that ends, and must outlive this object; null: none does
  void write_to(CycleTable* table) { table_ = table; }

  void observe(const StepRecord& record) override;
  void finish(const StepRecord& last) override;

  /// Whether the motion of every swimmer in its last full cycle is that of the one before, up to `tolerance` of it.
  [[nodiscard]] bool is_periodic(double tolerance) const;
  [[nodiscard]] const std::vector<Group>& groups() const { return groups_; }
  [[nodiscard]] const std::vector<CycleSums>& sums() const { return sums_; }
  /// Of all bodies when the run ends, shape (3, bodies).
  [[nodiscard]] const Eigen::Matrix3Xd& end_position_m() const { return end_position_m_; }
  /// @param step        that comes next
  /// @param first_step  of the run; a cycle that began before it is not measured
  /// @throws StorageError if the sums are not of these swimmers before that step
  void restore(const std::vector<CycleSums>& sums, std::int64_t step, std::int64_t first_step);

 private:
  void open(const Group& group, CycleSums& sums, const StepRecord& record);
  void sample(const Group& group, CycleSums& sums, const StepRecord& record);
  void close(const Group& group, CycleSums& sums, const StepRecord& record);
  void set_phase(std::int64_t within, std::int64_t period_steps);

  std::vector<Group> groups_;
  std::vector<CycleSums> sums_;
  Eigen::Matrix3Xd end_position_m_;
  CycleTable* table_ = nullptr;
  std::int64_t phase_within_ = -1, phase_period_ = 0;  ///< of which cosine and sine are; most swimmers share them
  double cosine_ = 1.0, sine_ = 0.0;
};

}  // namespace copepod::coupler
