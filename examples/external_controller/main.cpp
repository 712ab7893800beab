// A controller outside the repository: examples/python/triangle_pilot.py in C++. It measures what each of six strokes
// of a triangle of spheres does, then steers it to a target and holds it there
// (configs/examples/steered_triangle.yaml).
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include <nlohmann/json.hpp>

#include "component/run_component.hpp"

namespace {

using Eigen::Vector2d;

constexpr std::array<std::array<int, 2>, 6> strokes{{{0, 1}, {0, 2}, {1, 0}, {1, 2}, {2, 0}, {2, 1}}};
constexpr std::array<std::array<double, 2>, 6> shortened{{{1, 0}, {1, 1}, {0, 1}, {0, 0}, {0, 0}, {0, 0}}};

class Pilot final : public copepod::Controller {
 public:
  explicit Pilot(const copepod::ControllerSetup& setup) {
    const nlohmann::json parameters = nlohmann::json::parse(setup.parameters);
    target_m_ = Vector2d(parameters.at("target_m")[0].get<double>(), parameters.at("target_m")[1].get<double>());
    stroke_m_ = parameters.at("stroke_m");
  }

  std::vector<double> act(const copepod::Observation& observation) override {
    const int cycle = now_.actions / 6, phase = now_.actions++ % 6;
    if (phase == 0) choose(cycle, observation.kinematics.position_m(std::array{0, 2}, Eigen::all));
    std::vector<double> lengths(3, 0.0);
    for (int arm : {0, 1}) lengths[strokes[now_.stroke][arm]] = shortened[phase][arm] * now_.size * stroke_m_;
    return lengths;
  }

  std::string state() const override { return {reinterpret_cast<const char*>(&now_), sizeof now_}; }
  void set_state(const std::string& state) override {
    std::memcpy(static_cast<void*>(&now_), state.data(), sizeof now_);
  }

 private:
  void choose(int cycle, const Eigen::Matrix2Xd& places) {
    const Vector2d middle = places.rowwise().mean(), along = (places.col(0) - middle).normalized();
    if (cycle == 0) now_.origin = middle;
    if (cycle > 0 && cycle <= 6) now_.ways[cycle - 1] = now_.frame * (middle - now_.start);
    now_.start = middle;
    now_.frame << along.x(), along.y(), -along.y(), along.x();
    now_.stroke = cycle < 6 ? cycle : 0;
    now_.size = 1.0;
    if (cycle < 6) return;
    const Vector2d left = now_.frame * (now_.origin + target_m_ - middle);
    double nearest = INFINITY;
    for (int i = 0; i < 6; ++i) {
      const Vector2d& way = now_.ways[i];
      const double share = std::clamp(way.dot(left) / way.squaredNorm(), 0.0, 1.0);
      if ((left - share * way).norm() >= nearest) continue;
      nearest = (left - share * way).norm();
      now_.stroke = i;
      now_.size = std::cbrt(share);
    }
  }

  struct State {
    int actions = 0, stroke = 0;
    double size = 0.0;
    Vector2d origin{0, 0}, start{0, 0};
    std::array<Vector2d, 6> ways{};
    Eigen::Matrix2d frame = Eigen::Matrix2d::Zero();
  } now_;
  Vector2d target_m_;
  double stroke_m_ = 0.0;
};

}  // namespace

int main(int argc, char** argv) {
  copepod::ControllerComponent component;
  component.capabilities = {"Triangle pilot in C++", "1.0", {"checkpoint", "snapshots"}};
  component.make_solver = [](const copepod::ControllerSetup& setup, copepod::SolverContext&) {
    return std::make_unique<Pilot>(setup);
  };
  return copepod::run_controller_component(argc, argv, component);
}
