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

}  // namespace copepod::fluid
