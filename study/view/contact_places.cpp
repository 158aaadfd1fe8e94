#include "study/view/contact_places.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace lcpbench {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Places = std::vector<std::optional<ContactPlace>>;

constexpr double kUnitTolerance = 1e-6;  // of unit vectors, as engines in single precision keep them
constexpr double kSurface = 2e-3;        // [m] beyond the gap, that a contact may be off a surface
constexpr Index kBody = 6;

/// How the six coordinates of a body are ordered, and whose axes they are along: the world's or the body's.
struct Layout {
  int linear = 0;  ///< first of the linear ones; the angular ones are the other three
  bool linear_in_body = false;
  bool angular_in_body = false;
};
/// All in the world's axes; as MuJoCo's free joint has them; as DART's free joint has them.
constexpr Layout kLayouts[] = {{0, false, false}, {0, false, true}, {3, true, true}};

/// What a contact does to a body: its three columns of [N D] in the body's six rows.
struct Arm {
  std::size_t contact = 0;
  double gap = 0;
  Eigen::Matrix<double, kBody, 3> columns;

  Matrix3d linear(const Layout& layout) const { return columns.middleRows<3>(layout.linear); }
  Matrix3d angular(const Layout& layout) const { return columns.middleRows<3>(3 - layout.linear); }
  bool has_unit_directions(const Layout& layout) const {
    return (linear(layout).transpose() * linear(layout)).isIdentity(kUnitTolerance);
  }
};

Vector3d column(const Jacobian& J, Index row, Index of) {
  const auto entry = [&](Index i) {
    return std::visit([&](const auto& matrix) { return matrix.coeff(row + i, of); }, J);
  };
  return {entry(0), entry(1), entry(2)};
}

/// Of the contacts with two tangents, on the body whose six rows begin there.
std::vector<Arm> arms_of(const SceneStep& step, Index first_row) {
  const ContactProblem& problem = *step.problem.contact();
  const ContactLayout layout = contact_layout(problem);
  std::vector<Arm> arms;
  for (std::size_t c = 0; c < problem.edges.size(); ++c) {
    const int edges = problem.edges[c];
    if (edges == 0 || edges % 4 != 0) continue;
    const Index direction = layout.friction_begin[c];
    Arm arm{.contact = c, .gap = c < step.gap.size() ? std::abs(step.gap[c]) : 0};
    for (const Index half : {Index{0}, Index{3}}) {
      arm.columns.block<3, 1>(half, 0) = column(problem.N, first_row + half, static_cast<Index>(c));
      arm.columns.block<3, 1>(half, 1) = column(problem.D, first_row + half, direction);
      arm.columns.block<3, 1>(half, 2) = column(problem.D, first_row + half, direction + edges / 4);
    }
    arms.push_back(arm);
  }
  return arms;
}

/// A shape where it stands in the world.
struct Posed {
  const SceneShape* shape;
  Eigen::Isometry3d pose;
};

/// The distance of a point from a shape's surface, inside and outside; infinite for a shape of an unknown type.
double distance_to(const Posed& posed, const Vector3d& point) {
  const Vector3d p = posed.pose.inverse() * point;
  const std::vector<double>& size = posed.shape->size;
  const std::string& type = posed.shape->type;
  if (type == "sphere" && size.size() == 1) return std::abs(p.norm() - size[0]);
  if (type == "plane" && size.size() == 4) return std::abs(Vector3d(size[0], size[1], size[2]).dot(p) - size[3]);
  if (type == "capsule" && size.size() == 2) {
    return std::abs((p - Vector3d(0, 0, std::clamp(p.z(), -size[1], size[1]))).norm() - size[0]);
  }
  if ((type == "box" && size.size() == 3) || (type == "cylinder" && size.size() == 2)) {
    const bool box = type == "box";
    const Vector3d beyond = box ? Vector3d(p.cwiseAbs() - Vector3d(size[0], size[1], size[2]))
                                : Vector3d(std::hypot(p.x(), p.y()) - size[0], std::abs(p.z()) - size[1], -1e9);
    return std::abs(beyond.maxCoeff() > 0 ? beyond.cwiseMax(0).norm() : beyond.maxCoeff());
  }
  return std::numeric_limits<double>::infinity();
}

/// The pose of a body of the pictures; nullopt where it has none.
std::optional<Eigen::Isometry3d> pose_of(const std::vector<double>& numbers) {
  if (numbers.size() != 7) return std::nullopt;
  const Eigen::Quaterniond turn(numbers[3], numbers[4], numbers[5], numbers[6]);
  if (!(turn.norm() > 0)) return std::nullopt;
  return Eigen::Translation3d(numbers[0], numbers[1], numbers[2]) * turn.normalized();
}

bool touches_two(const std::vector<Posed>& shapes, const Vector3d& point, double within) {
  const auto near = [&](const Posed& each) { return distance_to(each, point) <= within; };
  return std::count_if(shapes.begin(), shapes.end(), near) >= 2;
}

/// The contact as seen from the body's position, if the body has these axes; nullopt where its moments are not those of
/// forces at one point. @pre arm.has_unit_directions(layout)
std::optional<ContactPlace> place_of(const Arm& arm, const Layout& layout, const Matrix3d& axes) {
  Matrix3d C = arm.linear(layout);
  Matrix3d moments = arm.angular(layout);
  if (layout.linear_in_body) C = axes * C;
  if (layout.angular_in_body) moments = axes * moments;
  const Matrix3d cross = moments * C.transpose();  // [r]x
  if (!((cross + cross.transpose()).norm() <= kUnitTolerance * (1 + cross.norm()))) return std::nullopt;
  return ContactPlace{{cross(2, 1), cross(0, 2), cross(1, 0)}, C.col(0), C.col(1), C.col(2)};
}

/// Finds the places of one body's contacts: among the poses it seeks one whose axes, and one whose position, put all of
/// them on two surfaces. O(arms poses^2 shapes) at worst.
void find_places(const std::vector<Arm>& all, const Layout& layout, const std::vector<Eigen::Isometry3d>& poses,
                 const std::vector<Posed>& shapes, Places& places) {
  std::vector<Arm> arms;
  for (const Arm& arm : all) {
    if (!places[arm.contact] && arm.has_unit_directions(layout)) arms.push_back(arm);
  }
  if (arms.empty()) return;
  for (const Eigen::Isometry3d& turned : poses) {
    std::vector<ContactPlace> found;
    for (const Arm& arm : arms) {
      const auto place = place_of(arm, layout, turned.rotation());
      if (!place) break;
      found.push_back(*place);
    }
    if (found.size() != arms.size()) continue;
    for (const Eigen::Isometry3d& from : poses) {
      bool fits = true;
      for (std::size_t i = 0; i < arms.size() && fits; ++i) {
        fits = touches_two(shapes, from.translation() + found[i].point, arms[i].gap + kSurface);
      }
      if (!fits) continue;
      for (std::size_t i = 0; i < arms.size(); ++i) {
        found[i].point += from.translation();
        places[arms[i].contact] = found[i];
      }
      return;
    }
  }
}

/// Where six rows of a body may begin: at a block of the inertia.
std::vector<Index> first_rows(const ContactProblem& problem) {
  std::vector<Index> rows{0};
  if (const auto* bodies = std::get_if<BlockInertia>(&problem.inertia)) {
    for (const Matrix& block : bodies->blocks) rows.push_back(rows.back() + block.rows());
  }
  std::erase_if(rows, [&](Index row) { return row + kBody > problem.ngc(); });
  return rows;
}

}  // namespace

Places contact_places(const ScenesHeader& header, const SceneStep& step) {
  Places places;
  if (const RigidScene* scene = step.problem.scene()) {
    for (const RigidContact& contact : scene->contacts) {
      places.push_back(
          ContactPlace{contact.point, contact.normal, contact.tangent, contact.normal.cross(contact.tangent)});
    }
    return places;
  }
  places.resize(static_cast<std::size_t>(step.problem.contact()->nc()));
  for (std::size_t c = 0; c < step.contact_frames.size(); ++c) {
    const std::vector<double>& frame = step.contact_frames[c];
    if (frame.empty()) continue;
    const Vector3d normal(frame[3], frame[4], frame[5]), tangent(frame[6], frame[7], frame[8]);
    places[c] = ContactPlace{{frame[0], frame[1], frame[2]}, normal, tangent, normal.cross(tangent)};
  }
  if (!step.contact_frames.empty()) return places;
  std::vector<Eigen::Isometry3d> poses;
  for (const std::vector<double>& numbers : step.poses) {
    if (const auto pose = pose_of(numbers)) poses.push_back(*pose);
  }
  std::vector<Posed> shapes;
  for (const SceneShape& shape : header.shapes) {
    const auto body = static_cast<std::size_t>(shape.body);
    std::optional<Eigen::Isometry3d> pose;
    if (shape.body < 0) pose = Eigen::Isometry3d::Identity();
    if (shape.body >= 0 && body < step.poses.size()) pose = pose_of(step.poses[body]);
    if (pose) shapes.push_back({&shape, *pose});
  }
  for (const Index row : first_rows(*step.problem.contact())) {
    const std::vector<Arm> arms = arms_of(step, row);
    for (const Layout& layout : kLayouts) find_places(arms, layout, poses, shapes, places);
  }
  return places;
}

}  // namespace lcpbench
