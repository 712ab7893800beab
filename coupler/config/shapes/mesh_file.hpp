#pragma once

#include <string>
#include <string_view>

#include "contract/shape.hpp"

namespace copepod::coupler {

/// Reads a closed surface from the bytes of an STL file (of text or binary), an OBJ or a PLY file. Corners at the same
/// place become one vertex, triangles without two different corners are left out, polygons are cut into triangles.
/// A surface whose front is inside is turned round.
/// @param unit_m  of the lengths in the file
/// @throws CaseError saying what is wrong, and where: no such file; a surface that is not closed, or not oriented; one
/// that intersects itself
TriangleMesh read_mesh(std::string_view bytes, double unit_m);

/// The mesh as an OBJ file whose unit is the metre; read again it has the same bits.
std::string to_obj(const TriangleMesh& mesh);

}  // namespace copepod::coupler
