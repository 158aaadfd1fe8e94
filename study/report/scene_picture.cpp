#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "core/error.h"
#include "core/io/scenes_file.h"
#include "core/scene.h"
#include "generators/scenes/scenes.h"
#include "study/report/canvas.h"
#include "study/report/scenes.h"

namespace lcpbench::report {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPictureWidth = 300;
constexpr double kShortest = 110;
constexpr double kTallest = 300;
constexpr double kPictureMargin = 14;
constexpr int kCircle = 24;  ///< corners of the ends of cylinders

/// A shape where it stands.
struct Placed {
  const SceneShape* shape = nullptr;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  double radius = 0;  ///< of a ball around it; infinity: a plane
  bool moves = false;
};

/// Number of sizes of a shape type; 0 if the type is not drawn.
std::size_t measures(const SceneShape& shape) {
  if (shape.type == "sphere") return 1;
  if (shape.type == "capsule" || shape.type == "cylinder") return 2;
  if (shape.type == "box") return 3;
  return shape.type == "plane" ? 4 : 0;
}

double radius_of(const SceneShape& shape) {
  const std::vector<double>& size = shape.size;
  if (shape.type == "sphere") return size[0];
  if (shape.type == "capsule") return size[0] + size[1];
  if (shape.type == "cylinder") return std::hypot(size[0], size[1]);
  if (shape.type == "box") return Vector3d(size[0], size[1], size[2]).norm();
  return std::numeric_limits<double>::infinity();
}

std::vector<Placed> placed_shapes(const ScenesHeader& header, const SceneStep& step, const SceneStep& other) {
  std::vector<Placed> placed;
  for (const SceneShape& shape : header.shapes) {
    const std::size_t count = measures(shape);
    if (count == 0 || shape.size.size() != count) continue;
    Placed each{.shape = &shape, .radius = radius_of(shape)};
    if (shape.body >= 0) {
      const auto body = static_cast<std::size_t>(shape.body);
      if (body >= step.poses.size() || step.poses[body].size() != 7) continue;
      const std::vector<double>& pose = step.poses[body];
      each.pose = Eigen::Translation3d(pose[0], pose[1], pose[2]) *
                  Eigen::Quaterniond(pose[3], pose[4], pose[5], pose[6]).normalized();
      each.moves = body >= other.poses.size() || other.poses[body] != pose;
    }
    if (each.pose.matrix().allFinite() && !std::isnan(each.radius)) placed.push_back(each);
  }
  return placed;
}

/// Corner points in counterclockwise order (Andrew's monotone chain).
std::vector<Vector2d> convex_hull(std::vector<Vector2d> points) {
  const auto before = [](const Vector2d& a, const Vector2d& b) {
    return std::pair(a.x(), a.y()) < std::pair(b.x(), b.y());
  };
  std::sort(points.begin(), points.end(), before);
  std::vector<Vector2d> hull;
  for (int side = 0; side < 2; ++side) {
    const std::size_t start = hull.size();
    for (const Vector2d& point : points) {
      const auto turns_left = [&] {
        const Vector2d a = hull.back() - hull[hull.size() - 2];
        const Vector2d b = point - hull.back();
        return a.x() * b.y() - a.y() * b.x() > 0;
      };
      while (hull.size() >= start + 2 && !turns_left()) hull.pop_back();
      hull.push_back(point);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

/// A horizontal view along the slopes' contour lines; without slopes, along the scene's shorter side.
class SideView {
 public:
  SideView(const std::vector<Placed>& shapes, const std::vector<double>& gravity, const RigidScene* scene) {
    if (gravity.size() == 3) {
      const Vector3d down(gravity[0], gravity[1], gravity[2]);
      if (down.norm() > 0) up_ = -down.normalized();
    }
    across_ =
        std::abs(up_.x()) < 0.9 ? Vector3d((Vector3d::UnitX() - up_.x() * up_).normalized()) : up_.unitOrthogonal();
    const Vector3d other = up_.cross(across_);
    const double slopes = tilt(scene, across_);
    const double other_slopes = tilt(scene, other);
    const bool wider = extent(shapes, other) > extent(shapes, across_);
    if (std::max(slopes, other_slopes) > 4 * std::min(slopes, other_slopes) ? other_slopes > slopes : wider)
      across_ = other;
    frame(shapes);
  }

  /// True if no shape is of usual size.
  bool empty() const { return !(low_.x() <= high_.x()); }
  double width() const { return kPictureWidth; }
  double height() const { return height_; }
  double pixels_per_metre() const { return scale_; }
  Vector2d pixel(const Vector3d& point) const {
    const Vector2d p = seen(point);
    return {kPictureWidth / 2 + scale_ * (p.x() - centre_.x()), height_ / 2 - scale_ * (p.y() - centre_.y())};
  }

  std::string path(const Placed& placed) const {
    const std::vector<double>& size = placed.shape->size;
    const std::string& type = placed.shape->type;
    if (type == "sphere") return stadium(placed.pose.translation(), placed.pose.translation(), size[0]);
    if (type == "capsule") {
      return stadium(placed.pose * Vector3d(0, 0, -size[1]), placed.pose * Vector3d(0, 0, size[1]), size[0]);
    }
    return type == "plane" ? half_space(placed) : polygon(corners(placed));
  }

 private:
  static double median_radius(const std::vector<Placed>& shapes) {
    std::vector<double> radii;
    for (const Placed& placed : shapes) {
      if (std::isfinite(placed.radius)) radii.push_back(placed.radius);
    }
    std::sort(radii.begin(), radii.end());
    return median(radii);
  }

  static bool counts(const Placed& placed, double median_radius) { return placed.radius <= 4 * median_radius; }

  static double extent(const std::vector<Placed>& shapes, const Vector3d& axis) {
    const double usual = median_radius(shapes);
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (const Placed& placed : shapes) {
      if (!counts(placed, usual)) continue;
      const double at = axis.dot(placed.pose.translation());
      low = std::min(low, at - placed.radius);
      high = std::max(high, at + placed.radius);
    }
    return high - low;
  }

  /// How far the contacts' normals lean along an axis.
  static double tilt(const RigidScene* scene, const Vector3d& axis) {
    double sum = 0;
    if (scene == nullptr) return sum;
    for (const RigidContact& contact : scene->contacts) sum += std::pow(axis.dot(contact.normal), 2);
    return sum > 1e-3 * static_cast<double>(scene->contacts.size()) ? sum : 0;
  }

  Vector2d seen(const Vector3d& point) const { return {across_.dot(point), up_.dot(point)}; }

  static std::vector<Vector3d> corners(const Placed& placed) {
    const std::vector<double>& size = placed.shape->size;
    std::vector<Vector3d> points;
    if (placed.shape->type == "cylinder") {
      for (int i = 0; i < 2 * kCircle; ++i) {
        const double angle = 2 * std::numbers::pi * (i / 2) / kCircle;
        points.push_back(placed.pose * Vector3d(size[0] * std::cos(angle), size[0] * std::sin(angle),
                                                i % 2 == 0 ? size[1] : -size[1]));
      }
      return points;
    }
    for (int corner = 0; corner < 8; ++corner) {
      const auto side = [corner](int bit) { return (corner >> bit & 1) == 0 ? -1.0 : 1.0; };
      points.push_back(placed.pose * Vector3d(side(0) * size[0], side(1) * size[1], side(2) * size[2]));
    }
    return points;
  }

  void frame(const std::vector<Placed>& shapes) {
    const double usual = median_radius(shapes);
    const auto take = [this](const Vector2d& point, double around) {
      low_ = low_.cwiseMin(Vector2d(point.array() - around));
      high_ = high_.cwiseMax(Vector2d(point.array() + around));
    };
    for (const Placed& placed : shapes) {
      if (!counts(placed, usual)) continue;
      const std::string& type = placed.shape->type;
      if (type == "sphere" || type == "capsule") {
        const double half = type == "capsule" ? placed.shape->size[1] : 0;
        for (const double end : {-half, half}) take(seen(placed.pose * Vector3d(0, 0, end)), placed.shape->size[0]);
      } else {
        for (const Vector3d& corner : corners(placed)) take(seen(corner), 0);
      }
    }
    if (empty()) return;
    const Vector2d extent = (high_ - low_).cwiseMax(1e-9);
    centre_ = (low_ + high_) / 2;
    scale_ = std::min((kPictureWidth - 2 * kPictureMargin) / extent.x(), (kTallest - 2 * kPictureMargin) / extent.y());
    height_ = std::clamp(scale_ * extent.y() + 2 * kPictureMargin, kShortest, kTallest);
  }

  std::string polygon(const std::vector<Vector3d>& points) const {
    std::vector<Vector2d> pixels;
    for (const Vector3d& point : points) pixels.push_back(pixel(point));
    return closed(convex_hull(std::move(pixels)));
  }

  /// In tenths of a pixel, each point relative to the one before: films have thousands of bodies.
  static std::string closed(const std::vector<Vector2d>& points) {
    std::string path;
    std::array<long, 2> before{};
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (i < 2) path += i == 0 ? "M" : "l";
      for (std::size_t k = 0; k < 2; ++k) {
        const long tenths = std::lround(10 * points[i](static_cast<Eigen::Index>(k)));
        const std::string number = fmt::format("{:g}", static_cast<double>(tenths - before[k]) / 10);
        const bool apart = number.front() == '-' || path.back() == 'M' || path.back() == 'l';
        path += (apart ? "" : " ") + number;
        before[k] = tenths;
      }
    }
    return path + "z";
  }

  /// The outline of two discs of one radius and of all between them.
  std::string stadium(const Vector3d& from, const Vector3d& to, double radius) const {
    const Vector2d a = pixel(from);
    const Vector2d b = pixel(to);
    const double r = scale_ * radius;
    const Vector2d along = (b - a).norm() > 0 ? Vector2d((b - a).normalized()) : Vector2d::UnitX();
    const Vector2d side = r * Vector2d(-along.y(), along.x());
    const Vector2d p = a + side;
    const Vector2d q = a - side;
    const Vector2d s = b - side;
    const Vector2d t = b + side;
    return fmt::format(
        "M{:.1f} {:.1f}A{r:.1f} {r:.1f} 0 0 1 {:.1f} {:.1f}L{:.1f} {:.1f}A{r:.1f} {r:.1f} 0 0 1 {:.1f} {:.1f}z", p.x(),
        p.y(), q.x(), q.y(), s.x(), s.y(), t.x(), t.y(), fmt::arg("r", r));
  }

  /// The part of the picture below a plane that is seen from its edge; "" for others.
  std::string half_space(const Placed& placed) const {
    const std::vector<double>& size = placed.shape->size;
    const Vector3d normal = placed.pose.linear() * Vector3d(size[0], size[1], size[2]);
    const Vector2d facing(across_.dot(normal), up_.dot(normal));
    if (!(facing.norm() > 0.99 * normal.norm())) return "";
    const double offset = (size[3] + normal.dot(placed.pose.translation())) / facing.norm();
    const Vector2d n = facing.normalized();
    const Vector2d on = centre_ + (offset - n.dot(centre_)) * n;  // the nearest point of its edge
    const Vector2d along(-n.y(), n.x());
    const double reach = 2 * (kPictureWidth + kTallest) / scale_;
    std::vector<Vector2d> points;
    for (const Vector2d& at : {Vector2d(on - reach * along), Vector2d(on + reach * along),
                               Vector2d(on + reach * along - reach * n), Vector2d(on - reach * along - reach * n)}) {
      points.emplace_back(kPictureWidth / 2 + scale_ * (at.x() - centre_.x()),
                          height_ / 2 - scale_ * (at.y() - centre_.y()));
    }
    return closed(points);
  }

  Vector3d up_ = Vector3d::UnitZ();
  Vector3d across_ = Vector3d::UnitX();
  Vector2d low_ = Vector2d::Constant(std::numeric_limits<double>::infinity());
  Vector2d high_ = Vector2d::Constant(-std::numeric_limits<double>::infinity());
  Vector2d centre_ = Vector2d::Zero();
  double scale_ = 1;
  double height_ = kShortest;
};

/// A length of one digit, 1, 2 or 5, of about a quarter of the picture.
double scale_bar(double metres) {
  const double power = std::pow(10, std::floor(std::log10(metres / 4)));
  for (const double digit : {5.0, 2.0}) {
    if (digit * power <= metres / 4) return digit * power;
  }
  return power;
}

void draw_scale(const SideView& view, Canvas& canvas) {
  const double metres = scale_bar(view.width() / view.pixels_per_metre());
  const double left = 8;
  const double y = view.height() - 8;
  const double right = left + metres * view.pixels_per_metre();
  canvas.line(left, y, right, y, kInk, 2);
  canvas.text(right + 5, y - 1, fmt::format("{:g} m", metres), {.size = 11, .color = kInk});
}

std::shared_ptr<const ScenesFile> open_scene(const std::string& set) {
  constexpr std::string_view kFile = "file:";
  if (set.starts_with(kFile)) return std::make_shared<ScenesFile>(set.substr(kFile.size()));
  for (const CollectedScene& scene : collected_scenes()) {
    if (scene.name == set) return open_collected(scene);
  }
  return nullptr;
}

Figure draw_step(const ScenesHeader& header, const SceneStep& step, const std::vector<Placed>& shapes,
                 const SideView& view) {
  Canvas canvas(view.width(), view.height());
  for (const bool moves : {false, true}) {
    std::vector<std::string> paths;
    for (const Placed& placed : shapes) {
      if (placed.moves == moves) paths.push_back(view.path(placed));
    }
    std::erase(paths, "");
    canvas.bodies(paths, moves ? kPlain : kGrey);
  }
  if (const RigidScene* scene = step.problem.scene()) {
    std::vector<std::pair<double, double>> places;
    for (const RigidContact& contact : scene->contacts) {
      const Vector2d at = view.pixel(contact.point);
      places.emplace_back(at.x(), at.y());
    }
    canvas.dots(places, 2, kInk);
  }
  draw_scale(view, canvas);
  const std::string words =
      fmt::format("{}, step {}{}", header.scene, step.step, header.engine.empty() ? "" : " of " + header.engine);
  Figure figure;
  figure.alternative = words + ": the scene from the side.";
  figure.svg = canvas.draw(words, figure.alternative);
  return figure;
}

std::optional<Figure> draw_scene(const ScenesFile& file) {
  if (file.count() == 0) return std::nullopt;
  const ScenesHeader& header = file.header();
  const std::size_t middle = file.count() / 2;
  const SceneStep step = file.read(middle);
  const std::vector<Placed> shapes = placed_shapes(header, step, file.read(middle == 0 ? file.count() - 1 : 0));
  const SideView view(shapes, header.gravity, step.problem.scene());
  if (view.empty()) return std::nullopt;
  return draw_step(header, step, shapes, view);
}

}  // namespace

std::optional<Figure> scene_picture(const std::string& set) {
  try {
    const std::shared_ptr<const ScenesFile> file = open_scene(set);
    return file == nullptr ? std::nullopt : draw_scene(*file);
  } catch (const InputError&) {
    return std::nullopt;  // the user's file has changed, or is gone
  }
}

std::vector<Figure> filmstrip(const ScenesFile& file, const ScenesFile& view_of) {
  std::vector<Figure> figures;
  if (file.count() == 0 || view_of.count() == 0) return figures;
  const SceneStep first = view_of.read(0);
  const SceneStep last = view_of.read(view_of.count() - 1);
  const SideView view(placed_shapes(view_of.header(), first, last), view_of.header().gravity, first.problem.scene());
  if (view.empty()) return figures;
  const SceneStep end = file.read(file.count() - 1);
  for (std::size_t i = 0; i < file.count(); ++i) {
    const SceneStep step = file.read(i);
    // What moves is told by the poses: from the first step to the last, of the first step from the last.
    const std::vector<Placed> shapes = placed_shapes(file.header(), step, i == 0 ? end : first);
    figures.push_back(draw_step(file.header(), step, shapes, view));
  }
  return figures;
}

}  // namespace lcpbench::report
