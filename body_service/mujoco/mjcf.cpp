#include <algorithm>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <limits>
#include <numeric>
#include <sstream>
#include <vector>

#include <Eigen/Geometry>

#include "contact/contact_law.hpp"
#include "contract/errors.hpp"
#include "contract/words.hpp"
#include "geometry/contact_time.hpp"
#include "geometry/near_pairs.hpp"
#include "geometry/rotation.hpp"
#include "model/body_model.hpp"
#include "mujoco/mujoco_world.hpp"

namespace copepod::body {

namespace {

/// The bodies of a case as trees that grow from the world along its joints.
struct JointTree {
  struct Node {
    int parent = -1;  ///< body; −1: the world
    int joint = -1;   ///< that connects them; −1: none, the body has its own freedom
    std::vector<int> children{};
  };
  std::vector<Node> bodies;
  std::vector<int> roots;         ///< bodies that hang on the world
  std::vector<int> other_joints;  ///< those that close loops
};

/// Whether an actuator gives the joint's motion.
bool is_driven(const BodySetup& setup, int joint) {
  return std::ranges::any_of(setup.actuators, [joint](const ActuatorSpecification& actuator) {
    return actuator.kind == ActuatorKind::joint_motion && actuator.joint == joint;
  });
}

/// Whether MuJoCo cannot keep the joint but as an edge: a slider, a rod, one that has a spring or is driven.
bool must_be_edge(const BodySetup& setup, int joint) {
  const JointSpecification& it = setup.joints[joint];
  return it.kind == JointKind::slider || it.kind == JointKind::distance || it.stiffness > 0.0 || it.damping > 0.0 ||
         it.has_limits() || is_driven(setup, joint);
}

/// Joints that MuJoCo can keep only as edges are edges wherever possible: Prim's algorithm [Bell Syst. Tech. J. 36,
/// 1389, 1957].
JointTree joint_tree_of(const BodySetup& setup) {
  JointTree tree;
  tree.bodies.resize(setup.bodies.size());
  std::vector<bool> reached(setup.bodies.size(), false);
  const auto is_reached = [&](int body) { return body < 0 || reached[body]; };
  const auto attach = [&](int body, int parent, int joint) {
    tree.bodies[body].parent = parent;
    tree.bodies[body].joint = joint;
    (parent < 0 ? tree.roots : tree.bodies[parent].children).push_back(body);
    reached[body] = true;
  };
  const auto bodies = static_cast<int>(setup.bodies.size());
  for (int body = 0; body < bodies; ++body)
    if (setup.bodies[body].motion != MotionKind::free) attach(body, -1, -1);

  std::vector<int> edges(setup.joints.size());  // those that must be edges first
  std::iota(edges.begin(), edges.end(), 0);
  std::ranges::stable_sort(edges, std::greater<>{}, [&](int joint) { return must_be_edge(setup, joint); });
  for (int next_root = 0;;) {
    const auto grows = std::ranges::find_if(edges, [&](int joint) {
      return is_reached(setup.joints[joint].body_A) != is_reached(setup.joints[joint].body_B);
    });
    if (grows != edges.end()) {
      const JointSpecification& joint = setup.joints[*grows];
      if (is_reached(joint.body_A))
        attach(joint.body_B, joint.body_A, *grows);
      else
        attach(joint.body_A, joint.body_B, *grows);
      edges.erase(grows);
      continue;
    }
    while (next_root < bodies && reached[next_root]) ++next_root;
    if (next_root == bodies) break;
    attach(next_root, -1, -1);
  }
  tree.other_joints = std::move(edges);
  return tree;
}

/// name="…" with numbers that are read back bit for bit.
template <typename Numbers = std::initializer_list<double>>
std::string attribute(const char* name, const Numbers& numbers) {
  std::ostringstream text;
  text.precision(std::numeric_limits<double>::max_digits10);
  text << ' ' << name << "=\"";
  for (const double number : numbers) text << number << ' ';
  text << '"';
  return text.str();
}

/// Constraints are solved until rounding ends that.
constexpr const char* solver = R"( solver="Newton" tolerance="0" iterations="50")";

/// name="b3" and the like.
std::string label(const char* name, char kind, int number) {
  std::ostringstream text;
  text << ' ' << name << "=\"" << kind << number << '"';
  return text.str();
}

Eigen::Vector4d conjugate(const Eigen::Vector4d& q) { return {q[0], -q[1], -q[2], -q[3]}; }

/// Writes the elements of one case.
class Writer {
 public:
  Writer(const BodySetup& setup, const EngineUnits& units, double step, JointTree tree)
      : setup_(setup),
        units_(units),
        step_(step),
        tree_(std::move(tree)),
        contact_(contact_attributes(largest_inverse_mass_per_kg(setup.bodies))) {}

  [[nodiscard]] std::string options() const {
    const std::size_t contacts = 100 + 10 * setup_.bodies.size();
    const std::size_t rows = 4 * contacts + 6 * setup_.joints.size();
    return "<compiler angle=\"radian\"/>\n<size nconmax=\"" + std::to_string(contacts) + "\" njmax=\"" +
           std::to_string(rows) + "\"/>\n<option" + attribute("timestep", {mujoco_step}) +
           R"( gravity="0 0 0" integrator="Euler" cone="elliptic")" + solver +
           "><flag warmstart=\"disable\"/></option>\n";
  }

  [[nodiscard]] std::string walls() const {
    std::string text;
    for (const WallSpecification& wall : setup_.walls) text += plane(wall);
    return text;
  }

  [[nodiscard]] std::string bodies() const {
    std::string text;
    for (const int root : tree_.roots) text += body(root);
    return text;
  }

  /// Bodies with a joint do not meet each other.
  [[nodiscard]] std::string exclusions() const {
    std::string text;
    for (const auto& [A, B] : jointed_pairs(setup_.joints))
      text += "<exclude" + label("body1", 'b', A) + label("body2", 'b', B) + "/>\n";
    return text;
  }

  [[nodiscard]] std::string equalities() const {
    std::string text;
    for (const int joint : tree_.other_joints) text += equality(joint);
    return text;
  }

 private:
  /// Of a constraint: the shortest time constant that is stable, two steps, with critical damping.
  [[nodiscard]] std::string stiff() const {
    return attribute("solref", {2.0 * step_, 1.0}) + attribute("solimp", {0.9999, 0.9999, 0.001});
  }

  /// A spring and damper per effective mass, those of the lightest bodies for all,
  ///   k' = k/m_eff,   c' = 2 ζ √k'                                                         (B20), (B21)
  /// As MuJoCo's constraints also take up the loads, a body that lies sinks in by far less than its weight over k.
  /// Without `contact` in the case they do not rebound. Friction has no spring of its own in MuJoCo, so that with these
  /// it would be a weak damper: there is none.
  [[nodiscard]] std::string contact_attributes(double inverse_mass_per_kg) const {
    const ContactSpecification& contact = setup_.contact;
    if (!is_resolving(contact)) return " condim=\"1\"" + stiff();
    const double frequency = std::sqrt(contact.stiffness_N_per_m * inverse_mass_per_kg) * units_.time_s;
    const double damping = 2.0 * damping_ratio_of(contact.restitution) * frequency;
    return " condim=\"1\"" + attribute("solref", {-frequency * frequency, -damping}) +
           attribute("solimp", {0.9999, 0.9999, 0.001});
  }

  [[nodiscard]] std::string plane(const WallSpecification& wall) const {
    require_at_rest(wall);
    const Eigen::Quaterniond q = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), wall.normal);
    return R"(<geom type="plane" priority="1" contype="2147483647" conaffinity="2147483647" margin="0" gap="0")" +
           attribute("size", {0, 0, 1}) + attribute("pos", Eigen::Vector3d(wall.point_m / units_.length_m)) +
           attribute("quat", {q.w(), q.x(), q.y(), q.z()}) +
           contact_attributes(0.5 * largest_inverse_mass_per_kg(setup_.bodies)) + "/>\n";
  }

  [[nodiscard]] const BodySpecification& of(int body) const { return setup_.bodies[body]; }

  /// A body in the frame of the one that it hangs on, with those that hang on it.
  [[nodiscard]] std::string body(int number) const {
    const BodySpecification& body = of(number);
    const JointTree::Node& node = tree_.bodies[number];
    const Rod rod = rod_of(node);
    Eigen::Vector3d position_m = body.position_m;
    Eigen::Vector4d orientation_wxyz = body.orientation_wxyz;
    if (node.parent >= 0) {
      const Eigen::Vector4d to_parent = conjugate(of(node.parent).orientation_wxyz);
      position_m = rotation_matrix(to_parent) * (position_m - of(node.parent).position_m);
      orientation_wxyz = product(to_parent, orientation_wxyz);
    }
    std::string text = rod.before + "<body" + label("name", 'b', number) +
                       attribute("pos", Eigen::Vector3d((position_m - rod.start_m) / units_.length_m)) +
                       attribute("quat", orientation_wxyz) + ">" +
                       (node.joint < 0 ? own_freedom(body) : joint(node.joint, number)) + matter(number) + "\n";
    for (const int child : node.children) text += this->body(child);
    return text + "</body>" + rod.after + "\n";
  }

  /// A body of nearly no mass between two that a rod connects: it turns about the end of the rod on the first.
  struct Rod {
    std::string before, after;
    Eigen::Vector3d start_m{0, 0, 0};  ///< in the frame of the first
  };
  [[nodiscard]] Rod rod_of(const JointTree::Node& node) const {
    if (node.joint < 0 || joint_at(node.joint).kind != JointKind::distance) return {};
    const JointSpecification& joint = joint_at(node.joint);
    const Eigen::Vector3d start_m = joint.body_B == node.parent ? joint.anchor_B_m : joint.anchor_A_m;
    return {"<body" + attribute("pos", Eigen::Vector3d(start_m / units_.length_m)) +
                "><joint type=\"ball\"/><inertial" + attribute("pos", {0, 0, 0}) + attribute("mass", {1e-9}) +
                attribute("diaginertia", {1e-9, 1e-9, 1e-9}) + "/>",
            "</body>", start_m};
  }

  static std::string own_freedom(const BodySpecification& body) {
    if (body.motion == MotionKind::free) return "<freejoint/>";
    if (body.motion != MotionKind::axis) return "";
    const Eigen::Vector3d axis = rotation_matrix(body.orientation_wxyz).transpose() * body.axis;
    return "<joint type=\"slide\"" + attribute("axis", axis) + "/><joint type=\"hinge\"" + attribute("axis", axis) +
           "/>";
  }

  [[nodiscard]] std::string matter(int number) const {
    const BodySpecification& body = of(number);
    const Eigen::Matrix3d I = inertia_tensor_kg_m2(body) / units_.inertia_kg_m2();
    std::string text =
        "<inertial pos=\"0 0 0\"" + attribute("mass", {body.mass_kg / units_.mass_kg}) +
        (I.isDiagonal(0.0) ? attribute("diaginertia", Eigen::Vector3d(I.diagonal()))
                           : attribute("fullinertia", {I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)})) +
        "/>";
    const std::string name = label("name", 'b', number);
    if (body.shape.kind != ShapeKind::compound) return text + "<geom" + name + size(body.shape) + contact_ + "/>";
    text += "<geom" + name + size({ShapeKind::sphere, body.shape.radius_m}) + R"( contype="0" conaffinity="0"/>)";
    for (const auto& [part, position_m, q] : body.shape.parts)
      text += "<geom" + attribute("pos", Eigen::Vector3d(position_m / units_.length_m)) + attribute("quat", q) +
              size(part) + contact_ + "/>";
    return text;
  }

  [[nodiscard]] std::string size(const Shape& shape) const {
    const std::string type = std::string(" type=\"") + name_of(shape_names, shape.kind) + "\"";
    const double unit_m = units_.length_m;
    if (shape.kind == ShapeKind::ellipsoid) return type + attribute("size", Eigen::Vector3d(shape.extents_m / unit_m));
    if (shape.kind == ShapeKind::box) return type + attribute("size", Eigen::Vector3d(0.5 * shape.extents_m / unit_m));
    return type + attribute("size", {shape.radius_m / unit_m, 0.5 * shape.length_m / unit_m});
  }

  /// The joint in the frame of the body that moves. MuJoCo's coordinate is its motion relative to the other; where it
  /// is the case's second, the axis is turned round, for the same sign.
  [[nodiscard]] std::string joint(int number, int moving) const {
    const JointSpecification& joint = joint_at(number);
    if (joint.kind == JointKind::fixed) return "";
    const bool first = joint.body_A == moving;
    const std::string place =
        attribute("pos", Eigen::Vector3d((first ? joint.anchor_A_m : joint.anchor_B_m) / units_.length_m));
    const std::string ball = "<joint type=\"ball\"" + place + "/>";
    if (joint.kind == JointKind::ball) return ball;
    const bool driven = is_driven(setup_, number);
    const bool rod = joint.kind == JointKind::distance;
    if (rod && !driven) return ball;
    const Eigen::Vector3d axis_W = rod     ? along(joint, first)
                                   : first ? Eigen::Vector3d(turned(joint.body_A, joint.axis))
                                           : Eigen::Vector3d(-turned(joint.body_A, joint.axis));
    const bool hinge = joint.kind == JointKind::hinge;
    const double length_m = hinge ? 1.0 : units_.length_m;
    const double load = hinge ? units_.torque_N_m() : units_.force_N();
    return "<joint" + label("name", 'j', number) + (hinge ? " type=\"hinge\"" : " type=\"slide\"") + place +
           attribute("axis", Eigen::Vector3d(rotation_matrix(conjugate(of(moving).orientation_wxyz)) * axis_W)) +
           attribute("stiffness", {joint.stiffness * length_m / load}) +
           attribute("damping", {joint.damping * length_m / (load * units_.time_s)}) +
           attribute("springref", {joint.rest / length_m}) + (joint.has_limits() ? limits(joint, length_m) : "") +
           attribute("armature", {driven ? mujoco_drive_inertia : 0.0}) + "/>" + (rod ? ball : "");
  }

  [[nodiscard]] std::string limits(const JointSpecification& joint, double length_m) const {
    return " limited=\"true\"" + attribute("range", {joint.lowest / length_m, joint.highest / length_m}) +
           attribute("solreflimit", {2.0 * step_, 1.0}) + attribute("solimplimit", {0.9999, 0.9999, 0.001});
  }

  [[nodiscard]] const JointSpecification& joint_at(int number) const { return setup_.joints[number]; }

  /// A vector of a body's frame in the world.
  [[nodiscard]] Eigen::Vector3d turned(int body, const Eigen::Vector3d& vector) const {
    return body < 0 ? vector : Eigen::Vector3d(rotation_matrix(of(body).orientation_wxyz) * vector);
  }

  /// Direction of a rod, from the other body to the one that moves.
  [[nodiscard]] Eigen::Vector3d along(const JointSpecification& joint, bool first_moves) const {
    const auto end_m = [this](int body, const Eigen::Vector3d& anchor_m) -> Eigen::Vector3d {
      return turned(body, anchor_m) + (body < 0 ? Eigen::Vector3d(0, 0, 0) : of(body).position_m);
    };
    const Eigen::Vector3d from_B_m = end_m(joint.body_A, joint.anchor_A_m) - end_m(joint.body_B, joint.anchor_B_m);
    return (first_moves ? from_B_m : Eigen::Vector3d(-from_B_m)).normalized();
  }

  [[nodiscard]] std::string equality(int number) const {
    const JointSpecification& joint = joint_at(number);
    if (must_be_edge(setup_, number))
      throw CaseError("joint " + std::to_string(number) +
                      " closes a loop of joints (MuJoCo cannot close one with a rod, a slider, a spring or a drive). "
                      "Use body.solver: own.");
    const std::string bodies =
        label("body1", 'b', joint.body_A) + (joint.body_B < 0 ? "" : label("body2", 'b', joint.body_B));
    if (joint.kind == JointKind::fixed) return "<weld" + bodies + stiff() + "/>\n";
    const Eigen::Vector3d anchor = joint.anchor_A_m / units_.length_m;
    const auto connect = [&](const Eigen::Vector3d& at) {
      return "<connect" + bodies + attribute("anchor", at) + stiff() + "/>\n";
    };
    return connect(anchor) + (joint.kind == JointKind::hinge ? connect(anchor + joint.axis) : "");
  }

  const BodySetup& setup_;
  const EngineUnits& units_;
  double step_;  ///< in these
  JointTree tree_;
  std::string contact_;  ///< attributes of every geom
};

}  // namespace

std::string mjcf_of(const BodySetup& setup, const EngineUnits& units) {
  const Writer writer(setup, units, mujoco_step, joint_tree_of(setup));
  return "<mujoco>\n" + writer.options() + "<worldbody>\n" + writer.walls() + writer.bodies() +
         "</worldbody>\n<contact>\n" + writer.exclusions() + "</contact>\n<equality>\n" + writer.equalities() +
         "</equality>\n</mujoco>\n";
}

std::string mjcf_around_model(const BodySetup& setup, const EngineUnits& units, double step) {
  const double acceleration = units.length_m / (units.time_s * units.time_s);
  return "<mujoco>\n<include file=\"model.xml\"/>\n<option" + attribute("timestep", {step}) +
         attribute("gravity", Eigen::Vector3d(setup.gravity_m_per_s2 / acceleration)) + attribute("wind", {0, 0, 0}) +
         attribute("density", {0}) + attribute("viscosity", {0}) + solver +
         "><flag gravity=\"enable\" warmstart=\"disable\"/></option>\n<worldbody>\n" +
         Writer(setup, units, step, {}).walls() + "</worldbody>\n</mujoco>\n";
}

}  // namespace copepod::body
