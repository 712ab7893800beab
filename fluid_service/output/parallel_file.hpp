#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "communication/communicator.hpp"

namespace copepod::fluid {

/// An HDF5 file that all ranks write or read together; the only place that calls HDF5.
///
/// Every method is collective and ends with an agreement: if it fails on one rank it throws StorageError with
/// that rank's reason on all of them, so no rank is left waiting inside HDF5.
class ParallelFile {
 public:
  enum class Access { create, extend, read };

  ParallelFile(const std::string& path, Access access, Communicator& communicator);
  ParallelFile(ParallelFile&&) noexcept;
  ParallelFile(const ParallelFile&) = delete;
  ParallelFile& operator=(const ParallelFile&) = delete;
  ~ParallelFile();

  using Extent = std::vector<std::uint64_t>;

  /// Makes an empty group; replaces one of this name.
  void make_group(const std::string& group);

  template <class T>  ///< double, std::int64_t or std::uint64_t
  void write_attribute(const std::string& object, const std::string& name, T value);
  template <class T>
  [[nodiscard]] T read_attribute(const std::string& object, const std::string& name);

  /// Makes a dataset without values.
  template <class T>  ///< double, float or std::int32_t
  void make_dataset(const std::string& dataset, const Extent& shape);
  /// Writes this rank's part, `count` values from `start` on along each axis, last axis fastest.
  template <class T>
  void write(const std::string& dataset, const Extent& start, const Extent& count, const T* values);
  template <class T>
  void read(const std::string& dataset, const Extent& start, const Extent& count, T* values);
  [[nodiscard]] Extent shape(const std::string& dataset);

  [[nodiscard]] bool has(const std::string& object);
  /// Names of the groups in the root, sorted.
  [[nodiscard]] std::vector<std::string> groups();

  /// Runs `action` on rank 0 only; its exception becomes a StorageError on all ranks.
  void on_leader(const std::function<void()>& action);

  /// Writes everything to disk and closes the file.
  void close();

 private:
  /// Throws on all ranks if one of them has an empty-handed result or a reason.
  void agree(bool succeeded, const std::string& what);

  std::string path_;
  Communicator& communicator_;
  std::int64_t file_ = -1;  ///< HDF5 identifier
  bool reading_ = false;
};

}  // namespace copepod::fluid
