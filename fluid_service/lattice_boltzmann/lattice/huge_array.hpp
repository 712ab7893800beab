#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <sys/mman.h>

namespace copepod::fluid {

/// Zero-initialised array on huge pages where the system has them: 19 streams through 4 KB pages miss the TLB
/// at every turn (docs/decisions, in-place streaming).
template <class T>
class HugeArray {
 public:
  explicit HugeArray(std::size_t size) : size_(size), bytes_((size * sizeof(T) + page - 1) / page * page + page) {
    base_ = mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (base_ == MAP_FAILED) throw std::bad_alloc();
    madvise(base_, bytes_, MADV_HUGEPAGE);
    void* aligned = base_;
    std::size_t room = bytes_;
    data_ = static_cast<T*>(std::align(page, size * sizeof(T), aligned, room));
  }
  HugeArray(const HugeArray&) = delete;
  HugeArray& operator=(const HugeArray&) = delete;
  ~HugeArray() { munmap(base_, bytes_); }

  [[nodiscard]] T* data() { return data_; }
  [[nodiscard]] const T* data() const { return data_; }
  [[nodiscard]] std::size_t size() const { return size_; }
  T& operator[](std::size_t i) { return data_[i]; }
  const T& operator[](std::size_t i) const { return data_[i]; }

 private:
  static constexpr std::size_t page = std::size_t{2} << 20;
  std::size_t size_;
  std::size_t bytes_;
  void* base_ = nullptr;
  T* data_ = nullptr;
};

}  // namespace copepod::fluid
