#include "conversion/vector_passes_loops.hpp"

namespace copepod::conversion {

const VectorPasses* vector_passes_avx2() {
#ifdef __AVX2__
  static constexpr VectorPasses passes{hash, copy_finite};
  return __builtin_cpu_supports("avx2") ? &passes : nullptr;
#else
  return nullptr;  // not built for x86-64
#endif
}

}  // namespace copepod::conversion
