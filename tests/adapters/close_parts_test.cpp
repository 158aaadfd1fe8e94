// Contacts that a solver in the loop gets where parts are open by a hair.
#include "adapters/capture/close_parts.h"

#include <cmath>

#include <gtest/gtest.h>

namespace lcpbench::capture::close_parts_test {
namespace {

using Eigen::Vector3d;

/// A detection of overlaps for upright boxes that meet along z: the corners of the first one's lower face.
void corners(const PlacedPart& a, const PlacedPart& b, std::vector<Touch>& touches) {
  const double gap = a.centre.z() - a.size.z() - b.centre.z() - b.size.z();
  if (gap > 0) return;
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) {
      touches.push_back(
          {a.body, b.body, a.centre + Vector3d(x, y, -1).cwiseProduct(a.size), Vector3d::UnitZ(), gap});
    }
  }
}

/// A body of one part on the ground, whose top is at height 0.
std::vector<Touch> on_ground(const Part& part, const Vector3d& at) {
  Scene scene = capture::scene("s", "", 0.5);
  scene.bodies.push_back(solid({part}, 1, at));
  return close_parts(scene, part_poses(scene, {{scene.bodies[0].position, {1, 0, 0, 0}}, {at, {1, 0, 0, 0}}}), corners);
}

TEST(CloseParts, ABoxThatIsOpenByAHairTouchesWithItsCorners) {
  for (const double gap : {1e-13, 9e-5, 0.0, -1e-3}) {
    const std::vector<Touch> touches = on_ground(box(0.5, 0.4, 0.3), {2, 0, 0.3 + gap});
    ASSERT_EQ(touches.size(), 4U) << gap;
    for (const Touch& touch : touches) {
      EXPECT_NEAR(touch.gap, gap, 1e-15);
      EXPECT_NEAR(touch.point.z(), gap, 1e-15);
      EXPECT_NEAR(std::abs(touch.point.x() - 2), 0.5, 1e-15);
      EXPECT_NEAR(std::abs(touch.point.y()), 0.4, 1e-15);
      EXPECT_EQ(touch.normal, Vector3d(Vector3d::UnitZ()));
      EXPECT_EQ(touch.body_a, 1U);
    }
  }
  EXPECT_TRUE(on_ground(box(0.5, 0.4, 0.3), {2, 0, 0.3 + 1.1e-4}).empty());
}

TEST(CloseParts, BallsAreAsFarAsTheirClosedFormsSay) {
  for (const double gap : {1e-13, 9e-5, -0.01}) {
    const std::vector<Touch> touches = on_ground(sphere(0.2), {1, 0, 0.2 + gap});
    ASSERT_EQ(touches.size(), 1U);
    EXPECT_NEAR(touches[0].gap, gap, 1e-15);
    EXPECT_NEAR((touches[0].point - Vector3d(1, 0, 0)).norm(), 0, 1e-15);
    EXPECT_EQ(touches[0].normal, Vector3d(Vector3d::UnitZ()));
  }
  EXPECT_TRUE(on_ground(sphere(0.2), {1, 0, 0.2 + 1.1e-4}).empty());
  // Over an edge of the ground, which is 15 m wide; and with its centre below the face.
  const std::vector<Touch> edge = on_ground(sphere(0.2), {15.12, 0, 0.16});
  ASSERT_EQ(edge.size(), 1U);
  EXPECT_NEAR(edge[0].gap, 0, 1e-15);
  EXPECT_NEAR((edge[0].normal - Vector3d(0.6, 0, 0.8)).norm(), 0, 1e-14);
  const std::vector<Touch> sunk = on_ground(sphere(0.2), {1, 0, -0.05});
  ASSERT_EQ(sunk.size(), 1U);
  EXPECT_NEAR(sunk[0].gap, -0.25, 1e-15);
  EXPECT_EQ(sunk[0].normal, Vector3d(Vector3d::UnitZ()));

  Scene scene = capture::scene("s", "", 0.5);
  scene.bodies = {solid({sphere(0.3)}, 1, Vector3d::Zero()), solid({sphere(0.2)}, 1, {0.5 + 5e-5, 0, 0})};
  const std::vector<Touch> pair =
      close_parts(scene, part_poses(scene, {{{0, 0, 0}, {1, 0, 0, 0}}, {{0.5 + 5e-5, 0, 0}, {1, 0, 0, 0}}}), corners);
  ASSERT_EQ(pair.size(), 1U);
  EXPECT_NEAR(pair[0].gap, 5e-5, 1e-15);
  EXPECT_NEAR(pair[0].point.x(), 0.3 + 2.5e-5, 1e-15);
  EXPECT_EQ(pair[0].normal, Vector3d(Vector3d::UnitX())) << "from b into a, the later body";
}

TEST(CloseParts, PartsOfABodyOrOfTheWorldDoNotTouchEachOther) {
  Scene scene = capture::scene("s", "", 0.5);
  scene.bodies.push_back(fixed(sphere(0.5), {0, 0, 0.4}));
  scene.bodies.push_back(solid({sphere(0.5), sphere(0.5, {0.9, 0, 0})}, 1, {5, 0, 5}));
  std::vector<Pose> poses;
  for (const Body& body : scene.bodies) poses.push_back({body.position, body.orientation});
  EXPECT_TRUE(close_parts(scene, part_poses(scene, poses), corners).empty());
}

// Or the contact would stop what it ought to throw back.
TEST(CloseParts, AnOpenContactWaitsUntilItCanBounce) {
  Scene scene = capture::scene("s", "", 0.5);
  EXPECT_FALSE(waits_to_bounce(scene, 5e-5, -1));
  scene.restitution = 0.5;
  EXPECT_TRUE(waits_to_bounce(scene, 5e-5, -1));
  EXPECT_FALSE(waits_to_bounce(scene, 5e-5, -0.1));
  EXPECT_FALSE(waits_to_bounce(scene, -5e-5, -1));
}

}  // namespace
}  // namespace lcpbench::capture::close_parts_test
