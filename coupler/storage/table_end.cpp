#include "storage/table_end.hpp"

#include <optional>

#include "storage/csv_file.hpp"
#include "storage/hdf5_table.hpp"

namespace copepod::coupler {

std::string find_damage(const std::string& path, const TableEnd& end) {
  const std::optional<Checksum> checksum =
      path.ends_with(hdf5_suffix) ? Hdf5Table::checksum_of_start(path, end) : CsvFile::checksum_of_start(path, end);
  if (!checksum) return path + " lacks rows that it had";
  return checksum->value() == end.checksum ? "" : path + " has changed";
}

}  // namespace copepod::coupler
