#include "lattice_boltzmann/kernel/exchange_group.hpp"
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

template <class T>
ExchangeGroups<T> exchange_groups_avx2() {
  return exchange_groups_for<Avx2, T>();
}

template ExchangeGroups<float> exchange_groups_avx2<float>();
template ExchangeGroups<double> exchange_groups_avx2<double>();

}  // namespace copepod::fluid
