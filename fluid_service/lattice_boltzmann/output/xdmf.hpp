#pragma once

#include <string>
#include <vector>

#include "ranks/box.hpp"

namespace copepod::fluid {

/// One group of fields.h5 as ParaView sees it.
struct XdmfGrid {
  std::string group;  ///< "step_000001000" or "mean"
  std::string file;   ///< that holds it; from the folder of the XDMF file
  Box box;            ///< its cells, in the whole domain
  std::vector<std::string> datasets;

  bool operator==(const XdmfGrid&) const = default;
};

/// What an XDMF file describes to ParaView: snapshots, or the mean.
struct XdmfDescription {
  double cell_size_m = 0.0;
  double step_s = 0.0;
  std::vector<XdmfGrid> grids;
};

/// XDMF 2 text: snapshots as a temporal collection, the mean as one grid without a time. Fields belong to cells.
std::string xdmf_text(const XdmfDescription& description);

/// Step of a snapshot group, −1 for other groups.
std::int64_t step_of_group(const std::string& group);
std::string group_of_step(std::int64_t step);

}  // namespace copepod::fluid
