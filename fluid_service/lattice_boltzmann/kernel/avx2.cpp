#include "lattice_boltzmann/kernel/exchange_group.hpp"

namespace copepod::fluid {

template <class T>
Kernels<T> avx2_kernels() {
#ifdef __AVX2__
  if (__builtin_cpu_supports("avx2")) return kernels_for<VectorsOf<32>, T>("avx2");
#endif
  return {};
}

template Kernels<float> avx2_kernels<float>();
template Kernels<double> avx2_kernels<double>();

}  // namespace copepod::fluid
