#include "files/shared_file.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "contract/errors.hpp"
#include "ranks/rank_failure.hpp"

namespace copepod::fluid {

namespace {

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

/// All ranks learn the text of rank `speaker`.
std::string spread(Communicator& communicator, int speaker, const std::string& own) {
  FailureReport report;
  report.reason = own;
  FailurePacket packet = pack_failure(report);
  std::vector<Communicator::Message> messages;
  for (int peer = 0; peer < communicator.size(); ++peer) {
    if (peer == communicator.rank()) continue;
    if (communicator.rank() == speaker) {
      messages.push_back({peer, std::as_bytes(std::span(packet)), {}});
    } else if (peer == speaker) {
      messages.push_back({peer, {}, std::as_writable_bytes(std::span(packet))});
    }
  }
  communicator.start_exchange(messages)();
  return unpack_failure(packet).reason;
}

}  // namespace

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
  const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
  if (file < 0) throw storage_error(path, "open it", errno);
  struct stat status {};
  int error = fstat(file, &status) != 0 ? errno : allocate(file, status.st_size, bytes, context);
  if (ftruncate(file, status.st_size) != 0 && error == 0) error = errno;
  close(file);
  if (error != 0) throw storage_error(path, "get " + std::to_string(bytes) + " bytes of disk space", error);
}

void reserve_space(const std::string& path, SolverContext& context) {
  const int file = open(path.c_str(), O_WRONLY | O_CLOEXEC);
  if (file < 0) throw storage_error(path, "open it", errno);
  struct stat status {};
  const int error = fstat(file, &status) != 0 ? errno : allocate(file, 0, status.st_size, context);
  close(file);
  if (error != 0) throw storage_error(path, "get " + std::to_string(status.st_size) + " bytes of disk space", error);
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
  while (size > 0) {
    const std::size_t piece = std::min(size, static_cast<std::size_t>(write_piece_bytes));
    const ssize_t written = pwrite(file_, bytes, piece, static_cast<off_t>(position));
    context_.report_progress();
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail("write to it");
    position += static_cast<std::uint64_t>(written);
    bytes += written;
    size -= static_cast<std::size_t>(written);
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
