#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "files/hdf5_file.hpp"
#include "ranks/communicator.hpp"

namespace copepod::fluid {

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
