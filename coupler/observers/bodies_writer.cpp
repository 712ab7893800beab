#include "observers/bodies_writer.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string_view>

#include <spdlog/fmt/fmt.h>

#include "contract/errors.hpp"
#include "contract/words.hpp"
#include "geometry/rotation.hpp"
#include "storage/table_file.hpp"
#include "system/durable_file.hpp"

namespace copepod::coupler {

namespace {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "the files announce little-endian numbers");

constexpr std::string_view prefix = "step_";
constexpr std::string_view suffix = ".vtp";

std::string frame_name(std::int64_t step) { return fmt::format("{}{:09}{}", prefix, step, suffix); }

/// −1: not the name of a frame.
std::int64_t step_of_frame(std::string_view name) {
  if (!name.starts_with(prefix) || !name.ends_with(suffix)) return -1;
  return number_in<std::int64_t>(name.substr(prefix.size(), name.size() - prefix.size() - suffix.size())).value_or(-1);
}

/// A poly data file: its elements, and behind them the arrays, each after its size in bytes.
class PolyDataFile {
 public:
  void add_text(const std::string& text) { elements_ += text; }

  template <class T>
  void add_array(const char* type, const std::string& attributes, const std::vector<T>& values) {
    elements_ += std::string("<DataArray type=\"") + type + "\" " + attributes + R"( format="appended" offset=")" +
                 std::to_string(data_.size()) + "\"/>\n";
    const std::uint64_t bytes = values.size() * sizeof(T);
    data_.append(reinterpret_cast<const char*>(&bytes), sizeof bytes);
    data_.append(reinterpret_cast<const char*>(values.data()), bytes);
  }
  void add_vectors(const std::string& name, const std::vector<float>& values) {
    add_array("Float32", "Name=\"" + name + R"(" NumberOfComponents="3")", values);
  }

  [[nodiscard]] std::string text() const {
    return "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" "
           "header_type=\"UInt64\">\n<PolyData>\n" +
           elements_ + "</PolyData>\n<AppendedData encoding=\"raw\">\n_" + data_ + "\n</AppendedData>\n</VTKFile>\n";
  }

 private:
  std::string elements_;
  std::string data_;
};

/// Columns one after the other.
std::vector<float> in_single_precision(const Eigen::Matrix3Xd& columns) {
  const Eigen::Matrix3Xf single = columns.cast<float>();
  return {single.data(), single.data() + single.size()};
}

/// Round bodies in a small group, small files in a large one.
int points_around(std::size_t bodies) { return bodies <= 30 ? 24 : 12; }

}  // namespace

BodiesWriter::BodiesWriter(fs::path path, const std::vector<BodySpecification>& bodies, double step_s,
                           const std::array<double, 3>& periodic_length_m, std::int64_t every_steps,
                           std::int64_t first_step)
    : path_(std::move(path)),
      folder_(path_.parent_path() / path_.stem()),
      step_s_(step_s),
      periodic_length_m_(periodic_length_m),
      every_steps_(every_steps),
      listed_(Clock::now()) {
  for (const BodySpecification& body : bodies) {
    names_.push_back(body.name);
    surfaces_.push_back(make_solid(body.shape)->surface(points_around(bodies.size())));
  }
  keep_frames_before(first_step);
  write_list();
}

void BodiesWriter::keep_frames_before(std::int64_t first_step) {
  try {
    fs::create_directories(folder_);
    for (const auto& entry : fs::directory_iterator(folder_)) {
      const std::int64_t step = step_of_frame(entry.path().filename().string());
      if (step >= 0 && step < first_step) frames_.push_back(step);
      if (step >= first_step) fs::remove(entry.path());
    }
  } catch (const fs::filesystem_error& error) {
    throw StorageError(folder_.string() + " cannot be prepared (" + error.code().message() +
                       "). Check its permissions, or choose another --out folder.");
  }
  std::ranges::sort(frames_);
  synced_ = frames_.size();
}

void BodiesWriter::observe(const StepRecord& record) {
  if (record.step % every_steps_ != 0 && !frames_.empty()) return;
  add_frame(record);
  if (Clock::now() - listed_ >= std::chrono::seconds(1)) write_list();
}

void BodiesWriter::finish(const StepRecord& last) {
  if (frames_.empty() || frames_.back() != last.step) add_frame(last);
  write_list();
}

void BodiesWriter::sync() {
  for (; synced_ < frames_.size(); ++synced_) sync_to_disk((folder_ / frame_name(frames_[synced_])).string());
  write_list();
}

void BodiesWriter::add_frame(const StepRecord& record) {
  write_atomically((folder_ / frame_name(record.step)).string(), frame_text(record));
  frames_.push_back(record.step);
}

/// Times are those of fields.xdmf: step · Δt.
void BodiesWriter::write_list() {
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n"
      "<Collection>\n";
  for (const std::int64_t step : frames_) {
    text += "<DataSet timestep=\"";
    append(text, static_cast<double>(step) * step_s_);
    text += "\" file=\"" + (folder_.filename() / frame_name(step)).string() + "\"/>\n";
  }
  write_atomically(path_.string(), text + "</Collection>\n</VTKFile>\n");
  listed_ = Clock::now();
}

std::string BodiesWriter::frame_text(const StepRecord& record) const {
  const Kinematics& state = record.kinematics;
  std::vector<float> points, normals;
  std::vector<std::int32_t> strips, ends, numbers;
  std::vector<char> names;
  for (Eigen::Index body = 0; body < std::ssize(surfaces_); ++body) {
    const Surface& surface = surfaces_[body];
    const Eigen::Matrix3d R_WB = rotation_matrix(state.orientation_wxyz.col(body));
    Eigen::Vector3d center_m = state.position_m.col(body);
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const double length_m = periodic_length_m_[axis];
      if (length_m > 0.0) center_m[axis] -= length_m * std::floor(center_m[axis] / length_m);
    }
    const auto first = static_cast<std::int32_t>(points.size() / 3);
    for (const float value : in_single_precision((R_WB * surface.points).colwise() + center_m)) points.push_back(value);
    for (const float value : in_single_precision(R_WB * surface.normals)) normals.push_back(value);
    for (const std::int32_t point : surface.strip) strips.push_back(first + point);
    ends.push_back(static_cast<std::int32_t>(strips.size()));
    numbers.push_back(static_cast<std::int32_t>(body) + 1);
    names.insert(names.end(), names_[body].begin(), names_[body].end());
    names.push_back('\0');
  }
  PolyDataFile file;
  file.add_text("<Piece NumberOfPoints=\"" + std::to_string(points.size() / 3) + "\" NumberOfStrips=\"" +
                std::to_string(ends.size()) + "\">\n<PointData Normals=\"normals\">\n");
  file.add_vectors("normals", normals);
  file.add_text("</PointData>\n<CellData Scalars=\"body\">\n");
  file.add_array("Int32", "Name=\"body\"", numbers);
  file.add_array("String", "Name=\"name\"", names);
  file.add_vectors("position_m", in_single_precision(state.position_m));
  file.add_vectors("velocity_m_per_s", in_single_precision(state.velocity_m_per_s));
  file.add_vectors("angular_velocity_rad_per_s", in_single_precision(state.angular_velocity_rad_per_s));
  file.add_vectors("force_N", in_single_precision(record.applied.force_N));
  file.add_vectors("torque_N_m", in_single_precision(record.applied.torque_N_m));
  file.add_vectors("drive_N", in_single_precision(record.drive.force_N));
  file.add_text("</CellData>\n<Points>\n");
  file.add_vectors("points", points);
  file.add_text("</Points>\n<Strips>\n");
  file.add_array("Int32", "Name=\"connectivity\"", strips);
  file.add_array("Int32", "Name=\"offsets\"", ends);
  file.add_text("</Strips>\n</Piece>\n");
  return file.text();
}

}  // namespace copepod::coupler
