#include "lattice_boltzmann/kernel/exchange_group.hpp"

namespace copepod::fluid {

template <class T>
Kernels<T> baseline_kernels() {
  return kernels_for<VectorsOf<16>, T>("baseline");
}

template <class T>
Kernels<T> choose_kernels() {
  for (const Kernels<T>& fast : {avx512_kernels<T>(), avx2_kernels<T>()})
    if (fast.stream_collide) return fast;
  return baseline_kernels<T>();
}

template Kernels<float> baseline_kernels<float>();
template Kernels<double> baseline_kernels<double>();
template Kernels<float> choose_kernels<float>();
template Kernels<double> choose_kernels<double>();

}  // namespace copepod::fluid
