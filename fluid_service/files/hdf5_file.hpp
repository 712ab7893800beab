#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "contract/solver_context.hpp"
#include "ranks/communicator.hpp"

namespace copepod::fluid {

/// An HDF5 file opened by one process; the only place that calls HDF5.
///
/// No MPI: rank 0 alone lays a file out, all ranks then write their cells at the offsets of its contiguous
/// datasets (SharedFile), and each rank reads by itself (docs/decisions/hdf5_without_mpi_io.md).
/// Every method throws StorageError with HDF5's innermost reason. Locks of files are not used, so that other programs
/// can read snapshots during the run. HDF5 serves one thread at a time: as long as a file is open in one, the
/// constructor waits in any other.
class Hdf5File {
 public:
  enum class Access { create, read };
  using Extent = std::vector<std::uint64_t>;
  /// Of one axis more.
  static Extent with(Extent extent, std::uint64_t last) {
    extent.push_back(last);
    return extent;
  }

  /// @param context  to report progress to; outlives the file
  Hdf5File(const std::string& path, Access access, SolverContext& context);
  ~Hdf5File();

  void make_group(const std::string& group);
  /// An external link to the group of this name in another file. @param file  from the folder of this one
  void link(const std::string& group, const std::string& file);
  [[nodiscard]] bool has(const std::string& object);
  [[nodiscard]] Extent shape(const std::string& dataset);
  /// Names in the root, sorted.
  [[nodiscard]] std::vector<std::string> names();

  template <class T>  ///< double, std::int64_t or std::uint64_t
  void write_attribute(const std::string& object, const std::string& name, T value);
  template <class T>
  [[nodiscard]] T read_attribute(const std::string& object, const std::string& name);

  /// Makes a contiguous dataset whose values are still undefined. @return where they start in the file
  /// [bytes]
  template <class T>  ///< double, float or std::int32_t
  std::int64_t make_dataset(const std::string& dataset, const Extent& shape);
  /// Makes a dataset with the values that `source` holds under the same name, compressed: bytes of equal place
  /// together, then deflate, in chunks of layers of the first axis. The same values always give the same bytes.
  /// @param level  of deflate, 1 to 9
  template <class T>  ///< double or std::int32_t
  void copy_compressed(Hdf5File& source, const std::string& dataset, const Extent& shape, int level);
  /// Reads `count` values from `start` on along each axis, last axis fastest. Shows progress.
  template <class T>
  void read(const std::string& dataset, const Extent& start, const Extent& count, T* values);

  /// On return everything is in the file; the destructor closes it too, but cannot report errors.
  void close();

 private:
  template <class T>
  void read_piece(const std::string& dataset, const Extent& start, const Extent& count, T* values);
  void require(bool succeeded, const std::string& action) const;

  std::unique_lock<std::recursive_mutex> library_;
  std::string path_;
  Access access_;
  SolverContext& context_;
  std::int64_t file_ = -1;  ///< HDF5 identifier
};

/// Runs `action` on every rank; collective. If it throws on one, all ranks throw a StorageError with the
/// reason of the lowest rank that failed: none is left waiting for another.
void on_every_rank(Communicator& communicator, const std::function<void()>& action);
/// The same with `action` on rank 0 only.
void on_leader(Communicator& communicator, const std::function<void()>& action);

/// Makes sure that a file, which need not exist, can grow by so many bytes, and leaves it as it was.
///
/// HDF5 cannot end properly once one of its writes has failed, so a full disk must show before HDF5 writes.
/// @throws StorageError
void require_space(const std::string& path, std::int64_t bytes, SolverContext& context);

/// Takes the disk space of a whole file that so far has holes, so that no later write finds the disk full.
/// @throws StorageError
void reserve_space(const std::string& path, SolverContext& context);

/// Writes values of a contiguous dataset from any number of processes at once; not collective. Reports
/// progress, so that a slow disk is not mistaken for a process that hangs.
class SharedFile {
 public:
  /// Opens an existing file.
  /// @param context  to report progress to; outlives the file
  /// @throws StorageError
  SharedFile(const std::string& path, SolverContext& context);
  SharedFile(const SharedFile&) = delete;
  SharedFile& operator=(const SharedFile&) = delete;
  ~SharedFile();

  /// Writes the part [start, start + count) of an array of this shape, last axis fastest, whose first value
  /// lies at `offset` bytes. @throws StorageError
  template <class T>
  void write(std::int64_t offset, const Hdf5File::Extent& shape, const Hdf5File::Extent& start,
             const Hdf5File::Extent& count, const T* values) {
    write_bytes(offset, shape, start, count, reinterpret_cast<const char*>(values), sizeof(T));
  }
  /// Waits until everything written is on the disk. @throws StorageError
  void sync();

 private:
  void write_bytes(std::int64_t offset, const Hdf5File::Extent& shape, const Hdf5File::Extent& start,
                   const Hdf5File::Extent& count, const char* bytes, std::size_t value_bytes);
  void write_run(std::uint64_t position, const char* bytes, std::size_t size);
  [[noreturn]] void fail(const std::string& action) const;

  std::string path_;
  SolverContext& context_;
  int file_;
};

}  // namespace copepod::fluid
