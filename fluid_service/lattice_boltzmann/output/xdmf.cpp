#include "lattice_boltzmann/output/xdmf.hpp"

#include <algorithm>
#include <cstdlib>
#include <iomanip>
#include <limits>
#include <sstream>

namespace copepod::fluid {

namespace {

const std::string snapshot_prefix = "step_";

/// Three numbers in file order: z, y, x.
std::string in_words(const Cell& cell) {
  return std::to_string(cell[2]) + " " + std::to_string(cell[1]) + " " + std::to_string(cell[0]);
}

struct Field {
  const char* name;
  const char* kind;
  const char* number;
  const char* shape_end;
};

constexpr Field fields[] = {{"density_kg_per_m3", "Scalar", "NumberType='Float' Precision='8'", ""},
                            {"pressure_Pa", "Scalar", "NumberType='Float' Precision='8'", ""},
                            {"velocity_m_per_s", "Vector", "NumberType='Float' Precision='8'", " 3"},
                            {"vorticity_per_s", "Vector", "NumberType='Float' Precision='8'", " 3"},
                            {"body", "Scalar", "NumberType='Int' Precision='4'", ""}};

void add_grid(std::ostream& text, const XdmfDescription& d, const XdmfGrid& grid, const std::string& indent) {
  const Cell cells = {grid.box.extent(0), grid.box.extent(1), grid.box.extent(2)};
  const auto origin_m = [&](int axis) { return static_cast<double>(grid.box.low[axis]) * d.cell_size_m; };
  text << indent << "<Grid Name='" << grid.group << "' GridType='Uniform'>\n";
  if (const std::int64_t step = step_of_group(grid.group); step >= 0)
    text << indent << "  <Time Value='" << static_cast<double>(step) * d.step_s << "'/>\n";
  text << indent << "  <Topology TopologyType='3DCoRectMesh' Dimensions='"
       << in_words({cells[0] + 1, cells[1] + 1, cells[2] + 1}) << "'/>\n"
       << indent << "  <Geometry GeometryType='ORIGIN_DXDYDZ'>\n"
       << indent << "    <DataItem Dimensions='3' NumberType='Float' Precision='8' Format='XML'>" << origin_m(2) << " "
       << origin_m(1) << " " << origin_m(0) << "</DataItem>\n"
       << indent << "    <DataItem Dimensions='3' NumberType='Float' Precision='8' Format='XML'>" << d.cell_size_m
       << " " << d.cell_size_m << " " << d.cell_size_m << "</DataItem>\n"
       << indent << "  </Geometry>\n";
  for (const Field& field : fields) {
    if (std::ranges::find(grid.datasets, field.name) == grid.datasets.end()) continue;
    text << indent << "  <Attribute Name='" << field.name << "' AttributeType='" << field.kind << "' Center='Cell'>\n"
         << indent << "    <DataItem Dimensions='" << in_words(cells) << field.shape_end << "' " << field.number
         << " Format='HDF'>" << grid.file << ":/" << grid.group << "/" << field.name << "</DataItem>\n"
         << indent << "  </Attribute>\n";
  }
  text << indent << "</Grid>\n";
}

}  // namespace

std::int64_t step_of_group(const std::string& group) {
  if (!group.starts_with(snapshot_prefix)) return -1;
  return std::strtoll(group.c_str() + snapshot_prefix.size(), nullptr, 10);
}

std::string group_of_step(std::int64_t step) {
  std::ostringstream name;
  name << snapshot_prefix << std::setw(9) << std::setfill('0') << step;
  return name.str();
}

std::string xdmf_text(const XdmfDescription& description) {
  std::ostringstream text;
  text << std::setprecision(std::numeric_limits<double>::max_digits10);
  text << "<?xml version='1.0' encoding='utf-8'?>\n<Xdmf Version='2.0'>\n  <Domain>\n";
  const bool has_times = !description.grids.empty() && step_of_group(description.grids.front().group) >= 0;
  if (has_times) text << "    <Grid Name='snapshots' GridType='Collection' CollectionType='Temporal'>\n";
  for (const XdmfGrid& grid : description.grids) add_grid(text, description, grid, has_times ? "      " : "    ");
  if (has_times) text << "    </Grid>\n";
  text << "  </Domain>\n</Xdmf>\n";
  return text.str();
}

}  // namespace copepod::fluid
