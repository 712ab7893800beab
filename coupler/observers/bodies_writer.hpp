#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "contract/body_setup.hpp"
#include "geometry/shapes/solid.hpp"
#include "observers/observer.hpp"

namespace copepod::coupler {

/// Writes bodies.pvd, which ParaView opens: the surfaces of all bodies over time, one file bodies/step_000001000.vtp
/// per frame (VTK poly data).
///
/// Each body is one cell, with the arrays `body` (1 + index, as in fields.h5), `name`, and, in SI units and the world
/// frame, velocity, angular velocity, and the loads and driving force of trajectory.csv. Bodies are folded back into a
/// periodic domain, where the fields are; `position_m` is not folded. Frames are written for every `every_steps`-th
/// step, for the first and for the last.
///
/// Every file is complete at any time. A resumed run keeps the frames before its first step and writes the others anew.
class BodiesWriter final : public Observer {
 public:
  /// @param path               of bodies.pvd
  /// @param periodic_length_m  of the domain; 0 along axes that are not periodic
  /// @param every_steps        > 0
  /// @param first_step         of this run: 0, or where it is resumed
  /// @throws StorageError if the files cannot be written
  BodiesWriter(std::filesystem::path path, const std::vector<BodySpecification>& bodies, double step_s,
               const std::array<double, 3>& periodic_length_m, std::int64_t every_steps, std::int64_t first_step);

  void observe(const StepRecord& record) override;
  void finish(const StepRecord& last) override;

  /// Brings every frame so far to the disk.
  void sync();

 private:
  using Clock = std::chrono::steady_clock;

  void keep_frames_before(std::int64_t first_step);
  void add_frame(const StepRecord& record);
  void write_list();
  [[nodiscard]] std::string frame_text(const StepRecord& record) const;

  std::filesystem::path path_;
  std::filesystem::path folder_;
  std::vector<std::string> names_;
  std::vector<Surface> surfaces_;  ///< by body
  double step_s_;
  std::array<double, 3> periodic_length_m_;
  std::int64_t every_steps_;
  std::vector<std::int64_t> frames_;  ///< their steps, in order
  std::size_t synced_ = 0;            ///< frames that are on the disk
  Clock::time_point listed_;
};

}  // namespace copepod::coupler
