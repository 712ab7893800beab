#include "files/hdf5_file.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <numeric>
#include <sys/stat.h>
#include <type_traits>
#include <unistd.h>
#include <utility>

#include <hdf5.h>

#include "contract/errors.hpp"
#include "ranks/rank_failure.hpp"
#include "system/durable_file.hpp"

namespace copepod::fluid {

namespace {

constexpr std::uint64_t chunk_bytes = 1 << 20;        ///< about so much is compressed together
constexpr std::uint64_t read_piece_bytes = 16 << 20;  ///< at most so much is read between two signs of progress

/// An HDF5 identifier and the function that releases it.
class Handle {
 public:
  Handle(hid_t id, herr_t (*release)(hid_t)) : id_(id), release_(release) {}
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() {
    if (id_ >= 0) release_(id_);
  }
  [[nodiscard]] hid_t get() const { return id_; }
  [[nodiscard]] bool valid() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*release_)(hid_t);
};

template <class T>
hid_t type_of() {
  if constexpr (std::is_same_v<T, double>) return H5T_NATIVE_DOUBLE;
  if constexpr (std::is_same_v<T, float>) return H5T_NATIVE_FLOAT;
  if constexpr (std::is_same_v<T, std::int32_t>) return H5T_NATIVE_INT32;
  if constexpr (std::is_same_v<T, std::int64_t>) return H5T_NATIVE_INT64;
  if constexpr (std::is_same_v<T, std::uint64_t>) return H5T_NATIVE_UINT64;
}

std::vector<hsize_t> sizes(const Hdf5File::Extent& extent) { return {extent.begin(), extent.end()}; }

/// The innermost message on HDF5's error stack: the cause.
std::string hdf5_reason() {
  std::string reason;
  const auto keep_first = [](unsigned, const H5E_error2_t* error, void* target) -> herr_t {
    auto& text = *static_cast<std::string*>(target);
    if (text.empty() && error->desc != nullptr) text = error->desc;
    return 0;
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_first, &reason);
  H5Eclear2(H5E_DEFAULT);
  return reason.empty() ? "HDF5 gives no reason" : reason;
}

/// Held by the thread that uses HDF5 [docs/decisions/process_wide_state.md].
std::recursive_mutex& library_mutex() {
  static std::recursive_mutex mutex;
  return mutex;
}

/// Selects a part of a dataset.
/// @return its shape in memory; invalid if that failed
Handle selected(hid_t space, const Hdf5File::Extent& start, const Hdf5File::Extent& count) {
  const bool done =
      H5Sselect_hyperslab(space, H5S_SELECT_SET, sizes(start).data(), nullptr, sizes(count).data(), nullptr) >= 0;
  return {done ? H5Screate_simple(static_cast<int>(count.size()), sizes(count).data(), nullptr) : -1, H5Sclose};
}

hid_t open_file(const std::string& path, Hdf5File::Access kind) {
  H5dont_atexit();                              // at exit HDF5 would flush again what a full disk refused, and crash
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // errors are ours to report
  static const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);  // to close it clears the reason of a failure
  H5Pset_file_locking(access.get(), false, true);
  if (kind == Hdf5File::Access::create) return H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access.get());
  return H5Fopen(path.c_str(), H5F_ACC_RDONLY, access.get());
}

constexpr std::int64_t write_piece_bytes = 16 << 20;  ///< at most so much between two signs of progress

StorageError storage_error(const std::string& path, const std::string& action, int error) {
  return StorageError(path + ": cannot " + action + " (" + std::strerror(error) +
                      "). Make room on the disk, check permissions, and resume.");
}

/// Takes the disk space of a part of a file.
/// @return 0, or the error's number
int allocate(int file, std::int64_t start, std::int64_t bytes, SolverContext& context) {
  int error = 0;
  for (std::int64_t done = 0; done < bytes && error == 0; done += write_piece_bytes) {
    error = posix_fallocate(file, start + done, std::min(write_piece_bytes, bytes - done));
    context.report_progress();
  }
  return error;
}

/// @param take  with the file and its size; returns the bytes that it takes, and an error's number or 0
template <class Take>
void take_space(const std::string& path, int flags, const Take& take) {
  const int file = open(path.c_str(), O_WRONLY | O_CLOEXEC | flags, 0644);
  if (file < 0) throw storage_error(path, "open it", errno);
  struct stat status {};
  const auto [bytes, error] =
      fstat(file, &status) != 0 ? std::pair(std::int64_t{0}, errno) : take(file, status.st_size);
  close(file);
  if (error != 0) throw storage_error(path, "get " + std::to_string(bytes) + " bytes of disk space", error);
}

/// All ranks learn the text of rank `speaker`.
std::string spread(Communicator& communicator, int speaker, const std::string& own) {
  if (communicator.rank() != speaker) {
    std::vector<std::byte> text;
    communicator.receive(speaker, text);
    return {reinterpret_cast<const char*>(text.data()), text.size()};
  }
  std::vector<std::function<void()>> sends;
  for (int peer = 0; peer < communicator.size(); ++peer)
    if (peer != speaker) sends.push_back(communicator.start_send(peer, std::as_bytes(std::span(own))));
  for (const auto& finish_send : sends) finish_send();
  return own;
}

}  // namespace

Hdf5File::Hdf5File(const std::string& path, Access access, SolverContext& context)
    : library_(library_mutex()), path_(path), access_(access), context_(context) {
  file_ = open_file(path, access);
  require(file_ >= 0, "open it");
}

Hdf5File::~Hdf5File() {
  if (file_ >= 0) H5Fclose(file_);
}

void Hdf5File::require(bool succeeded, const std::string& action) const {
  if (succeeded) return;
  const std::string remedy = access_ == Access::read ? "Use another checkpoint or file."
                                                     : "Make room on the disk, check permissions, and resume.";
  throw StorageError(path_ + ": cannot " + action + " (" + hdf5_reason() + "). " + remedy);
}

void Hdf5File::make_group(const std::string& group) {
  const Handle made(H5Gcreate2(file_, group.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
  require(made.valid(), "make group " + group);
}

void Hdf5File::link(const std::string& group, const std::string& file) {
  require(H5Lcreate_external(file.c_str(), group.c_str(), file_, group.c_str(), H5P_DEFAULT, H5P_DEFAULT) >= 0,
          "link " + group);
}

bool Hdf5File::has(const std::string& object) {
  const htri_t exists = H5Lexists(file_, object.c_str(), H5P_DEFAULT);
  require(exists >= 0, "look for " + object);
  return exists > 0;
}

Hdf5File::Extent Hdf5File::shape(const std::string& dataset) {
  const Handle set(H5Dopen2(file_, dataset.c_str(), H5P_DEFAULT), H5Dclose);
  require(set.valid(), "open dataset " + dataset);
  const Handle space(H5Dget_space(set.get()), H5Sclose);
  std::array<hsize_t, H5S_MAX_RANK> sizes{};
  const int axes = H5Sget_simple_extent_dims(space.get(), sizes.data(), nullptr);
  require(axes >= 0, "look at dataset " + dataset);
  return {sizes.begin(), sizes.begin() + axes};
}

std::vector<std::string> Hdf5File::names() {
  std::vector<std::string> names;
  const auto keep = [](hid_t, const char* name, const H5L_info_t*, void* target) -> herr_t {
    static_cast<std::vector<std::string>*>(target)->emplace_back(name);
    return 0;
  };
  require(H5Literate(file_, H5_INDEX_NAME, H5_ITER_INC, nullptr, keep, &names) >= 0, "list its groups");
  return names;
}

template <class T>
void Hdf5File::write_attribute(const std::string& object, const std::string& name, T value) {
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Handle attribute(H5Acreate_by_name(file_, object.c_str(), name.c_str(), type_of<T>(), space.get(), H5P_DEFAULT,
                                           H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose);
  require(attribute.valid() && H5Awrite(attribute.get(), type_of<T>(), &value) >= 0, "write attribute " + name);
}

template <class T>
T Hdf5File::read_attribute(const std::string& object, const std::string& name) {
  T value{};
  const Handle attribute(H5Aopen_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  require(attribute.valid() && H5Aread(attribute.get(), type_of<T>(), &value) >= 0, "read attribute " + name);
  return value;
}

template <class T>
std::int64_t Hdf5File::make_dataset(const std::string& dataset, const Extent& shape) {
  const Handle space(H5Screate_simple(static_cast<int>(shape.size()), sizes(shape).data(), nullptr), H5Sclose);
  const Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_layout(properties.get(), H5D_CONTIGUOUS);
  H5Pset_alloc_time(properties.get(), H5D_ALLOC_TIME_EARLY);
  H5Pset_fill_time(properties.get(), H5D_FILL_TIME_NEVER);
  const Handle made(
      H5Dcreate2(file_, dataset.c_str(), type_of<T>(), space.get(), H5P_DEFAULT, properties.get(), H5P_DEFAULT),
      H5Dclose);
  require(made.valid(), "make dataset " + dataset);
  const haddr_t offset = H5Dget_offset(made.get());
  require(offset != HADDR_UNDEF, "place dataset " + dataset);
  return static_cast<std::int64_t>(offset);
}

template <class T>
void Hdf5File::copy_compressed(Hdf5File& source, const std::string& dataset, const Extent& shape, int level) {
  const std::uint64_t layer = std::accumulate(shape.begin() + 1, shape.end(), std::uint64_t{1}, std::multiplies());
  Extent chunk = shape;
  chunk[0] = std::clamp<std::uint64_t>(chunk_bytes / (layer * sizeof(T)), 1, shape[0]);
  const Handle space(H5Screate_simple(static_cast<int>(shape.size()), sizes(shape).data(), nullptr), H5Sclose);
  const Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_chunk(properties.get(), static_cast<int>(chunk.size()), sizes(chunk).data());
  H5Pset_shuffle(properties.get());
  H5Pset_deflate(properties.get(), static_cast<unsigned>(level));
  const Handle made(
      H5Dcreate2(file_, dataset.c_str(), type_of<T>(), space.get(), H5P_DEFAULT, properties.get(), H5P_DEFAULT),
      H5Dclose);
  require(made.valid(), "make dataset " + dataset);
  std::vector<T> values(chunk[0] * layer);
  Extent start(shape.size(), 0);
  for (; start[0] < shape[0]; start[0] += chunk[0]) {
    Extent count = shape;
    count[0] = std::min(chunk[0], shape[0] - start[0]);
    source.read(dataset, start, count, values.data());
    const Handle memory = selected(space.get(), start, count);
    require(memory.valid() &&
                H5Dwrite(made.get(), type_of<T>(), memory.get(), space.get(), H5P_DEFAULT, values.data()) >= 0,
            "write dataset " + dataset);
  }
}

template <class T>
void Hdf5File::read(const std::string& dataset, const Extent& start, const Extent& count, T* values) {
  const std::uint64_t size = std::accumulate(count.begin(), count.end(), std::uint64_t{1}, std::multiplies());
  const auto cut = std::find_if(count.begin(), count.end(), [](std::uint64_t along) { return along > 1; });
  if (size * sizeof(T) <= read_piece_bytes || cut == count.end()) {
    read_piece(dataset, start, count, values);
    context_.report_progress();
    return;
  }
  // Halves along the first axis that can be cut lie one behind the other in memory.
  const auto axis = static_cast<std::size_t>(cut - count.begin());
  Extent first = count, second = count, middle = start;
  first[axis] /= 2;
  second[axis] -= first[axis];
  middle[axis] += first[axis];
  read(dataset, start, first, values);
  read(dataset, middle, second, values + size / count[axis] * first[axis]);
}

template <class T>
void Hdf5File::read_piece(const std::string& dataset, const Extent& start, const Extent& count, T* values) {
  const Handle set(H5Dopen2(file_, dataset.c_str(), H5P_DEFAULT), H5Dclose);
  require(set.valid(), "open dataset " + dataset);
  const Handle space(H5Dget_space(set.get()), H5Sclose);
  const Handle memory = selected(space.get(), start, count);
  require(memory.valid() && H5Dread(set.get(), type_of<T>(), memory.get(), space.get(), H5P_DEFAULT, values) >= 0,
          "read dataset " + dataset);
}

void Hdf5File::close() { require(H5Fclose(std::exchange(file_, -1)) >= 0, "close it"); }

template void Hdf5File::write_attribute(const std::string&, const std::string&, double);
template void Hdf5File::write_attribute(const std::string&, const std::string&, std::int64_t);
template void Hdf5File::write_attribute(const std::string&, const std::string&, std::uint64_t);
template double Hdf5File::read_attribute(const std::string&, const std::string&);
template std::int64_t Hdf5File::read_attribute(const std::string&, const std::string&);
template std::uint64_t Hdf5File::read_attribute(const std::string&, const std::string&);
template std::int64_t Hdf5File::make_dataset<double>(const std::string&, const Extent&);
template std::int64_t Hdf5File::make_dataset<float>(const std::string&, const Extent&);
template std::int64_t Hdf5File::make_dataset<std::int32_t>(const std::string&, const Extent&);
template void Hdf5File::copy_compressed<double>(Hdf5File&, const std::string&, const Extent&, int);
template void Hdf5File::copy_compressed<std::int32_t>(Hdf5File&, const std::string&, const Extent&, int);
template void Hdf5File::read(const std::string&, const Extent&, const Extent&, double*);
template void Hdf5File::read(const std::string&, const Extent&, const Extent&, float*);
template void Hdf5File::read(const std::string&, const Extent&, const Extent&, std::int32_t*);

void on_every_rank(Communicator& communicator, const std::function<void()>& action) {
  bool failed = false;
  std::string reason;
  try {
    action();
  } catch (const PeerFailed&) {
    throw;  // the ranks are out of step already
  } catch (const std::exception& error) {
    failed = true;
    reason = failure_of_rank(error, communicator.rank(), -1).reason;
  }
  const int ranks = communicator.size();
  std::array<std::int64_t, 1> failing = {failed ? ranks - communicator.rank() : 0};
  communicator.max_to_all(failing);
  if (failing[0] == 0) return;
  throw StorageError(spread(communicator, ranks - static_cast<int>(failing[0]), reason));
}

void on_leader(Communicator& communicator, const std::function<void()>& action) {
  on_every_rank(communicator, [&] {
    if (communicator.rank() == 0) action();
  });
}

void require_space(const std::string& path, std::int64_t bytes, SolverContext& context) {
  take_space(path, O_CREAT, [&](int file, std::int64_t size) {
    const int error = allocate(file, size, bytes, context);
    return std::pair(bytes, ftruncate(file, size) != 0 && error == 0 ? errno : error);
  });
}

void reserve_space(const std::string& path, SolverContext& context) {
  take_space(path, 0, [&](int file, std::int64_t size) { return std::pair(size, allocate(file, 0, size, context)); });
}

SharedFile::SharedFile(const std::string& path, SolverContext& context)
    : path_(path), context_(context), file_(open(path.c_str(), O_WRONLY | O_CLOEXEC)) {
  if (file_ < 0) fail("open it");
}

SharedFile::~SharedFile() {
  if (file_ >= 0) close(file_);
}

void SharedFile::fail(const std::string& action) const { throw storage_error(path_, action, errno); }

void SharedFile::write_run(std::uint64_t position, const char* bytes, std::size_t size) {
  constexpr std::size_t piece = write_piece_bytes;
  for (std::size_t done = 0; done < size; done += piece) {
    const auto part = std::span(bytes + done, std::min(piece, size - done));
    if (!write_all(file_, position + done, std::as_bytes(part))) fail("write to it");
    context_.report_progress();
  }
}

void SharedFile::write_bytes(std::int64_t offset, const Hdf5File::Extent& shape, const Hdf5File::Extent& start,
                             const Hdf5File::Extent& count, const char* bytes, std::size_t value_bytes) {
  // A run is contiguous in the file: the last axes that the part covers completely, and the one before.
  std::size_t axes = shape.size();
  std::uint64_t run = 1;
  while (axes > 0) {
    --axes;
    run *= count[axes];
    if (count[axes] != shape[axes]) break;
  }
  std::uint64_t runs = 1;
  for (std::size_t axis = 0; axis < axes; ++axis) runs *= count[axis];
  if (run == 0) return;
  for (std::uint64_t i = 0; i < runs; ++i) {
    Hdf5File::Extent place = start;
    std::uint64_t rest = i;
    for (std::size_t axis = axes; axis-- > 0; rest /= count[axis]) place[axis] += rest % count[axis];
    std::uint64_t index = 0;
    for (std::size_t axis = 0; axis < shape.size(); ++axis) index = index * shape[axis] + place[axis];
    write_run(static_cast<std::uint64_t>(offset) + index * value_bytes, bytes + i * run * value_bytes,
              run * value_bytes);
  }
}

/// Piece by piece first, since fsync reports no progress while it waits for the disk.
void SharedFile::sync() {
  struct stat status {};
  if (fstat(file_, &status) != 0) fail("look at it");
  constexpr unsigned now = SYNC_FILE_RANGE_WAIT_BEFORE | SYNC_FILE_RANGE_WRITE | SYNC_FILE_RANGE_WAIT_AFTER;
  for (std::int64_t position = 0; position < status.st_size; position += write_piece_bytes) {
    if (sync_file_range(file_, position, write_piece_bytes, now) != 0 && errno != ENOSYS) fail("bring it to the disk");
    context_.report_progress();
  }
  if (fsync(file_) != 0) fail("bring it to the disk");
}

}  // namespace copepod::fluid
