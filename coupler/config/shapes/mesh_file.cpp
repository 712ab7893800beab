#include "config/shapes/mesh_file.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <unordered_map>
#include <vector>

#include "config/yaml/document.hpp"
#include "contract/errors.hpp"
#include "contract/words.hpp"
#include "geometry/shapes/solid.hpp"

namespace copepod::coupler {

namespace {

using Vertex = std::array<double, 3>;
using Triangle = std::array<std::int32_t, 3>;

[[noreturn]] void fail(const std::string& problem) { throw CaseError(problem); }

/// Vertices and triangles as a file has them.
struct Soup {
  std::vector<Vertex> vertices;
  std::vector<Triangle> triangles;

  /// A fan around the first corner.
  void add_polygon(const std::vector<std::int64_t>& corners) {
    for (const std::int64_t corner : corners)
      if (corner < 0 || corner >= static_cast<std::int64_t>(vertices.size()))
        fail("a face has a vertex that there is not, number " + std::to_string(corner) + " of " +
             std::to_string(vertices.size()));
    for (std::size_t i = 2; i < corners.size(); ++i)
      triangles.push_back({static_cast<std::int32_t>(corners[0]), static_cast<std::int32_t>(corners[i - 1]),
                           static_cast<std::int32_t>(corners[i])});
  }
};

/// Words of a text, line by line.
class Words {
 public:
  explicit Words(std::string_view text) : rest_(text) {}

  /// The next word; empty at the end of the text.
  std::string_view next() {
    skip(" \t\r\n");
    return take(" \t\r\n");
  }
  /// The next word of the line; empty at its end.
  std::string_view next_in_line() {
    skip(" \t\r");
    return take(" \t\r\n");
  }
  void skip_line() { rest_.remove_prefix(std::min(rest_.size(), rest_.find('\n') + std::size_t{1})); }
  [[nodiscard]] bool at_end() const { return rest_.empty(); }
  [[nodiscard]] std::string_view rest() const { return rest_; }

 private:
  void skip(const char* characters) {
    rest_.remove_prefix(std::min(rest_.size(), rest_.find_first_not_of(characters)));
  }
  std::string_view take(const char* until) {
    const std::string_view word = rest_.substr(0, rest_.find_first_of(until));
    rest_.remove_prefix(word.size());
    return word;
  }

  std::string_view rest_;
};

template <class T>
T parsed(std::string_view word, const char* what) {
  T value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end == word.data())
    fail(std::string(what) + " is not a number: '" + std::string(word.substr(0, 40)) + "'");
  return value;
}

template <class T>
T little_endian(std::string_view bytes, std::size_t at) {
  T value{};
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

Soup read_binary_stl(std::string_view bytes) {
  Soup soup;
  const auto count = (bytes.size() - 84) / 50;
  for (std::size_t t = 0; t < count; ++t) {
    const auto first = static_cast<std::int32_t>(soup.vertices.size());
    for (std::size_t corner = 0; corner < 3; ++corner) {
      Vertex& vertex = soup.vertices.emplace_back();
      for (std::size_t axis = 0; axis < 3; ++axis)
        vertex[axis] = static_cast<double>(little_endian<float>(bytes, 84 + 50 * t + 12 + 12 * corner + 4 * axis));
    }
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  return soup;
}

Soup read_text_stl(std::string_view bytes) {
  Soup soup;
  Words words(bytes);
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    if (word != "vertex") continue;
    Vertex& vertex = soup.vertices.emplace_back();
    for (double& x : vertex) x = parsed<double>(words.next(), "a coordinate");
    const auto count = static_cast<std::int32_t>(soup.vertices.size());
    if (count % 3 == 0) soup.triangles.push_back({count - 3, count - 2, count - 1});
  }
  if (soup.vertices.size() % 3 != 0) fail("it ends within a facet");
  return soup;
}

Soup read_obj(std::string_view bytes) {
  Soup soup;
  std::vector<std::int64_t> corners;
  for (Words words(bytes); !words.at_end(); words.skip_line()) {
    const std::string_view kind = words.next_in_line();
    if (kind == "v") {
      Vertex& vertex = soup.vertices.emplace_back();
      for (double& x : vertex) x = parsed<double>(words.next_in_line(), "a coordinate");
    } else if (kind == "f") {
      corners.clear();
      for (std::string_view word = words.next_in_line(); !word.empty(); word = words.next_in_line()) {
        const auto number = parsed<std::int64_t>(word, "a corner of a face");  // before a slash, if there is one
        corners.push_back(number < 0 ? static_cast<std::int64_t>(soup.vertices.size()) + number : number - 1);
      }
      soup.add_polygon(corners);
    }
  }
  return soup;
}

/// A PLY file as its header describes it, as far as it matters: vertices and faces, in this order.
class PlyFile {
 public:
  explicit PlyFile(std::string_view bytes) : words_(bytes) {
    while (words_.next() != "end_header") {
      if (words_.at_end()) fail("its header has no end");
    }
    const std::string_view header = bytes.substr(0, bytes.size() - words_.rest().size());
    words_.skip_line();
    for (Words words(header); !words.at_end(); words.skip_line()) read_line(words);
    data_ = words_.rest();
  }

  Soup read() {
    Soup soup;
    for (const Element& element : elements_) {
      // Each entry takes a byte at least: more than the file has cannot be there.
      if (element.count > data_.size()) fail("it ends before its " + element.name + " entries do");
      for (std::size_t i = 0; i < element.count; ++i) read_entry(element, soup);
    }
    return soup;
  }

 private:
  struct Property {
    std::string name, type, count_type;  ///< count_type of a list only
  };
  struct Element {
    std::string name;
    std::size_t count = 0;
    std::vector<Property> properties;
  };

  void read_line(Words& words) {
    const std::string_view kind = words.next_in_line();
    if (kind == "format") {
      const std::string_view format = words.next_in_line();
      if (format != "ascii" && format != "binary_little_endian")
        fail("its format is " + std::string(format) + " (ascii and binary_little_endian can be read)");
      is_text_ = format == "ascii";
    } else if (kind == "element") {
      Element& element = elements_.emplace_back();
      element.name = words.next_in_line();
      element.count = parsed<std::size_t>(words.next_in_line(), "the number of entries");
    } else if (kind == "property" && !elements_.empty()) {
      Property& property = elements_.back().properties.emplace_back();
      property.type = words.next_in_line();
      if (property.type == "list") {
        property.count_type = words.next_in_line();
        property.type = words.next_in_line();
      }
      property.name = words.next_in_line();
    }
  }

  double number(const std::string& type) {
    if (is_text_) return parsed<double>(words_.next(), "an entry");
    const auto take = [&]<class T>(T) {
      if (data_.size() < sizeof(T)) fail("it ends before its entries do");
      const T value = little_endian<T>(data_, 0);
      data_.remove_prefix(sizeof(T));
      return static_cast<double>(value);
    };
    if (type == "char" || type == "int8") return take(std::int8_t{});
    if (type == "uchar" || type == "uint8") return take(std::uint8_t{});
    if (type == "short" || type == "int16") return take(std::int16_t{});
    if (type == "ushort" || type == "uint16") return take(std::uint16_t{});
    if (type == "int" || type == "int32") return take(std::int32_t{});
    if (type == "uint" || type == "uint32") return take(std::uint32_t{});
    if (type == "float" || type == "float32") return take(float{});
    if (type == "double" || type == "float64") return take(double{});
    fail("a property has the unknown type '" + type.substr(0, 40) + "'");
  }

  void read_entry(const Element& element, Soup& soup) {
    Vertex vertex{};
    for (const auto& [name, type, count_type] : element.properties) {
      if (count_type.empty()) {
        const double value = number(type);
        for (std::size_t axis = 0; axis < 3; ++axis)
          if (name == std::string(1, "xyz"[axis])) vertex[axis] = value;
        continue;
      }
      std::vector<std::int64_t> list;
      const double count = number(count_type);
      if (!(count >= 0.0 && count < 1e6)) fail("a list of " + rounded_text(count) + " entries");
      for (int i = 0; i < static_cast<int>(count); ++i) {
        const double value = number(type);
        list.push_back(std::abs(value) < 1e15 ? static_cast<std::int64_t>(value) : -1);
      }
      if (element.name == "face" && name.starts_with("vertex_ind")) soup.add_polygon(list);
    }
    if (element.name == "vertex") soup.vertices.push_back(vertex);
  }

  Words words_;
  bool is_text_ = true;
  std::string_view data_;  ///< what is left of a binary file
  std::vector<Element> elements_;
};

Soup read_soup(std::string_view bytes) {
  static_assert(std::endian::native == std::endian::little);
  if (bytes.empty()) fail("it is empty");
  // Some binary files begin with "solid" too.
  if (bytes.size() >= 84 && bytes.size() == 84 + 50 * std::uint64_t{little_endian<std::uint32_t>(bytes, 80)})
    return read_binary_stl(bytes);
  if (bytes.starts_with("ply\n") || bytes.starts_with("ply\r")) return PlyFile(bytes).read();
  const std::string_view start = bytes.substr(0, 4096);
  if (start.starts_with("solid") && start.find("facet") != std::string_view::npos) return read_text_stl(bytes);
  const bool is_obj = bytes.starts_with("v ") || start.find("\nv ") != std::string_view::npos;
  if (is_obj && start.find('\0') == std::string_view::npos) return read_obj(bytes);
  fail("it is not an STL, OBJ or PLY file, or it is cut short");
}

/// One vertex for all corners at the same place.
TriangleMesh welded(const Soup& soup, double unit_m) {
  struct Hash {
    std::size_t operator()(const Vertex& v) const {
      std::size_t hash = 0;
      for (const double x : v) hash = hash * 1099511628211U ^ std::hash<double>()(x);
      return hash;
    }
  };
  std::unordered_map<Vertex, std::int32_t, Hash> numbers;
  std::vector<std::int32_t> number_of;
  std::vector<Vertex> vertices;
  for (const Vertex& found : soup.vertices) {
    Vertex vertex{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      vertex[axis] = unit_m * found[axis] + 0.0;  // no −0
      if (!(std::abs(vertex[axis]) < 1e100)) fail("a vertex is not finite");
    }
    const auto [place, is_new] = numbers.try_emplace(vertex, static_cast<std::int32_t>(vertices.size()));
    if (is_new) vertices.push_back(vertex);
    number_of.push_back(place->second);
  }
  std::vector<Triangle> triangles;
  for (const Triangle& found : soup.triangles) {
    Triangle corners{};
    for (std::size_t i = 0; i < 3; ++i) corners[i] = number_of[found[i]];
    if (corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0]) triangles.push_back(corners);
  }
  if (triangles.empty()) fail("it has no triangles");
  Eigen::Matrix3Xd columns(3, vertices.size());
  TriangleMesh::Triangles corners(3, triangles.size());
  std::memcpy(columns.data(), vertices.data(), vertices.size() * sizeof(Vertex));
  std::memcpy(corners.data(), triangles.data(), triangles.size() * sizeof(Triangle));
  return {std::move(columns), std::move(corners)};
}

std::string text_of(const Eigen::Vector3d& place_m) {
  return "(" + listed({rounded_text(place_m[0]), rounded_text(place_m[1]), rounded_text(place_m[2])}) + ") m";
}

/// Each edge must belong to two triangles, once in either direction.
void check_closed(const TriangleMesh& mesh) {
  std::vector<std::pair<std::int32_t, std::int32_t>> edges;
  for (const auto& corners : mesh.triangles.colwise())
    for (int i = 0; i < 3; ++i) edges.emplace_back(corners[i], corners[(i + 1) % 3]);
  std::ranges::sort(edges);
  if (const auto twice = std::ranges::adjacent_find(edges); twice != edges.end())
    fail("two triangles have the same edge in the same direction, at " + text_of(mesh.vertices_m.col(twice->first)) +
         " (one of them is turned round, or more than two meet there). Make the normals agree, or the parts separate");
  std::size_t open = 0;
  std::int32_t first = -1;
  for (const auto& [a, b] : edges) {
    if (std::ranges::binary_search(edges, std::pair{b, a})) continue;
    if (open++ == 0) first = a;
  }
  if (open > 0)
    fail("it is not closed: " + std::to_string(open) + " open edges, the first at " +
         text_of(mesh.vertices_m.col(first)) + ". Close the holes");
}

}  // namespace

TriangleMesh read_mesh(std::string_view bytes, double unit_m) {
  TriangleMesh mesh = welded(read_soup(bytes), unit_m);
  check_closed(mesh);
  double volume = moments_by_surface(mesh).volume;
  if (volume < 0.0) {
    mesh.triangles.row(1).swap(mesh.triangles.row(2));
    volume = -volume;
  }
  constexpr double rounding = 1e-12;
  if (!(volume > rounding * std::pow(mesh.bounding_radius_m, 3))) fail("it encloses no volume");
  if (const auto place_m = enclosed_twice(mesh))
    fail("it intersects itself: " + text_of(*place_m) +
         " is enclosed twice, or by a part whose front is inside. Unite its parts, or make the normals agree");
  return mesh;
}

std::string to_obj(const TriangleMesh& mesh) {
  std::string text;
  for (const auto& vertex : mesh.vertices_m.colwise()) {
    text += 'v';
    for (const double x : vertex) text += ' ' + shortest_text(x);
    text += '\n';
  }
  for (const auto& corners : mesh.triangles.colwise()) {
    text += 'f';
    for (const std::int32_t corner : corners) text += ' ' + std::to_string(corner + 1);
    text += '\n';
  }
  return text;
}

}  // namespace copepod::coupler
