#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "contract/fluid_setup.hpp"
#include "files/hdf5_file.hpp"
#include "lattice_boltzmann/output/fields.hpp"
#include "ranks/communicator.hpp"

namespace copepod::fluid {

/// Writes fields.h5, fields.xdmf (snapshots) and fields_mean.xdmf of a run [design.md §5]; collective.
///
/// One group per snapshot, /step_000001000/, and /mean/, with the arrays that the case asks for. In doubles and SI
/// units, they are
///   density_kg_per_m3 (nz, ny, nx)   velocity_m_per_s (nz, ny, nx, 3)
///   pressure_Pa (nz, ny, nx)         vorticity_per_s (nz, ny, nx, 3)   and always body (nz, ny, nx)
/// for the whole domain or the region that the case asks for: where symmetry planes halve the computed domain, the
/// mirror image is written too.
///
/// Each group is in a file of its own in fields/, which gets its name when it is complete, and fields.h5 holds
/// external links to all of them; it is replaced, never changed: a kill at any moment leaves every group readable
/// (docs/decisions/hdf5_without_mpi_io.md).
///
/// Ranks write side by side, which HDF5 allows in contiguous datasets only. Where they are to be compressed, the ranks
/// write to another file, from which rank 0 compresses them.
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
  using Attributes = std::function<void(Hdf5File&)>;

  void write(const std::string& group, const FieldBlock& block, const Attributes& attributes);
  /// On rank 0: makes the file for the cells and takes the disk space.
  void lay_out(const std::string& group, const Attributes& attributes);
  void write_cells(const FieldBlock& block) const;
  template <class T>
  void write_values(SharedFile& file, std::size_t array, const Box& box, const std::vector<T>& values) const;
  void compress(const std::string& group, const Attributes& attributes) const;
  /// On rank 0: gives the group's file its name, and names it in fields.h5 and to ParaView.
  void publish(const std::string& group);
  void find_groups();
  void add_groups_of(const std::string& file);
  [[nodiscard]] Hdf5File new_file(const std::string& path, std::int64_t bytes) const;
  void make_group(Hdf5File& file, const std::string& group, const Attributes& attributes) const;
  [[nodiscard]] std::string in_run(const std::string& file) const;
  [[nodiscard]] Hdf5File::Extent shape(const FieldArray& array) const;
  [[nodiscard]] std::int64_t data_bytes() const;

  FieldOutput output_;
  Box region_;
  std::vector<FieldArray> arrays_;
  std::vector<std::int64_t> offsets_;  ///< where the arrays start in the file [bytes]
  std::string unfinished_path_;        ///< of the file of a group that is being written
  std::string cells_path_;             ///< where the ranks write
  LatticeUnits units_;
  double step_s_;
  double cell_size_m_;
  MirrorImages images_;
  Communicator& communicator_;
  std::function<std::vector<double>(const FieldBlock&)> vorticity_;  ///< if asked for
  std::map<std::string, XdmfGrid> grids_;                            ///< on rank 0, by group: what is written
};

/// Decides after which steps fields are written or enter the mean; collective.
class FieldSchedule {
 public:
  FieldSchedule(const FluidSetup& setup, Communicator& communicator);

  /// @param step    steps completed; 0 once, when the bodies are in place
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
  std::optional<FieldWriter> writer_;  ///< none if nothing is to be written
  MeanField mean_;
};

/// Flow of some cells of the computed domain from the file of InitialFlowKind::file, which has the form of fields.h5.
/// The pressure is that of pressure_Pa, else that of density_kg_per_m3 in the group's units, else 0; `body` is empty.
/// @throws CaseError if the file, or a value of one of the cells, cannot be used
FieldBlock read_flow(const FluidSetup& setup, const Box& box, SolverContext& context);

/// Reads all cells of that file, a layer at a time. @throws CaseError
void check_flow_file(const FluidSetup& setup);

}  // namespace copepod::fluid
