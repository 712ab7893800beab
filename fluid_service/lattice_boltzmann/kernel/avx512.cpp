#include "lattice_boltzmann/kernel/exchange_group.hpp"
#include "lattice_boltzmann/kernel/stream_collide.hpp"

namespace copepod::fluid {

namespace {
struct [[maybe_unused]] Avx512 {
  static constexpr int vector_bytes = 64;
};
}  // namespace

template <class T>
StreamCollide<T> stream_collide_avx512() {
#ifdef __AVX512VL__
  return __builtin_cpu_supports("avx512vl") ? &StreamCollideLoop<Avx512, T>::run : nullptr;
#else
  return nullptr;  // not built for x86-64
#endif
}

template StreamCollide<float> stream_collide_avx512<float>();
template StreamCollide<double> stream_collide_avx512<double>();

template <class T>
ExchangeGroups<T> exchange_groups_avx512() {
  return exchange_groups_for<Avx512, T>();
}

template ExchangeGroups<float> exchange_groups_avx512<float>();
template ExchangeGroups<double> exchange_groups_avx512<double>();

}  // namespace copepod::fluid
