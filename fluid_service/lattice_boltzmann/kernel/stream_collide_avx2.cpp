#include "lattice_boltzmann/kernel/stream_collide.hpp"

namespace copepod::fluid {

namespace {
struct [[maybe_unused]] Avx2 {
  static constexpr int vector_bytes = 32;
};
}  // namespace

template <class T>
StreamCollide<T> stream_collide_avx2() {
#ifdef __AVX2__
  return __builtin_cpu_supports("avx2") ? &StreamCollideLoop<Avx2, T>::run : nullptr;
#else
  return nullptr;  // not built for x86-64
#endif
}

template StreamCollide<float> stream_collide_avx2<float>();
template StreamCollide<double> stream_collide_avx2<double>();

}  // namespace copepod::fluid
