// Fuzz target: a file with the mesh of a body.

#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "config/shapes/mesh_file.hpp"
#include "contract/errors.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace copepod;
  TriangleMesh mesh;
  try {
    mesh = coupler::read_mesh({reinterpret_cast<const char*>(bytes), size}, 1.0);
  } catch (const CaseError&) {
    return 0;
  }
  // What was accepted is accepted again in a resolved case, and is the same.
  if (!(coupler::read_mesh(coupler::to_obj(mesh), 1.0) == mesh)) std::abort();
  return 0;
}
