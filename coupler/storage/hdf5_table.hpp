#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "storage/checksum.hpp"

namespace copepod::coupler {

inline constexpr const char* hdf5_suffix = ".h5";

/// A dataset of an Hdf5Table: numbers of 64 bits.
struct Hdf5Column {
  enum class Kind { whole_number, real };
  std::string name;
  Kind kind = Kind::real;
  std::uint64_t components = 0;  ///< of each row; 0: one number per sample, shape (samples,)

  [[nodiscard]] std::uint64_t rank() const { return components == 0 ? 1 : 3; }
  /// Bytes of one sample.
  [[nodiscard]] std::uint64_t bytes(std::uint64_t rows) const {
    return (components == 0 ? 1 : rows * components) * sizeof(double);
  }
};

/// Where the numbers and the index of an Hdf5Table lie; all of it follows from the members.
///
///   head | names of the rows | block 0 | block 1 | …         block: index nodes | 64 groups
///
/// A group holds a chunk of each column: some samples. The index of a column is a tree (HDF5's B-tree, version 1) with
/// nodes of 64 entries; a leaf indexes the block that it begins, and the nodes above it lie where their first leaf
/// does. So the entries of a node are known before there is what they point to.
struct Hdf5Layout {
  static constexpr std::uint64_t fan_out = 64;  ///< entries of a node: HDF5's default for chunks
  static constexpr std::uint64_t levels = 4;    ///< up to 64⁴ = 16.7 million groups

  std::vector<std::uint64_t> column_bytes;  ///< of one sample
  std::uint64_t samples_per_group = 1;
  std::uint64_t node_bytes = 0;   ///< of one node of every column
  std::uint64_t first_block = 0;  ///< where block 0 begins

  [[nodiscard]] std::uint64_t sample_bytes() const {
    return std::accumulate(column_bytes.begin(), column_bytes.end(), std::uint64_t{0});
  }
  [[nodiscard]] std::uint64_t group_bytes() const { return samples_per_group * sample_bytes(); }
  [[nodiscard]] std::uint64_t block_at(std::uint64_t block) const;
  [[nodiscard]] std::uint64_t group_at(std::uint64_t group) const;
  /// Of the nodes of this level (0: leaves) that lead to a group.
  [[nodiscard]] std::uint64_t nodes_at(std::uint64_t level, std::uint64_t group) const;
};

/// A table of a run directory as an HDF5 file that grows sample by sample: chunked datasets of shape (samples, rows,
/// components), and the names of the rows.
///
/// The file is complete at any moment, also once the process was killed: what readers reach is neither moved nor
/// changed, and samples count once their numbers are in the file. Readers open it as any HDF5 file, and again to see
/// more. The same samples give the same bytes, whether a run was interrupted or not. Written without the HDF5 library,
/// which cannot do this [docs/decisions/trajectories.md].
class Hdf5Table final : public TableFile {
 public:
  /// @param rows_name  of the dataset with the names of the rows
  /// @param end        as for CsvFile; its bytes are those of the samples alone
  /// @throws StorageError if the file cannot be written, or is not what it was up to `end`
  Hdf5Table(std::string path, std::vector<Hdf5Column> columns, std::string rows_name,
            const std::vector<std::string>& rows, const std::optional<TableEnd>& end);
  ~Hdf5Table() override;

  /// Adds a sample, which readers see at the latest with the first one a second later.
  /// @param values  of each column, last axis fastest
  /// @throws StorageError if the disk does not take it
  void add(std::span<const std::span<const std::byte>> values);
  /// Shows every sample so far to readers.
  void flush() override;

  /// Of the samples that a file holds up to `end`; empty if it has fewer, or cannot be read.
  static std::optional<Checksum> checksum_of_start(const std::string& path, const TableEnd& end);

 private:
  void create(const std::vector<std::string>& rows);
  void continue_from(const TableEnd& end);
  void begin_group(std::uint64_t group);
  void write_nodes(std::uint64_t level, std::uint64_t group);
  void write_counts(std::uint64_t group);
  void write_head(std::uint64_t end_of_file);
  [[nodiscard]] std::uint64_t newest_group() const {
    return (std::max<std::uint64_t>(samples_, 1) - 1) / layout_.samples_per_group;
  }

  std::vector<Hdf5Column> columns_;
  std::string rows_name_;
  std::uint64_t rows_;
  std::uint64_t name_bytes_ = 1;  ///< of the name of a row
  Hdf5Layout layout_;
  std::uint64_t room_ = 1;  ///< groups
  std::uint64_t samples_ = 0;
  std::uint64_t shown_ = 0;          ///< samples that readers see
  std::uint64_t flushed_group_ = 0;  ///< the newest one then
};

}  // namespace copepod::coupler
