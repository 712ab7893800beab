#include "config/shapes/mesh_file.hpp"

#include <chrono>
#include <cstring>
#include <limits>

#include <gtest/gtest.h>

#include "contract/errors.hpp"
#include "geometry/shapes/solid.hpp"

namespace copepod::coupler {
namespace {

const std::string tetrahedron_obj =
    "# a comment\nv 1 1 1\nv -1 -1 1\nv -1 1 -1\nv 1 -1 -1\nf 1/1/1 3//2 2\nf 1 2 4\nf 1 4 3\nf -3 -2 -1\n";

constexpr int corner_numbers[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
constexpr double corner_places[4][3] = {{1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}};

std::string tetrahedron_stl_text() {
  std::string text = "solid tetrahedron\n";
  for (const auto& corners : corner_numbers) {
    text += "facet normal 0 0 0\n outer loop\n";
    for (const int corner : corners)
      text += "  vertex " + std::to_string(corner_places[corner][0]) + " " + std::to_string(corner_places[corner][1]) +
              " " + std::to_string(corner_places[corner][2]) + "\n";
    text += " endloop\nendfacet\n";
  }
  return text + "endsolid tetrahedron\n";
}

template <class T>
void append_bytes(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string tetrahedron_stl(std::uint32_t claimed = 4) {
  std::string bytes = "solid but in spite of this word it is binary  " + std::string(34, ' ');
  append_bytes(bytes, claimed);
  for (const auto& corners : corner_numbers) {
    for (int i = 0; i < 3; ++i) append_bytes(bytes, 0.0F);
    for (const int corner : corners)
      for (const double x : corner_places[corner]) append_bytes(bytes, static_cast<float>(x));
    append_bytes(bytes, std::uint16_t{0});
  }
  return bytes;
}

std::string tetrahedron_ply(bool binary) {
  std::string bytes = std::string("ply\nformat ") + (binary ? "binary_little_endian" : "ascii") +
                      " 1.0\nelement vertex 4\nproperty float x\nproperty double y\nproperty float z\n"
                      "property uchar red\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n";
  for (const auto& place : corner_places) {
    if (binary) {
      append_bytes(bytes, static_cast<float>(place[0]));
      append_bytes(bytes, place[1]);
      append_bytes(bytes, static_cast<float>(place[2]));
      append_bytes(bytes, std::uint8_t{7});
    } else {
      for (const double x : place) bytes += std::to_string(x) + " ";
      bytes += "7\n";
    }
  }
  for (const auto& corners : corner_numbers) {
    if (binary)
      append_bytes(bytes, std::uint8_t{3});
    else
      bytes += "3 ";
    for (const int corner : corners) {
      if (binary)
        append_bytes(bytes, corner);
      else
        bytes += std::to_string(corner) + " ";
    }
    if (!binary) bytes += "\n";
  }
  return bytes;
}

TEST(MeshFile, IsTheSameInEveryFormat) {
  for (const std::string& bytes :
       {tetrahedron_obj, tetrahedron_stl_text(), tetrahedron_stl(), tetrahedron_ply(false), tetrahedron_ply(true)}) {
    const TriangleMesh mesh = read_mesh(bytes, 2.0);
    EXPECT_EQ(mesh.vertices_m.cols(), 4);
    EXPECT_EQ(mesh.triangles.cols(), 4);
    EXPECT_NEAR(moments_by_surface(mesh).volume, 8.0 * 8.0 / 3.0, 1e-12);
    EXPECT_NEAR(mesh.bounding_radius_m, 2.0 * std::sqrt(3.0), 1e-12);
  }
}

TEST(MeshFile, OfAResolvedCaseHasTheSameBits) {
  const TriangleMesh mesh = read_mesh(tetrahedron_obj, 1.0 / 3e6);
  EXPECT_EQ(read_mesh(to_obj(mesh), 1.0), mesh);
}

TEST(MeshFile, IsTurnedRoundWhereItsFrontIsInside) {
  std::string inside_out = tetrahedron_obj;
  for (const auto& [from, to] :
       {std::pair{"1/1/1 3//2 2", "1 2 3"}, {"f 1 2 4", "f 1 4 2"}, {"f 1 4 3", "f 1 3 4"}, {"-3 -2 -1", "-3 -1 -2"}})
    inside_out.replace(inside_out.find(from), std::strlen(from), to);
  EXPECT_NEAR(moments_by_surface(read_mesh(inside_out, 1.0)).volume, 8.0 / 3.0, 1e-12);
}

TEST(MeshFile, HasPolygonsCutIntoTriangles) {
  const TriangleMesh box = read_mesh(
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
      "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n",
      1.0);
  EXPECT_EQ(box.triangles.cols(), 12);
  EXPECT_NEAR(moments_by_surface(box).volume, 1.0, 1e-14);
}

/// A second tetrahedron after the first one, of `size` times its edges, moved by `x` along x.
std::string two_tetrahedra(double size, double x, bool inside_out) {
  std::string text = tetrahedron_obj;
  for (const auto& place : corner_places)
    text += "v " + std::to_string(size * place[0] + x) + " " + std::to_string(size * place[1]) + " " +
            std::to_string(size * place[2]) + "\n";
  for (const auto& corners : corner_numbers)
    text += "f " + std::to_string(5 + corners[0]) + " " + std::to_string(5 + corners[inside_out ? 2 : 1]) + " " +
            std::to_string(5 + corners[inside_out ? 1 : 2]) + "\n";
  return text;
}

TEST(MeshFile, MayHaveAHoleInsideOrPartsApart) {
  EXPECT_NEAR(moments_by_surface(read_mesh(two_tetrahedra(0.5, 0.0, true), 1.0)).volume, 8.0 / 3.0 * 0.875, 1e-6);
  EXPECT_NEAR(moments_by_surface(read_mesh(two_tetrahedra(0.5, 4.0, false), 1.0)).volume, 8.0 / 3.0 * 1.125, 1e-6);
}

struct RefusedFile {
  std::string bytes;
  const char* words;
};

TEST(MeshFile, IsRefusedWithTheReasonWhereItCannotBeUsed) {
  const std::string without_last = tetrahedron_obj.substr(0, tetrahedron_obj.find("f -3"));
  const std::string in_one_place = [] {
    std::string bytes(80, ' ');
    constexpr std::uint32_t triangles = 333'334;  // of a million vertices
    append_bytes(bytes, triangles);
    return bytes + std::string(50 * std::size_t{triangles}, '\0');
  }();
  const std::vector<RefusedFile> all{
      {"", "it is empty"},
      {"<!DOCTYPE html><html>v 1</html>", "not an STL, OBJ or PLY file"},
      {tetrahedron_stl(4'000'000'000U), "not an STL, OBJ or PLY file, or it is cut short"},
      {tetrahedron_stl().substr(0, 200), "not an STL, OBJ or PLY file, or it is cut short"},
      {tetrahedron_ply(true).substr(0, 260), "it ends before"},
      {"ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\nend_header\n1 2 3\n", "it ends before"},
      {"ply\nformat binary_big_endian 1.0\nelement vertex 1\nend_header\n", "binary_big_endian"},
      {"ply\nelement vertex 3", "header has no end"},
      {in_one_place, "it has no triangles"},
      {"v 1 2 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "not finite"},
      {"v 1 2 inf\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "not finite"},
      {"v 1 2 x\n", "a coordinate is not a number: 'x'"},
      {"v 1 2 3\nf 1 2 3\n", "a face has a vertex that there is not, number 1 of 1"},
      {"v 1 2 3\nf 0 0 0\n", "a face has a vertex that there is not, number -1 of 1"},
      {without_last, "it is not closed: 3 open edges, the first at (-1, -1, 1) m"},
      {tetrahedron_obj + "f 2 3 4\n", "two triangles have the same edge in the same direction"},
      {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3 2 1\n", "it encloses no volume"},
      {two_tetrahedra(0.5, 0.0, false), "it intersects itself"},
      {two_tetrahedra(1.0, 0.7, false), "it intersects itself"},
      {two_tetrahedra(0.5, 4.0, true), "it intersects itself"},
      {"solid x\nfacet\nvertex 1 2 3\nvertex 1 2\n", "is not a number"},
      {"solid x\nfacet\nvertex 1 2 3\n", "it ends within a facet"},
  };
  for (const auto& [bytes, words] : all) {
    const auto start = std::chrono::steady_clock::now();
    try {
      read_mesh(bytes, 1.0);
      ADD_FAILURE() << "accepted: " << words;
    } catch (const CaseError& error) {
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what() << "\nwanted: " << words;
    }
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5)) << words;
  }
}

}  // namespace
}  // namespace copepod::coupler
