#include "lattice_boltzmann/output/xdmf.hpp"

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
                            {"velocity_m_per_s", "Vector", "NumberType='Float' Precision='8'", " 3"},
                            {"body", "Scalar", "NumberType='Int' Precision='4'", ""}};

void add_grid(std::ostream& text, const XdmfDescription& d, const std::string& group, const std::string& indent) {
  const Cell nodes = {d.cells[0] + 1, d.cells[1] + 1, d.cells[2] + 1};
  text << indent << "<Grid Name='" << group << "' GridType='Uniform'>\n";
  if (const std::int64_t step = step_of_group(group); step >= 0)
    text << indent << "  <Time Value='" << static_cast<double>(step) * d.step_s << "'/>\n";
  text << indent << "  <Topology TopologyType='3DCoRectMesh' Dimensions='" << in_words(nodes) << "'/>\n"
       << indent << "  <Geometry GeometryType='ORIGIN_DXDYDZ'>\n"
       << indent
       << "    <DataItem Dimensions='3' NumberType='Float' Precision='8' Format='XML'>0 0 "
          "0</DataItem>\n"
       << indent << "    <DataItem Dimensions='3' NumberType='Float' Precision='8' Format='XML'>" << d.cell_size_m
       << " " << d.cell_size_m << " " << d.cell_size_m << "</DataItem>\n"
       << indent << "  </Geometry>\n";
  for (const Field& field : fields)
    text << indent << "  <Attribute Name='" << field.name << "' AttributeType='" << field.kind << "' Center='Cell'>\n"
         << indent << "    <DataItem Dimensions='" << in_words(d.cells) << field.shape_end << "' " << field.number
         << " Format='HDF'>" << d.data_file << ":/" << group << "/" << field.name << "</DataItem>\n"
         << indent << "  </Attribute>\n";
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
  bool in_collection = false;
  for (const std::string& group : description.groups) {
    if (step_of_group(group) < 0) continue;
    if (!in_collection) text << "    <Grid Name='snapshots' GridType='Collection' CollectionType='Temporal'>\n";
    in_collection = true;
    add_grid(text, description, group, "      ");
  }
  if (in_collection) text << "    </Grid>\n";
  for (const std::string& group : description.groups)
    if (step_of_group(group) < 0) add_grid(text, description, group, "    ");
  text << "  </Domain>\n</Xdmf>\n";
  return text.str();
}

}  // namespace copepod::fluid
