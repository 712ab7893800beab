#include "lattice_boltzmann/kernel/exchange_group.hpp"

namespace copepod::fluid {

template <class T>
Kernels<T> avx512_kernels() {
#ifdef __AVX512VL__
  if (__builtin_cpu_supports("avx512vl")) return kernels_for<VectorsOf<64>, T>("avx512");
#endif
  return {};
}

template Kernels<float> avx512_kernels<float>();
template Kernels<double> avx512_kernels<double>();

}  // namespace copepod::fluid
