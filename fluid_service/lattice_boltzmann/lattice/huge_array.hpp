#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <sys/mman.h>
#include <vector>

namespace copepod::fluid {

/// Memory on huge pages where the system has them: what is read and written at many places at once misses the TLB with
/// 4 KB pages (docs/decisions/in_place_streaming.md).
namespace huge_pages {

inline constexpr std::size_t page = std::size_t{2} << 20;

constexpr std::size_t whole_pages(std::size_t bytes) { return (bytes + page - 1) / page * page; }

/// Zeros, from the start of a page on.
inline void* map(std::size_t bytes) {
  const std::size_t used = whole_pages(bytes);
  std::size_t room = used + page;
  void* const base = mmap(nullptr, room, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (base == MAP_FAILED) throw std::bad_alloc();
  void* aligned = base;
  std::align(page, used, aligned, room);
  const auto before = static_cast<std::size_t>(static_cast<std::byte*>(aligned) - static_cast<std::byte*>(base));
  if (before > 0) munmap(base, before);
  if (room > used) munmap(static_cast<std::byte*>(aligned) + used, room - used);
  madvise(aligned, used, MADV_HUGEPAGE);
  return aligned;
}

inline void unmap(void* pages, std::size_t bytes) { munmap(pages, whole_pages(bytes)); }

/// For containers: what is smaller than half a page comes from the heap.
template <class T>
struct Allocator {
  using value_type = T;

  Allocator() = default;
  template <class U>
  Allocator(const Allocator<U>& /*other*/) {}  // NOLINT(google-explicit-constructor): containers convert it

  T* allocate(std::size_t size) {
    const std::size_t bytes = size * sizeof(T);
    return static_cast<T*>(bytes < page / 2 ? ::operator new(bytes) : map(bytes));
  }
  void deallocate(T* values, std::size_t size) {
    const std::size_t bytes = size * sizeof(T);
    if (bytes < page / 2)
      ::operator delete(values);
    else
      unmap(values, bytes);
  }
  bool operator==(const Allocator& /*other*/) const { return true; }
};

}  // namespace huge_pages

template <class T>
using HugeVector = std::vector<T, huge_pages::Allocator<T>>;

/// Zero-initialised array on huge pages, of which no page is there before it is written.
template <class T>
class HugeArray {
 public:
  explicit HugeArray(std::size_t size) : size_(size), data_(static_cast<T*>(huge_pages::map(size * sizeof(T)))) {}
  HugeArray(const HugeArray&) = delete;
  HugeArray& operator=(const HugeArray&) = delete;
  ~HugeArray() { huge_pages::unmap(data_, size_ * sizeof(T)); }

  /// Lets the system provide all memory now; show_progress() every now and then.
  template <class ShowProgress>
  void touch(const ShowProgress& show_progress) {
    constexpr std::size_t small_page = 4096 / sizeof(T);
    for (std::size_t i = 0; i < size_; i += small_page) {
      data_[i] = T(0);
      show_progress();
    }
  }

  [[nodiscard]] T* data() { return data_; }
  [[nodiscard]] const T* data() const { return data_; }
  [[nodiscard]] std::size_t size() const { return size_; }
  T& operator[](std::size_t i) { return data_[i]; }
  const T& operator[](std::size_t i) const { return data_[i]; }

 private:
  std::size_t size_;
  T* data_ = nullptr;
};

}  // namespace copepod::fluid
