#include "output/parallel_file.hpp"

#include <algorithm>
#include <array>
#include <type_traits>
#include <utility>

#include <hdf5.h>

#include "communication/native_communicator.hpp"
#include "contract/errors.hpp"

namespace copepod::fluid {

namespace {

/// An HDF5 identifier and the function that releases it.
class Handle {
 public:
  Handle(hid_t id, herr_t (*release)(hid_t)) : id_(id), release_(release) {}
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() {
    if (id_ >= 0) release_(id_);
  }
  operator hid_t() const { return id_; }  // NOLINT: HDF5 takes nothing else
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

std::vector<hsize_t> sizes(const ParallelFile::Extent& extent) { return {extent.begin(), extent.end()}; }

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
  return reason.empty() ? "HDF5 does not say why" : reason;
}

/// Properties of a file that all ranks open together.
hid_t parallel_access(const Communicator& communicator) {
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  H5Pset_fapl_mpio(access, native_communicator(communicator), MPI_INFO_NULL);
  return access;
}

hid_t open_file(const std::string& path, ParallelFile::Access kind, const Communicator& communicator) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // errors are ours to report
  const Handle access(parallel_access(communicator), H5Pclose);
  switch (kind) {
    case ParallelFile::Access::create:
      return H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access);
    case ParallelFile::Access::extend:
      return H5Fopen(path.c_str(), H5F_ACC_RDWR, access);
    case ParallelFile::Access::read:
      break;
  }
  return H5Fopen(path.c_str(), H5F_ACC_RDONLY, access);
}

/// Properties of a transfer in which all ranks take part at once.
hid_t collective_transfer() {
  const hid_t transfer = H5Pcreate(H5P_DATASET_XFER);
  H5Pset_dxpl_mpio(transfer, H5FD_MPIO_COLLECTIVE);
  return transfer;
}

/// The space of a rank's part of a dataset, selected in `file_space`.
bool select(hid_t file_space, const ParallelFile::Extent& start, const ParallelFile::Extent& count) {
  return H5Sselect_hyperslab(file_space, H5S_SELECT_SET, sizes(start).data(), nullptr, sizes(count).data(),
                             nullptr) >= 0;
}

}  // namespace

ParallelFile::ParallelFile(const std::string& path, Access access, Communicator& communicator)
    : path_(path), communicator_(communicator), reading_(access == Access::read) {
  file_ = open_file(path, access, communicator);
  agree(file_ >= 0, "open");
}

ParallelFile::ParallelFile(ParallelFile&& other) noexcept
    : path_(std::move(other.path_)),
      communicator_(other.communicator_),
      file_(std::exchange(other.file_, -1)),
      reading_(other.reading_) {}

ParallelFile::~ParallelFile() {
  if (file_ >= 0) H5Fclose(file_);
}

/// All ranks learn whether all succeeded, and, where one did not, the reason of the lowest that did not.
void ParallelFile::agree(bool succeeded, const std::string& what) {
  using Text = std::array<char, 400>;
  const int ranks = communicator_.size();
  std::array<std::int64_t, 1> failing = {succeeded ? 0 : ranks - communicator_.rank()};
  communicator_.max_to_all(failing);
  if (failing[0] == 0) return;
  const int speaker = ranks - static_cast<int>(failing[0]);
  Text text{};
  if (communicator_.rank() == speaker) hdf5_reason().copy(text.data(), text.size() - 1);
  std::vector<Communicator::Message> messages;
  for (int peer = 0; peer < ranks; ++peer) {
    if (peer == communicator_.rank()) continue;
    if (communicator_.rank() == speaker)
      messages.push_back({peer, std::as_bytes(std::span(text)), {}});
    else if (peer == speaker)
      messages.push_back({peer, {}, std::as_writable_bytes(std::span(text))});
  }
  communicator_.start_exchange(messages)();
  throw StorageError(
      path_ + ": could not " + what + " (" + text.data() + "). " +
      (reading_ ? "Use another checkpoint." : "Make room on the disk, check permissions, and resume."));
}

void ParallelFile::make_group(const std::string& group) {
  bool fine = true;
  if (H5Lexists(file_, group.c_str(), H5P_DEFAULT) > 0)
    fine = H5Ldelete(file_, group.c_str(), H5P_DEFAULT) >= 0;
  const Handle made(H5Gcreate2(file_, group.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
  agree(fine && made.valid(), "make group " + group);
}

template <class T>
void ParallelFile::write_attribute(const std::string& object, const std::string& name, T value) {
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Handle attribute(H5Acreate_by_name(file_, object.c_str(), name.c_str(), type_of<T>(), space,
                                           H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose);
  agree(attribute.valid() && H5Awrite(attribute, type_of<T>(), &value) >= 0, "write attribute " + name);
}

template <class T>
T ParallelFile::read_attribute(const std::string& object, const std::string& name) {
  T value{};
  const Handle attribute(H5Aopen_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose);
  agree(attribute.valid() && H5Aread(attribute, type_of<T>(), &value) >= 0, "read attribute " + name);
  return value;
}

template <class T>
void ParallelFile::make_dataset(const std::string& dataset, const Extent& shape) {
  const Handle space(H5Screate_simple(static_cast<int>(shape.size()), sizes(shape).data(), nullptr),
                     H5Sclose);
  const Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_fill_time(properties, H5D_FILL_TIME_NEVER);  // every value is written anyway
  const Handle made(
      H5Dcreate2(file_, dataset.c_str(), type_of<T>(), space, H5P_DEFAULT, properties, H5P_DEFAULT),
      H5Dclose);
  agree(made.valid(), "make dataset " + dataset);
}

template <class T>
void ParallelFile::write(const std::string& dataset, const Extent& start, const Extent& count,
                         const T* values) {
  const Handle set(H5Dopen2(file_, dataset.c_str(), H5P_DEFAULT), H5Dclose);
  const Handle file_space(H5Dget_space(set), H5Sclose);
  const Handle memory_space(H5Screate_simple(static_cast<int>(count.size()), sizes(count).data(), nullptr),
                            H5Sclose);
  const Handle transfer(collective_transfer(), H5Pclose);
  agree(set.valid() && select(file_space, start, count), "write to dataset " + dataset);
  agree(H5Dwrite(set, type_of<T>(), memory_space, file_space, transfer, values) >= 0,
        "write dataset " + dataset);
}

template <class T>
void ParallelFile::read(const std::string& dataset, const Extent& start, const Extent& count, T* values) {
  const Handle set(H5Dopen2(file_, dataset.c_str(), H5P_DEFAULT), H5Dclose);
  const Handle file_space(H5Dget_space(set), H5Sclose);
  const Handle memory_space(H5Screate_simple(static_cast<int>(count.size()), sizes(count).data(), nullptr),
                            H5Sclose);
  const Handle transfer(collective_transfer(), H5Pclose);
  agree(set.valid() && select(file_space, start, count), "read from dataset " + dataset);
  agree(H5Dread(set, type_of<T>(), memory_space, file_space, transfer, values) >= 0,
        "read dataset " + dataset);
}

ParallelFile::Extent ParallelFile::shape(const std::string& dataset) {
  const Handle set(H5Dopen2(file_, dataset.c_str(), H5P_DEFAULT), H5Dclose);
  const Handle space(H5Dget_space(set), H5Sclose);
  std::vector<hsize_t> extents(static_cast<std::size_t>(std::max(0, H5Sget_simple_extent_ndims(space))));
  agree(H5Sget_simple_extent_dims(space, extents.data(), nullptr) >= 0, "read the shape of " + dataset);
  return {extents.begin(), extents.end()};
}

bool ParallelFile::has(const std::string& object) {
  const htri_t exists = H5Lexists(file_, object.c_str(), H5P_DEFAULT);
  agree(exists >= 0, "look for " + object);
  return exists > 0;
}

std::vector<std::string> ParallelFile::groups() {
  std::vector<std::string> names;
  const auto keep = [](hid_t, const char* name, const H5L_info_t*, void* target) -> herr_t {
    static_cast<std::vector<std::string>*>(target)->emplace_back(name);
    return 0;
  };
  agree(H5Literate(file_, H5_INDEX_NAME, H5_ITER_INC, nullptr, keep, &names) >= 0, "list its groups");
  return names;
}

void ParallelFile::on_leader(const std::function<void()>& action) {
  std::string reason;
  try {
    if (communicator_.rank() == 0) action();
  } catch (const std::exception& error) {
    reason = error.what();
  }
  if (!reason.empty())
    H5Epush2(H5E_DEFAULT, __FILE__, __func__, __LINE__, H5E_ERR_CLS, H5E_FILE, H5E_WRITEERROR, "%s",
             reason.c_str());
  agree(reason.empty(), "finish");
}

void ParallelFile::close() {
  const bool flushed = reading_ || H5Fflush(file_, H5F_SCOPE_GLOBAL) >= 0;
  agree(flushed, "flush");
  agree(H5Fclose(std::exchange(file_, -1)) >= 0, "close");
}

template void ParallelFile::write_attribute(const std::string&, const std::string&, double);
template void ParallelFile::write_attribute(const std::string&, const std::string&, std::int64_t);
template void ParallelFile::write_attribute(const std::string&, const std::string&, std::uint64_t);
template double ParallelFile::read_attribute(const std::string&, const std::string&);
template std::int64_t ParallelFile::read_attribute(const std::string&, const std::string&);
template std::uint64_t ParallelFile::read_attribute(const std::string&, const std::string&);
template void ParallelFile::make_dataset<double>(const std::string&, const Extent&);
template void ParallelFile::make_dataset<float>(const std::string&, const Extent&);
template void ParallelFile::make_dataset<std::int32_t>(const std::string&, const Extent&);
template void ParallelFile::write(const std::string&, const Extent&, const Extent&, const double*);
template void ParallelFile::write(const std::string&, const Extent&, const Extent&, const float*);
template void ParallelFile::write(const std::string&, const Extent&, const Extent&, const std::int32_t*);
template void ParallelFile::read(const std::string&, const Extent&, const Extent&, double*);
template void ParallelFile::read(const std::string&, const Extent&, const Extent&, float*);
template void ParallelFile::read(const std::string&, const Extent&, const Extent&, std::int32_t*);

}  // namespace copepod::fluid
