#pragma once

#include <string>
#include <vector>

#include "ranks/box.hpp"

namespace copepod::fluid {

/// What fields.xdmf describes to ParaView: the contents of fields.h5.
struct XdmfDescription {
  Cell cells{};  ///< of the whole domain
  double cell_size_m = 0.0;
  double step_s = 0.0;
  std::string data_file;            ///< name of the HDF5 file, in the same folder
  std::vector<std::string> groups;  ///< in the file: "step_000001000", …, and perhaps "mean"
};

/// XDMF 2 text: a temporal collection "snapshots" and a grid "mean", each where there is any. Fields belong
/// to cells.
std::string xdmf_text(const XdmfDescription& description);

/// Step of a snapshot group, −1 for other groups.
std::int64_t step_of_group(const std::string& group);
std::string group_of_step(std::int64_t step);

}  // namespace copepod::fluid
