#include "dae/program/alignment.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <fmt/format.h>

#include "dae/integrator/redundancy.hpp"
#include "dae/model/measure.hpp"

namespace mfs::dae {
namespace {

/// Axes that differ by less are meant to agree to rounding (of a file's digits), by more to differ: rad.
constexpr double kRounding = 1e-7, kMeant = 3.0 * M_PI / 180.0;
/// The same of the distance of two parallel hinges, in parts of that along them.
constexpr double kBeside = 0.1;
/// What is left of a constraint, in parts of its largest entry, that the axes may be all that holds.
constexpr double kNearly = 0.06;
/// A joint that is farther from both its bodies, in radii of gyration, is not meant to be. A mass point on a
/// rod is as far from its pivot, but two that are joined have their joint in one of them.
constexpr double kFar = 300.0;
/// The same from the nodes that a joint holds, in lengths of their mesh.
constexpr double kFarFromMesh = 10.0;
/// Pairs of so many directions are looked at without delay.
constexpr std::size_t kMostDirections = 3000;

bool has_line(JointKind kind) {
  return kind == JointKind::revolute || kind == JointKind::cylindrical || kind == JointKind::translational;
}

double angle_between_lines(const Eigen::Vector3d& x, const Eigen::Vector3d& y) {
  return std::atan2(x.cross(y).norm(), std::abs(x.dot(y)));
}

double degrees(double angle) {
  return angle * 180.0 / M_PI;
}

/// A joint's axis in ground axes.
struct Line {
  const ModelJoint* joint;
  Eigen::Vector3d point, along;
};

std::vector<Line> lines_of(const MultibodyModel& model, const State& state) {
  std::vector<Line> lines;
  for (const ModelJoint& joint : model.joints) {
    if (!has_line(joint.kind)) continue;
    const FrameMotion frame = frame_motion(joint.a.frame, state);
    lines.push_back(
        {&joint, frame.position + frame.rotation * joint.a.point, frame.rotation * joint.a.axes.col(2)});
  }
  return lines;
}

bool hinges_of_the_same(const ModelJoint& x, const ModelJoint& y) {
  const auto same = [](const Frame& f, const Frame& g) { return f.first == g.first; };
  return x.kind == JointKind::revolute && y.kind == JointKind::revolute &&
         ((same(x.a.frame, y.a.frame) && same(x.b.frame, y.b.frame)) ||
          (same(x.a.frame, y.b.frame) && same(x.b.frame, y.a.frame)));
}

/// How y is out of line beside x; empty: it is not, or that is meant.
std::string out_of_line(const Line& x, const Line& y) {
  const double angle = angle_between_lines(x.along, y.along);
  if (angle > kMeant) return "";
  if (angle > kRounding) return fmt::format("{:.3g} degrees off", degrees(angle));
  if (!hinges_of_the_same(*x.joint, *y.joint)) return "";
  const Eigen::Vector3d apart = y.point - x.point;
  const double along = std::abs(apart.dot(x.along)), beside = x.along.cross(apart).norm();
  return beside > kRounding * along && beside < kBeside * along ? fmt::format("{:.3g} m beside", beside) : "";
}

/// Whether there are such lines at all, which a search for redundant constraints would pay for.
bool any_out_of_line(const std::vector<Line>& lines) {
  if (lines.size() > kMostDirections) return true;
  for (std::size_t i = 0; i < lines.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (!out_of_line(lines[j], lines[i]).empty()) return true;
  return false;
}

/// Owners of the constraints of each combination that is nearly zero and not quite.
std::vector<std::set<std::string>> nearly_redundant(const ConstrainedSystem& system,
                                                    const std::vector<double>& q) {
  std::vector<double> scale;
  for (int i = 0; i < system.coordinates(); ++i) scale.push_back(system.coordinate_scale(i));
  const Redundancy redundancy(system, std::move(scale));
  const std::vector<int> exact = redundancy.find(0.0, q).redundant();
  const Dependencies nearly = redundancy.find(0.0, q, kNearly);
  std::vector<std::set<std::string>> owners;
  if (nearly.redundant().size() <= exact.size()) return owners;
  for (std::size_t k = 0; k < nearly.redundant().size(); ++k) {
    owners.emplace_back();
    for (const auto& [row, share] : nearly.combination(k)) owners.back().insert(system.constraint_owner(row));
  }
  return owners;
}

/// Beside the one of `lines` with which most others agree.
void add_notes(const std::vector<Line>& lines, std::vector<std::string>& notes) {
  const auto agreeing = [&](const Line& line) {
    return std::count_if(lines.begin(), lines.end(), [&](const Line& other) {
      return angle_between_lines(line.along, other.along) <= kRounding;
    });
  };
  const auto most = std::max_element(lines.begin(), lines.end(),
                                     [&](const Line& x, const Line& y) { return agreeing(x) < agreeing(y); });
  for (const Line& line : lines) {
    const std::string how = out_of_line(*most, line);
    if (how.empty()) continue;
    std::string note =
        fmt::format("the axis of joint {} is {} that of joint {}, which may lock the mechanism",
                    line.joint->name, how, most->joint->name);
    if (std::find(notes.begin(), notes.end(), note) == notes.end()) notes.push_back(std::move(note));
  }
}

void add_universal_joints(const MultibodyModel& model, std::vector<std::string>& notes) {
  State placed;
  placed.q = model.q0;
  placed.v = placed.a = std::vector<double>(model.q0.size(), 0.0);
  for (const ModelJoint& joint : model.joints) {
    if (joint.kind != JointKind::universal) continue;
    const Eigen::Vector3d x = frame_motion(joint.a.frame, placed).rotation * joint.a.axes.col(2);
    const Eigen::Vector3d y = frame_motion(joint.b.frame, placed).rotation * joint.b.axes.col(2);
    const double angle = angle_between_lines(x, y);
    if (M_PI_2 - angle > kRounding)
      notes.push_back(fmt::format(
          "the axes of joint {} are {:.5g} degrees apart where bodies are placed, which are turned "
          "until they are perpendicular",
          joint.name, degrees(angle)));
  }
}

/// Around each mesh, along ground axes, m.
std::vector<Eigen::AlignedBox3d> boxes_of_meshes(const MultibodyModel& model) {
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const FlexibleBody& body : model.flexible_bodies) {
    Eigen::AlignedBox3d& box = boxes.emplace_back();
    for (int i = 0; i + 2 < body.range.count; i += 3)
      box.extend(
          Eigen::Map<const Eigen::Vector3d>(&model.q0[static_cast<std::size_t>(body.range.first + i)]));
  }
  return boxes;
}

/// Of the mesh that has these nodes, by their mean, the largest extent.
double extent_of_mesh(const std::vector<Eigen::AlignedBox3d>& boxes, const Eigen::Vector3d& mean) {
  const auto nearest = std::min_element(boxes.begin(), boxes.end(),
                                        [&](const Eigen::AlignedBox3d& a, const Eigen::AlignedBox3d& b) {
                                          return a.exteriorDistance(mean) < b.exteriorDistance(mean);
                                        });
  return nearest == boxes.end() ? 0.0 : nearest->sizes().maxCoeff();
}

void add_far_joints(const MultibodyModel& model, std::vector<std::string>& notes) {
  std::map<int, double> radius;  // of gyration, by the first coordinate of a body's frame
  for (const RigidPart& body : model.rigid_bodies)
    if (body.mass > 0) radius[body.frame.first] = std::sqrt(0.5 * body.inertia.trace() / body.mass);
  // Of a point from the centre of mass of the rigid body that has it; 0: there is none.
  const auto distance_in_radii = [&](const Attachment& side) {
    const auto of_body = radius.find(side.frame.first);
    return of_body == radius.end() ? 0.0 : side.point.norm() / of_body->second;
  };
  const std::vector<Eigen::AlignedBox3d> boxes = boxes_of_meshes(model);
  for (const ModelJoint& joint : model.joints) {
    const double nearer = std::min(distance_in_radii(joint.a), distance_in_radii(joint.b));
    if (nearer > kFar)
      notes.push_back(
          fmt::format("joint {} is {:.3g} radii of gyration and more away from both its bodies: "
                      "lengths may be in different units",
                      joint.name, nearer));
    for (const Attachment* side : {&joint.a, &joint.b}) {
      if (side->frame.is_ground() || radius.count(side->frame.first) != 0) continue;
      const Eigen::Map<const Eigen::Vector3d> mean(&model.q0[static_cast<std::size_t>(side->frame.first)]);
      const double extent = extent_of_mesh(boxes, mean), distance = side->point.norm();
      if (distance > kFarFromMesh * extent)
        notes.push_back(
            fmt::format("joint {} is {:.3g} m from the nodes that it holds, whose mesh is {:.3g} m long: "
                        "lengths may be in different units",
                        joint.name, distance, extent));
    }
  }
}

}  // namespace

std::vector<std::string> alignment_notes(const MultibodyModel& model, const std::vector<double>& q) {
  std::vector<std::string> notes;
  add_universal_joints(model, notes);
  add_far_joints(model, notes);
  State state;
  state.q = q;
  state.v = state.a = std::vector<double>(q.size(), 0.0);
  const std::vector<Line> lines = lines_of(model, state);
  if (!any_out_of_line(lines)) return notes;
  for (const std::set<std::string>& owners : nearly_redundant(*model.system, q)) {
    std::vector<Line> involved;
    for (const Line& line : lines)
      if (owners.count("joint " + line.joint->name) != 0) involved.push_back(line);
    if (!involved.empty()) add_notes(involved, notes);
  }
  return notes;
}

}  // namespace mfs::dae
