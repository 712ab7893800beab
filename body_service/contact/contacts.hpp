#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "contact/contact_law.hpp"
#include "contract/body_setup.hpp"
#include "geometry/near_pairs.hpp"
#include "geometry/shapes/overlaps.hpp"
#include "joints/joints.hpp"
#include "model/body_model.hpp"
#include "model/motion_state.hpp"
#include "threads/thread_team.hpp"

namespace copepod::body {

/// What a contact carries from one push to the next.
struct ContactMemory {
  int body = 0;
  int other = 0;            ///< another body; beyond the last one: number of bodies + 2 · wall + end of a capsule
  std::uint32_t image = 0;  ///< of the other body through periodic faces
  Eigen::Vector3d stretch_m{0, 0, 0};     ///< of the tangential spring, world frame
  Eigen::Vector3d slip_m_per_s{0, 0, 0};  ///< of the surfaces after the push; of no use at the start of a step
};

/// Soft contacts of spheres and capsules with each other and with walls; docs/theory_bodies.md has the equations.
///
/// Two bodies have one contact with each image, at the nearest points of their cores; a capsule and a wall have one at
/// each end.
/// Everything is summed in the order of the bodies' names, so that no bit depends on their order in the setup.
class Contacts {
 public:
  /// @param model, joints, near_pairs  must outlive this object; pairs as far apart as `reach_m` must be listed
  /// @throws CaseError if the setup's contacts or walls are not valid
  Contacts(const BodySetup& setup, const BodyModel& model, const Joints& joints, NearPairs& near_pairs);

  /// How far from each other surfaces may be for contacts that begin within a substep [m].
  static double reach_m(const BodySetup& setup);

  /// A time over which contacts push at once.
  struct Interval {
    double duration_s = 0.0;
    double after_s = 0.0;  ///< from the state to the middle of the interval
    double since_s = 0.0;  ///< from the push before to the state
    double at = 0.0;       ///< of the state, a fraction of the part of the step that joints are driven in
  };

  /// Changes velocities and angular momenta by the contacts' impulses over an interval.
  void push(MotionState& state, const Interval& interval);

  /// Closed contacts, in an order of their own: 5 words each, the body, the other with its image, and the stretch.
  [[nodiscard]] std::vector<std::uint64_t> memory() const;
  /// @param words  as memory() gave them
  /// @throws StorageError if they are of no bodies
  void restore(std::span<const std::uint64_t> words);

 private:
  /// Two surfaces at one place: of body A, and of body B or a wall.
  struct Touch {
    int A = 0;
    int B = -1;                       ///< −1: a wall
    std::uint32_t image = 0;          ///< as in ContactMemory
    Eigen::Vector3d normal{0, 0, 1};  ///< from A to B
    double overlap_m = 0.0;
    Eigen::Vector3d arm_A_m{0, 0, 0};  ///< from the centre to the contact
    Eigen::Vector3d arm_B_m{0, 0, 0};
    Eigen::Vector3d wall_m_per_s{0, 0, 0};
    double friction = 0.0;
    bool lies = false;  ///< a capsule on a wall, with both ends
  };

  void prepare(const MotionState& state, const Interval& interval);
  void list_pairs(const Eigen::Matrix3Xd& position_m);
  void push_pair(int A, int B, const MotionState& state, const Interval& interval);
  /// @param apart_m  from the centre of A to that image of B
  void push_image(int A, int B, const Eigen::Vector3d& apart_m, std::uint32_t image, const MotionState& state,
                  const Interval& interval);
  void push_from_wall(int body, std::size_t wall, const MotionState& state, const Interval& interval);
  /// Adds the loads of a contact if it is closed, and remembers it.
  /// @param other  as in ContactMemory
  void act(const Touch& touch, int other, const MotionState& state, const Interval& interval);
  [[nodiscard]] double inverse_mass_per_kg(int body, const Eigen::Vector3d& arm_m, const Eigen::Vector3d& normal,
                                           const MotionState& state) const;
  /// Inverse of the effective mass of a contact, with what joints hold.
  [[nodiscard]] double inverse_mass_per_kg(const Touch& touch, double at, const MotionState& state);
  /// The contact in the push before; nullptr: it was open.
  [[nodiscard]] const ContactMemory* before(int body, int other, std::uint32_t image);
  /// Velocity of the other surface relative to that of A.
  [[nodiscard]] Eigen::Vector3d relative_m_per_s(const Touch& touch, const MotionState& state) const;
  void apply(MotionState& state, double duration_s);

  const BodyModel& model_;
  const Joints& joints_;
  Joints::Work joints_work_;
  NearPairs& near_pairs_;
  ContactLaw law_;
  double friction_;
  std::vector<WallSpecification> walls_;
  double reach_m_;
  std::vector<int> rank_;        ///< of each body by its name
  std::vector<int> by_rank_;     ///< bodies
  std::vector<BodyPair> pairs_;  ///< lower rank first, ascending by rank
  std::uint64_t listing_ = 0;

  std::vector<ContactMemory> memory_;  ///< pairs in the order of pairs_, then walls by body
  std::vector<Touch> touches_;         ///< those of memory_
  std::vector<ContactMemory> before_;
  std::size_t next_before_ = 0;  ///< first of before_ that may still be found

  double near_m_ = 0.0;  ///< gap below which contacts may begin in the interval
  Eigen::Matrix3Xd force_N_;
  Eigen::Matrix3Xd torque_N_m_;
};

/// Finds bodies that overlap.
class OverlapCheck {
 public:
  /// @param model, near_pairs  must outlive this object
  /// @param contact  for the error
  OverlapCheck(const BodyModel& model, NearPairs& near_pairs, const ContactSpecification& contact = {});

  /// @param state  finite
  /// @param step   for the error
  /// @throws SolverError naming two bodies that overlap, by how much, and what to do
  void check(const MotionState& state, std::int64_t step, ThreadTeam& team);

 private:
  void check_pair(int A, int B, const MotionState& state, std::int64_t step) const;

  const BodyModel& model_;
  NearPairs& near_pairs_;
  Overlaps overlaps_;
  bool contacts_are_resolved_;
};

}  // namespace copepod::body
