#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "contract/fluid_setup.hpp"
#include "files/hdf5_file.hpp"
#include "lattice_boltzmann/output/fields.hpp"
#include "ranks/communicator.hpp"

namespace copepod::fluid {

/// Writes fields.h5 and fields.xdmf of a run [design.md §5]; collective.
///
/// One group per snapshot, /step_000001000/, and /mean/, each with, in doubles and SI units,
///   density_kg_per_m3 (nz, ny, nx)   velocity_m_per_s (nz, ny, nx, 3)   body (nz, ny, nx)
/// for the whole domain: where symmetry planes halve the computed one, the mirror image is written too, with
/// the normal velocity reversed. The file is closed after each group, so that a killed run leaves a readable
/// one; a group that exists already, from before a restart, is replaced.
class FieldWriter {
 public:
  FieldWriter(const FieldOutput& output, const FluidSetup& setup, Communicator& communicator);

  /// @param step   steps completed
  /// @param block  this rank's share of the computed domain
  /// @throws StorageError on all ranks if one of them cannot write
  void write_snapshot(std::int64_t step, const FieldBlock& block);
  /// @param samples  number of samples in the mean
  void write_mean(std::int64_t samples, const FieldBlock& block);

 private:
  /// Where the three datasets of a group start in the file [bytes].
  struct Offsets {
    std::int64_t density = 0;
    std::int64_t velocity = 0;
    std::int64_t body = 0;
  };
  using Attributes = std::function<void(Hdf5File&, const std::string& group)>;

  void write(const std::string& group, const FieldBlock& block, const Attributes& attributes);
  /// On rank 0: makes the group, under the name of an unfinished one, and takes the disk space.
  [[nodiscard]] Offsets lay_out(const Attributes& attributes) const;
  void write_cells(const Offsets& offsets, const FieldBlock& block) const;
  /// On rank 0: gives the group its name and describes to ParaView what is in the file.
  void publish(const std::string& group) const;

  FieldOutput output_;
  std::string path_;
  double step_s_;
  double cell_size_m_;
  MirrorImages images_;
  Communicator& communicator_;
};

/// Decides after which steps fields are written or enter the mean; collective.
class FieldSchedule {
 public:
  FieldSchedule(const FluidSetup& setup, Communicator& communicator);
  ~FieldSchedule();

  /// @param step    steps completed
  /// @param fields  computes this rank's fields; called only when they are needed
  /// @throws StorageError
  void after_step(std::int64_t step, const std::function<FieldBlock()>& fields);

  /// For checkpoints: the sums so far, and the steps that they are of.
  [[nodiscard]] const MeanField& mean() const { return mean_; }
  [[nodiscard]] Sampling sampling() const { return {output_.mean_start, output_.mean_every_steps}; }

  /// Continues after `step` with the sums of a checkpoint if they are of the very steps that would be in the
  /// mean by then. Otherwise, when a run is resumed with another mean, the sums start anew with a warning.
  void restore(std::int64_t step, const Sampling& sampling, MeanField mean);

 private:
  [[nodiscard]] bool enters_mean(std::int64_t step) const;
  [[nodiscard]] std::int64_t samples_by(std::int64_t step) const;

  FieldOutput output_;
  bool is_leader_;
  std::unique_ptr<FieldWriter> writer_;  ///< none if nothing is to be written
  MeanField mean_;
};

}  // namespace copepod::fluid
