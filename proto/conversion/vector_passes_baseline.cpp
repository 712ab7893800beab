#include "conversion/vector_passes_loops.hpp"

namespace copepod::conversion {

const VectorPasses kBaselinePasses{hash, copy_finite};

const VectorPasses& vector_passes() {
  static const VectorPasses* const avx2 = vector_passes_avx2();
  return avx2 != nullptr ? *avx2 : kBaselinePasses;
}

}  // namespace copepod::conversion
