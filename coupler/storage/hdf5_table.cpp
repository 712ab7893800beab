#include "storage/hdf5_table.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <limits>
#include <unistd.h>
#include <utility>

#include "contract/errors.hpp"

namespace copepod::coupler {
namespace {

static_assert(std::endian::native == std::endian::little, "the file announces little-endian numbers");

constexpr std::uint64_t undefined = std::numeric_limits<std::uint64_t>::max();  ///< HDF5's undefined address
constexpr std::uint64_t head_bytes = 4096;                     ///< a page: a write of the head is seen whole
constexpr std::uint64_t layout_place = 3584;                   ///< in the head, of what `stored` lists
constexpr std::uint64_t chunk_bytes = std::uint64_t{1} << 16;  ///< about so much of a vector quantity, or one sample
constexpr std::uint64_t room_bytes = std::uint64_t{1} << 22;   ///< about so much is added between two flushes
constexpr std::uint64_t count_place = 6;                       ///< of the number of entries in a node

/// Bytes of an HDF5 structure [HDF5 File Format Specification, version 3.0].
class Bytes {
 public:
  template <typename Number>
  Bytes& add(Number number) {
    text_.append(reinterpret_cast<const char*>(&number), sizeof number);
    return *this;
  }
  Bytes& add8(std::uint64_t number) { return add(static_cast<std::uint8_t>(number)); }
  Bytes& add16(std::uint64_t number) { return add(static_cast<std::uint16_t>(number)); }
  Bytes& add32(std::uint64_t number) { return add(static_cast<std::uint32_t>(number)); }
  Bytes& add64(std::uint64_t number) { return add(number); }
  Bytes& add(const std::string& text) {
    text_ += text;
    return *this;
  }
  Bytes& pad_to(std::uint64_t size) {
    text_.resize(size, '\0');
    return *this;
  }
  [[nodiscard]] const std::string& text() const { return text_; }
  [[nodiscard]] std::uint64_t size() const { return text_.size(); }

 private:
  std::string text_;
};

/// An object header, version 1 (IV.A.1.a), of messages (type, content).
std::string object_header(const std::vector<std::pair<std::uint64_t, Bytes>>& messages) {
  Bytes content;
  for (const auto& [type, message] : messages) {
    const std::uint64_t padded = (message.size() + 7) / 8 * 8;
    const std::uint64_t end = content.size() + 8 + padded;
    content.add16(type).add16(padded).add32(0).add(message.text()).pad_to(end);
  }
  Bytes header;
  header.add8(1).add8(0).add16(messages.size()).add32(1).add32(content.size()).add32(0);
  return header.add(content.text()).text();
}

/// IV.A.2.b. @param most  of the first dimension; 0: fixed
Bytes dataspace(const std::vector<std::uint64_t>& shape, std::uint64_t most) {
  Bytes message;
  message.add8(1).add8(shape.size()).add8(most > 0 ? 1 : 0).pad_to(8);
  for (const std::uint64_t size : shape) message.add64(size);
  if (most == 0) return message;
  message.add64(most);
  for (std::size_t axis = 1; axis < shape.size(); ++axis) message.add64(shape[axis]);
  return message;
}

/// IV.A.2.d: class and version, bit field, size, properties.
Bytes number_type(Hdf5Column::Kind kind) {
  Bytes message;
  if (kind == Hdf5Column::Kind::whole_number) return message.add32(0x00'00'08'10).add32(8).add16(0).add16(64);
  message.add32(0x00'3f'20'11).add32(8).add16(0).add16(64);
  return message.add8(52).add8(11).add8(0).add8(52).add32(1023);  // place and size of exponent and mantissa, bias
}
Bytes text_type(std::uint64_t bytes) { return Bytes().add32(0x00'00'11'13).add32(bytes); }  // UTF-8, padded with zeros

/// IV.A.2.f: space is there when it is written, and 0 where there is none.
Bytes fill_value() { return Bytes().add8(2).add8(3).add8(2).add8(0); }

std::string dataset(const Bytes& space, const Bytes& type, const Bytes& layout) {
  return object_header({{0x0001, space}, {0x0003, type}, {0x0005, fill_value()}, {0x0008, layout}});
}

/// IV.A.2.g: a link to the object at an address.
Bytes link(const std::string& name, std::uint64_t address) {
  return Bytes().add8(1).add8(0).add8(name.size()).add(name).add64(address);
}

/// Root group: link info, group info and links; IV.A.2.c, IV.A.2.k.
std::string group(const std::vector<std::pair<std::string, std::uint64_t>>& links) {
  std::vector<std::pair<std::uint64_t, Bytes>> messages{{0x0002, Bytes().add16(0).add64(undefined).add64(undefined)},
                                                        {0x000a, Bytes().add16(0)}};
  for (const auto& [name, address] : links) messages.emplace_back(0x0006, link(name, address));
  return object_header(messages);
}

/// Superblock, version 0 (II.A), whose root group lies behind it.
std::string superblock(std::uint64_t end_of_file) {
  constexpr std::uint64_t size = 96;
  Bytes bytes;
  bytes.add(std::string("\x89HDF\r\n\x1a\n")).add32(0).add8(0).add8(8).add8(8).add8(0);
  bytes.add16(4).add16(16).add32(0).add64(0).add64(undefined).add64(end_of_file).add64(undefined);
  return bytes.add64(0).add64(size).pad_to(size).text();
}

std::uint64_t key_bytes(const Hdf5Column& column) { return 8 + 8 * (column.rank() + 1); }

std::uint64_t node_bytes(const Hdf5Column& column) {
  return 24 + Hdf5Layout::fan_out * (key_bytes(column) + 8) + key_bytes(column);
}

std::uint64_t power(std::uint64_t exponent) { return exponent == 0 ? 1 : Hdf5Layout::fan_out * power(exponent - 1); }

/// Whatever a file needs to be read: it lies in the head, for who continues it.
std::string stored(const Hdf5Layout& layout) {
  Bytes bytes;
  bytes.add64(layout.column_bytes.size()).add64(layout.samples_per_group);
  bytes.add64(layout.node_bytes).add64(layout.first_block);
  for (const std::uint64_t size : layout.column_bytes) bytes.add64(size);
  return bytes.text();
}

/// Bytes at a place of a file; fewer if it ends before.
std::string read_bytes(int file, std::uint64_t position, std::uint64_t size) {
  std::string bytes(size, '\0');
  std::uint64_t done = 0;
  while (done < size) {
    const ssize_t count = ::pread(file, bytes.data() + done, size - done, static_cast<off_t>(position + done));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    done += static_cast<std::uint64_t>(count);
  }
  bytes.resize(done);
  return bytes;
}

std::optional<Hdf5Layout> read_layout(int file) {
  constexpr std::uint64_t most_columns = (head_bytes - layout_place) / 8 - 4;
  const std::string bytes = read_bytes(file, layout_place, head_bytes - layout_place);
  if (bytes.size() != head_bytes - layout_place) return std::nullopt;
  const auto number = [&](std::size_t place) {
    std::uint64_t value = 0;
    std::memcpy(&value, bytes.data() + 8 * place, 8);
    return value;
  };
  Hdf5Layout layout;
  for (std::size_t column = 0; column < std::min(number(0), most_columns); ++column)
    layout.column_bytes.push_back(number(4 + column));
  layout.samples_per_group = std::max<std::uint64_t>(number(1), 1);
  layout.node_bytes = number(2);
  layout.first_block = number(3);
  return layout;
}

/// Of the samples up to `end`, as they were added; empty if the file has fewer.
std::optional<Checksum> checksum_of_samples(int file, const TableEnd& end) {
  const std::optional<Hdf5Layout> layout = read_layout(file);
  Checksum checksum;
  if (!layout || layout->sample_bytes() == 0 || end.bytes % layout->sample_bytes() != 0) return std::nullopt;
  for (std::uint64_t sample = 0; sample < end.bytes / layout->sample_bytes(); ++sample) {
    const std::uint64_t within = sample % layout->samples_per_group;
    std::uint64_t chunk = layout->group_at(sample / layout->samples_per_group);
    for (const std::uint64_t size : layout->column_bytes) {
      const std::string values = read_bytes(file, chunk + within * size, size);
      if (values.size() != size) return std::nullopt;
      checksum.add(values);
      chunk += layout->samples_per_group * size;
    }
  }
  return checksum;
}

}  // namespace

/// Before a block lie those before it, each with its leaves, and the nodes of higher levels that began in them.
std::uint64_t Hdf5Layout::block_at(std::uint64_t block) const {
  std::uint64_t nodes = block;
  for (std::uint64_t level = 1; level < levels; ++level) nodes += (block + power(level) - 1) / power(level);
  return first_block + nodes * node_bytes + block * fan_out * group_bytes();
}

std::uint64_t Hdf5Layout::group_at(std::uint64_t group) const {
  const std::uint64_t block = group / fan_out;
  return block_at(block + 1) - (fan_out - group % fan_out) * group_bytes();
}

std::uint64_t Hdf5Layout::nodes_at(std::uint64_t level, std::uint64_t group) const {
  return block_at(group / power(level + 1) * power(level)) + level * node_bytes;
}

Hdf5Table::Hdf5Table(std::string path, std::vector<Hdf5Column> columns, std::string rows_name,
                     const std::vector<std::string>& rows, const std::optional<TableEnd>& end)
    : TableFile(std::move(path), end),
      columns_(std::move(columns)),
      rows_name_(std::move(rows_name)),
      rows_(rows.size()) {
  for (const std::string& name : rows) name_bytes_ = std::max<std::uint64_t>(name_bytes_, name.size());
  constexpr std::uint64_t vector_bytes = 3 * sizeof(double);
  layout_.samples_per_group = std::clamp<std::uint64_t>(chunk_bytes / (rows_ * vector_bytes + 1), 1, 64);
  for (const Hdf5Column& column : columns_) {
    layout_.column_bytes.push_back(column.bytes(rows_));
    layout_.node_bytes += node_bytes(column);
  }
  room_ = room_bytes / layout_.group_bytes() + 1;
  layout_.first_block = (head_bytes + rows_ * name_bytes_ + 7) / 8 * 8;
  end ? continue_from(*end) : create(rows);
}

void Hdf5Table::create(const std::vector<std::string>& rows) {
  resize(0);
  Bytes names;
  for (std::size_t row = 0; row < rows.size(); ++row) names.add(rows[row]).pad_to((row + 1) * name_bytes_);
  write(head_bytes, names.text());
  begin_group(0);
  flush();
}

void Hdf5Table::continue_from(const TableEnd& end) {
  if (const std::string layout = stored(layout_); read_bytes(file_, layout_place, layout.size()) != layout)
    throw StorageError(path_ +
                       " is of other bodies (the run cannot continue it). Restore the file, or start a new run.");
  checksum_ = *checksum_of_samples(file_, end);
  samples_ = shown_ = end.bytes / layout_.sample_bytes();
  flushed_group_ = newest_group();
  const std::uint64_t size = layout_.group_at(flushed_group_ + 2 * room_ + 1);
  if (std::filesystem::file_size(path_) < size) resize(size);
  write_head(layout_.group_at(flushed_group_ + room_ + 1));
  resize(size);
  write_counts(flushed_group_);
}

Hdf5Table::~Hdf5Table() {
  try {
    flush();
    const std::uint64_t end = layout_.group_at(newest_group()) + layout_.group_bytes();
    write_head(end);
    resize(end);
  } catch (const Error&) {
    // The run is failing already; the samples shown before stay as they are.
  }
}

void Hdf5Table::add(std::span<const std::span<const std::byte>> values) {
  const std::uint64_t group = samples_ / layout_.samples_per_group;
  const std::uint64_t within = samples_ % layout_.samples_per_group;
  if (group > flushed_group_ + room_) flush();
  if (within == 0 && group > 0) begin_group(group);
  std::uint64_t chunk = layout_.group_at(group);
  for (std::size_t column = 0; column < columns_.size(); ++column) {
    const std::uint64_t size = layout_.column_bytes[column];
    assert(values[column].size() == size);
    write(chunk + within * size, {reinterpret_cast<const char*>(values[column].data()), size});
    chunk += layout_.samples_per_group * size;
  }
  for (const auto& column : values)  // of whole samples only
    checksum_.add({reinterpret_cast<const char*>(column.data()), column.size()});
  ++samples_;
  bytes_ += layout_.sample_bytes();
  if (is_due()) flush();
}

/// A reader learns how large the file is, then where HDF5's part of it ends, then how many samples there are, and each
/// may have grown meanwhile: the file has room for this and the next time.
void Hdf5Table::flush() {
  shown_ = samples_;
  flushed_group_ = newest_group();
  resize(layout_.group_at(flushed_group_ + 2 * room_ + 1));
  write_head(layout_.group_at(flushed_group_ + room_ + 1));
  flushed_ = Clock::now();
}

/// Indexes it, before there are samples in it.
void Hdf5Table::begin_group(std::uint64_t group) {
  if (group >= power(Hdf5Layout::levels)) {
    throw StorageError(path_ + " is full (" + std::to_string(samples_) +
                       " samples). Use a larger output.trajectory.every_steps.");
  }
  for (std::uint64_t level = 0; level < Hdf5Layout::levels; ++level) {
    if (group % power(level + 1) == 0) write_nodes(level, group);
  }
  write_counts(group);
}

/// III.A.1, node type 1: the node of each column, with all entries that it will ever have.
void Hdf5Table::write_nodes(std::uint64_t level, std::uint64_t group) {
  Bytes nodes;
  std::uint64_t chunk = 0;  // in a group
  for (std::size_t number = 0; number < columns_.size(); ++number) {
    const Hdf5Column& column = columns_[number];
    const std::uint64_t size = layout_.samples_per_group * layout_.column_bytes[number];
    const std::uint64_t node = nodes.size();  // in the nodes of all columns
    nodes.add(std::string("TREE")).add8(1).add8(level).add16(0).add64(undefined).add64(undefined);
    for (std::uint64_t entry = 0; entry <= Hdf5Layout::fan_out; ++entry) {
      const std::uint64_t first = group + entry * power(level);  // group of the entry
      const std::uint64_t end = nodes.size() + key_bytes(column);
      nodes.add32(size).add32(0).add64(first * layout_.samples_per_group).pad_to(end);
      if (entry < Hdf5Layout::fan_out)
        nodes.add64(level == 0 ? layout_.group_at(first) + chunk : layout_.nodes_at(level - 1, first) + node);
    }
    chunk += size;
  }
  write(layout_.nodes_at(level, group), nodes.text());
}

/// Of entries in the nodes that lead to the newest group, from the leaves up.
void Hdf5Table::write_counts(std::uint64_t group) {
  for (std::uint64_t level = 0; level < Hdf5Layout::levels; ++level) {
    const std::string count = Bytes().add16(group / power(level) % Hdf5Layout::fan_out + 1).text();
    std::uint64_t node = layout_.nodes_at(level, group);
    for (const Hdf5Column& column : columns_) {
      write(node + count_place, count);
      node += node_bytes(column);
    }
  }
}

/// The shapes of the datasets come last of all that changes, so that readers find what a shape announces.
void Hdf5Table::write_head(std::uint64_t end_of_file) {
  std::vector<std::string> datasets;
  std::vector<std::pair<std::string, std::uint64_t>> links;
  std::uint64_t node = layout_.nodes_at(Hdf5Layout::levels - 1, 0);
  for (const Hdf5Column& column : columns_) {
    const bool has_rows = column.components > 0;
    Bytes layout;  // IV.A.2.i
    layout.add8(3).add8(2).add8(column.rank() + 1).add64(node).add32(layout_.samples_per_group);
    if (has_rows) layout.add32(std::max<std::uint64_t>(rows_, 1)).add32(column.components);
    layout.add32(sizeof(double));
    const auto shape = has_rows ? std::vector{shown_, rows_, column.components} : std::vector{shown_};
    datasets.push_back(dataset(dataspace(shape, undefined), number_type(column.kind), layout));
    links.emplace_back(column.name, 0);
    node += node_bytes(column);
  }
  const Bytes names = Bytes().add8(3).add8(1).add64(head_bytes).add64(rows_ * name_bytes_);
  datasets.push_back(dataset(dataspace({rows_}, 0), text_type(name_bytes_), names));
  links.emplace_back(rows_name_, 0);
  const std::string start = superblock(end_of_file);
  std::uint64_t address = start.size() + group(links).size();
  for (std::size_t number = 0; number < links.size(); ++number) {
    links[number].second = address;
    address += datasets[number].size();
  }
  Bytes head;
  head.add(start).add(group(links));
  for (const std::string& each : datasets) head.add(each);
  assert(head.size() <= layout_place);
  write(0, head.pad_to(layout_place).add(stored(layout_)).pad_to(head_bytes).text());
}

std::optional<Checksum> Hdf5Table::checksum_of_start(const std::string& path, const TableEnd& end) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return std::nullopt;
  std::optional<Checksum> checksum = checksum_of_samples(file, end);
  ::close(file);
  return checksum;
}

}  // namespace copepod::coupler
