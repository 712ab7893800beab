#include "lattice_boltzmann/kernel/exchange_group.hpp"

namespace copepod::fluid {

namespace {
struct [[maybe_unused]] Avx512 {
  static constexpr int vector_bytes = 64;
};
}  // namespace

template <class T>
Kernels<T> avx512_kernels() {
#ifdef __AVX512VL__
  if (__builtin_cpu_supports("avx512vl")) return kernels_for<Avx512, T>("avx512");
#endif
  return {};
}

template Kernels<float> avx512_kernels<float>();
template Kernels<double> avx512_kernels<double>();

}  // namespace copepod::fluid
