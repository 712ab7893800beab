#include "lattice_boltzmann/kernel/exchange_group.hpp"
#include "lattice_boltzmann/kernel/stream_collide.hpp"

namespace copepod::fluid {

namespace {
struct Baseline {
  static constexpr int vector_bytes = 16;  // what every x86-64 and AArch64 has
};
}  // namespace

template <class T>
StreamCollide<T> stream_collide_baseline() {
  return &StreamCollideLoop<Baseline, T>::run;
}

template <class T>
KernelChoice<T> choose_stream_collide() {
  if (const auto update = stream_collide_avx512<T>()) return {update, "avx512"};
  if (const auto update = stream_collide_avx2<T>()) return {update, "avx2"};
  return {stream_collide_baseline<T>(), "baseline"};
}

template StreamCollide<float> stream_collide_baseline<float>();
template StreamCollide<double> stream_collide_baseline<double>();
template KernelChoice<float> choose_stream_collide<float>();
template KernelChoice<double> choose_stream_collide<double>();

template <class T>
ExchangeGroups<T> choose_exchange_groups() {
  if (stream_collide_avx512<T>()) return exchange_groups_avx512<T>();
  if (stream_collide_avx2<T>()) return exchange_groups_avx2<T>();
  return exchange_groups_baseline<T>();
}

template <class T>
ExchangeGroups<T> exchange_groups_baseline() {
  return exchange_groups_for<Baseline, T>();
}

template ExchangeGroups<float> choose_exchange_groups<float>();
template ExchangeGroups<double> choose_exchange_groups<double>();
template ExchangeGroups<float> exchange_groups_baseline<float>();
template ExchangeGroups<double> exchange_groups_baseline<double>();

}  // namespace copepod::fluid
