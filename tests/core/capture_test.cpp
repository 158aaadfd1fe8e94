// What capture.h writes is what it was given; the example programs write files that can be read.

#include "examples/capture/capture.h"

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "core/io/problem_io.h"
#include "core/io/scenes_file.h"

namespace lcpbench::capture_test {
namespace {

namespace fs = std::filesystem;

class CaptureTest : public ::testing::Test {
 protected:
  CaptureTest() : file_(fs::temp_directory_path() / ("lcpbench-capture-" + std::to_string(::getpid()) + ".scenes")) {}
  ~CaptureTest() override { fs::remove(file_); }
  fs::path file_;
};

constexpr double kTilted[9] = {0.3, 0.01, 0, 0.010000000000000002, 0.2, 1e-17, 0, 0, 0.1};

RigidBody body() {
  RigidBody body;
  body.mass = 1.5;
  body.inertia << 0.3, 0.5 * kTilted[1] + 0.5 * kTilted[3], 0, 0.5 * kTilted[1] + 0.5 * kTilted[3], 0.2, 5e-18, 0,
      5e-18, 0.1;
  body.position = {0.1, 0.2, 0.5};
  body.linear_velocity = {1.0 / 3, 0, -0.1};
  body.angular_velocity = {0, 1e-9, 0};
  return body;
}

int add(lcpbench_capture* capture, const RigidBody& body) {
  return lcpbench_capture_body(capture, body.mass, kTilted, body.position.data(), body.linear_velocity.data(),
                               body.angular_velocity.data());
}

TEST_F(CaptureTest, BodiesAndContacts) {
  const double point[3] = {0.1, 0.2, 0}, up[3] = {0, 0, 1}, down[3] = {0, 0, -1}, tangent[3] = {0, 1, 0};
  const double rotation[4] = {1, 0, 0, 0}, half[3] = {0.5, 0.25, 0.125}, gravity[3] = {0, 0, -9.81};
  lcpbench_capture* capture = lcpbench_capture_open(file_.c_str(), "a \"scene\"\n", "engine", "1.0", 0.01);
  ASSERT_NE(capture, nullptr);
  lcpbench_capture_loop(capture, "auto");
  lcpbench_capture_gravity(capture, gravity);
  lcpbench_capture_shape(capture, 0, "box", half, 3);
  for (const long step : {3L, 120L}) {
    lcpbench_capture_step(capture, step, 0.01 * static_cast<double>(step));
    EXPECT_EQ(add(capture, body()), 0);
    EXPECT_EQ(add(capture, body()), 1);
    EXPECT_EQ(lcpbench_capture_contact(capture, 0, 1, point, up, tangent, 0.5, 4, 0.0, "0-1"), 0);
    EXPECT_EQ(lcpbench_capture_contact(capture, -1, 1, point, down, tangent, 0.25, 4, 0.0, nullptr), 1);
    EXPECT_EQ(lcpbench_capture_contact(capture, 1, -1, point, up, nullptr, 0.0, 0, 0.5, nullptr), 2);
    for (int contact = 0; contact < 3; ++contact) {
      lcpbench_capture_gap(capture, contact, -1e-3 * contact);
      lcpbench_capture_impulse(capture, contact, 1 + contact, 0.25, -0.125);
    }
    lcpbench_capture_pose(capture, 1, point, rotation);
    if (step == 120) {
      lcpbench_capture_note(capture, "\"springs\": 2");
      lcpbench_capture_note(capture, "belts: 1");
    }
    lcpbench_capture_end_step(capture);
  }
  EXPECT_EQ(lcpbench_capture_close(capture), 0);

  const ScenesFile scenes(file_.string());
  EXPECT_EQ(scenes.read(scenes.index_of(3)).notes.size(), 0U);
  EXPECT_EQ(scenes.header().scene, "a \"scene\" ");
  EXPECT_EQ(scenes.header().engine_version, "1.0");
  EXPECT_EQ(scenes.header().loop, "auto");
  EXPECT_EQ(scenes.header().step_length, 0.01);
  EXPECT_EQ(scenes.header().gravity, (std::vector<double>{0, 0, -9.81}));
  ASSERT_EQ(scenes.header().shapes.size(), 1u);
  EXPECT_EQ(scenes.header().shapes[0].size, (std::vector<double>{0.5, 0.25, 0.125}));
  const SceneStep step = scenes.read(scenes.index_of(120));

  RigidScene expected;
  expected.bodies = {body(), body()};
  const auto contact = [&](int a, int b, Eigen::Vector3d t, double mu, int edges) {
    expected.contacts.push_back({a, b, {0.1, 0.2, 0}, {0, 0, 1}, t, mu, edges});
  };
  contact(0, 1, {0, 1, 0}, 0.5, 4);
  contact(1, -1, {0, -1, 0}, 0.25, 4);  // given as the world against body 1: turned round
  contact(1, -1, {1, 0, 0}, 0, 0);
  expected.contacts.back().b = 0.5;
  EXPECT_EQ(problem_hash(step.problem), problem_hash(Problem("p", expected)));
  EXPECT_EQ(step.gap, (std::vector<double>{0, -1e-3, -2e-3}));
  EXPECT_EQ(step.notes, (std::vector<std::string>{"\"springs\": 2", "belts: 1"}));
  EXPECT_EQ(step.contact_ids, (std::vector<std::string>{"0-1", "", ""}));
  ASSERT_EQ(step.poses.size(), 2u);
  EXPECT_TRUE(step.poses[0].empty());
  EXPECT_EQ(step.poses[1], (std::vector<double>{0.1, 0.2, 0, 1, 0, 0, 0}));
  Vector impulses(11);
  impulses << 1, 2, 3, 0.25, 0, 0, 0.125, 0.25, 0.125, 0, 0;  // the turned contact's second tangent is turned too
  EXPECT_EQ(step.engine_impulses, impulses);
}

TEST_F(CaptureTest, RowsBecomePyramids) {
  const double G[9] = {2, 0, 0, 0, 2, 0, 0, 0, 2}, v[3] = {0, 0, -1}, normal[1] = {1};
  const double x[2] = {1, 0}, y[2] = {0, 1};
  const int up[1] = {2};
  lcpbench_capture* capture = lcpbench_capture_open(file_.c_str(), "point", "engine", "1", 0.01);
  lcpbench_capture_step(capture, 0, 0);
  lcpbench_capture_block(capture, 3, G, v);
  lcpbench_capture_rows(capture, 1, up, normal, nullptr, nullptr, 0, 8, 0.25, nullptr);
  const int all[3] = {0, 1, 2};
  const double n3[3] = {0, 0, 1}, x3[3] = {x[0], x[1], 0}, y3[3] = {y[0], y[1], 0};
  for (const int edges : {2, 4, 8, 16}) lcpbench_capture_rows(capture, 3, all, n3, x3, y3, 0.5, edges, 0.0, nullptr);
  for (int contact = 0; contact < 5; ++contact) lcpbench_capture_impulse(capture, contact, 1, 0.3, -0.4);
  lcpbench_capture_frame(capture, 3, v, n3, x3);
  lcpbench_capture_solve_time(capture, 2.5e-4);
  lcpbench_capture_end_step(capture);
  EXPECT_EQ(lcpbench_capture_close(capture), 0);

  const SceneStep step = ScenesFile(file_.string()).read(0);
  EXPECT_EQ(step.engine_solve_s, 2.5e-4);
  const std::vector<std::vector<double>> frames{{}, {}, {}, {0, 0, -1, 0, 0, 1, 1, 0, 0}, {}};
  EXPECT_EQ(step.contact_frames, frames);
  EXPECT_EQ(step.problem.engine_answer()->solve_s, 2.5e-4);
  EXPECT_EQ(step.problem.engine_answer()->engine, "engine 1");
  const ContactProblem& problem = *step.problem.contact();
  EXPECT_EQ(problem.edges, (std::vector<int>{0, 2, 4, 8, 16}));
  EXPECT_EQ(problem.b, (Vector{{0.25, 0, 0, 0, 0}}));
  EXPECT_TRUE(std::holds_alternative<BlockInertia>(problem.inertia));
  const Matrix D = to_dense(problem.D);
  EXPECT_EQ(D.col(2), Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(D.col(3), Eigen::Vector3d(0, 1, 0));
  const ContactLayout layout = contact_layout(problem);
  for (std::size_t contact = 1; contact < 5; ++contact) {
    SCOPED_TRACE(problem.edges[contact]);
    const Index begin = layout.friction_begin[contact];
    const Index edges = problem.edges[contact];
    const Vector shares = step.engine_impulses.segment(layout.nc + begin, edges);
    EXPECT_GE(shares.minCoeff(), 0);
    EXPECT_LE((shares.array() > 0).count(), 2);
    // The edges' impulses make up the friction; two edges have its first part alone.
    const Vector friction = D.middleCols(begin, edges) * shares;
    EXPECT_NEAR(friction(0), 0.3, 1e-15);
    EXPECT_NEAR(friction(1), edges == 2 ? 0 : -0.4, 1e-15);
    for (Index t = 0; t < edges; ++t) {
      const double angle = 2 * 3.141592653589793 * static_cast<double>(t) / static_cast<double>(edges);
      EXPECT_NEAR(D(0, begin + t), std::cos(angle), 1e-15);
      EXPECT_NEAR(D(1, begin + t), std::sin(angle), 1e-15);
    }
  }
}

TEST_F(CaptureTest, BoundedRowsStandBesideContacts) {
  const double G[4] = {2, 0, 0, 3}, v[2] = {1, -1}, both[2] = {1, -0.5}, one[1] = {1};
  const int all[2] = {0, 1}, first[1] = {0}, second[1] = {1};
  lcpbench_capture* capture = lcpbench_capture_open(file_.c_str(), "arm", "engine", "1", 0.01);
  for (const int step : {0, 1, 2}) {
    lcpbench_capture_step(capture, step, 0);
    lcpbench_capture_block(capture, 2, G, v);
    if (step < 2) lcpbench_capture_rows(capture, 1, second, one, one, nullptr, 0.5, 2, 0, nullptr);
    EXPECT_EQ(lcpbench_capture_row(capture, 2, all, both, -INFINITY, INFINITY, 0.25, 1e-3, "m", "rod"), 0);
    EXPECT_EQ(lcpbench_capture_row(capture, 1, first, one, 0, 1e300, 0, 0, "rad", nullptr), 1);
    EXPECT_EQ(lcpbench_capture_row(capture, 1, first, one, -1, 0.1, 0, 0, nullptr, "screw \"a\""), 2);
    lcpbench_capture_row_friction(capture, 1, 0.3);
    if (step < 2) lcpbench_capture_impulse(capture, 0, 1, 0.5, 0);
    for (int row = 0; row < (step == 1 ? 2 : 3); ++row) lcpbench_capture_row_impulse(capture, row, 0.1 * row);
    lcpbench_capture_end_step(capture);
  }
  EXPECT_EQ(lcpbench_capture_close(capture), 0);

  const ScenesFile scenes(file_.string());
  const SceneStep step = scenes.read(0);
  const BoundedRows& rows = step.problem.contact()->rows;
  EXPECT_EQ(to_dense(rows.R), (Matrix{{1, 1, 1}, {-0.5, 0, 0}}));
  EXPECT_EQ(rows.bounds.lower, (Vector{{-INFINITY, 0, -INFINITY}}));
  EXPECT_EQ(rows.bounds.upper, (Vector{{INFINITY, INFINITY, INFINITY}}));
  EXPECT_EQ(rows.bounds.friction_of, (std::vector<int>{-1, -1, 1}));
  EXPECT_EQ(rows.bounds.mu, (Vector{{0, 0, 0.3}}));
  EXPECT_EQ(rows.b, (Vector{{0.25, 0, 0}}));
  EXPECT_EQ(rows.compliance, (Vector{{1e-3, 0, 0}}));
  EXPECT_EQ(rows.is_angle, (std::vector<char>{0, 1, 0}));
  EXPECT_EQ(rows.names, (std::vector<std::string>{"rod", "", "screw \"a\""}));
  EXPECT_EQ(step.engine_impulses, (Vector{{1, 0.5, 0, 0, 0.1, 0.2}}));
  EXPECT_EQ(scenes.read(1).engine_impulses.size(), 0) << "a row has none";
  EXPECT_EQ(scenes.read(2).engine_impulses, (Vector{{0, 0.1, 0.2}})) << "rows alone";
}

TEST_F(CaptureTest, WrongBoundedRowsAreTold) {
  const double one = 1, nan = std::nan("");
  const int zero = 0, beyond = 1;
  const auto told = [&](auto&& give) {
    lcpbench_capture* capture = lcpbench_capture_open(file_.c_str(), "mistakes", "engine", "1", 0.01);
    lcpbench_capture_step(capture, 7, 0);
    lcpbench_capture_block(capture, 1, &one, &one);
    ::testing::internal::CaptureStderr();
    give(capture);
    lcpbench_capture_end_step(capture);
    EXPECT_NE(lcpbench_capture_close(capture), 0);
    EXPECT_EQ(ScenesFile(file_.string()).count(), 0u);
    const std::string text = ::testing::internal::GetCapturedStderr();
    return text.substr(0, text.find('\n'));
  };
  const auto row = [&](lcpbench_capture* c, double lower, double upper, double b = 0, double compliance = 0,
                       const char* unit = "m") {
    lcpbench_capture_row(c, 1, &zero, &one, lower, upper, b, compliance, unit, nullptr);
  };
  const std::string step = "lcpbench_capture: step 7: ", bounds = "needs lower <= 0 <= upper, not both 0";
  EXPECT_EQ(told([&](auto* c) { row(c, 0, 1), row(c, 0, 0); }), step + "rows[1]: " + bounds);
  EXPECT_EQ(told([&](auto* c) { row(c, 1, 2); }), step + "rows[0]: " + bounds);
  EXPECT_EQ(told([&](auto* c) { row(c, -1, nan); }), step + "rows[0]: " + bounds);
  EXPECT_EQ(told([&](auto* c) { row(c, 0, 1, nan); }), step + "rows[0]: b is not finite");
  EXPECT_EQ(told([&](auto* c) { row(c, 0, 1, 0, -1); }), step + "rows[0]: compliance is no number >= 0");
  EXPECT_EQ(told([&](auto* c) { row(c, 0, 1, 0, HUGE_VAL); }), step + "rows[0]: compliance is no number >= 0");
  EXPECT_EQ(told([&](auto* c) { row(c, 0, 1, 0, 0, "deg"); }), step + "rows[0]: unit is neither m nor rad");
  EXPECT_EQ(told([&](auto* c) { lcpbench_capture_row(c, 1, &zero, &nan, 0, 1, 0, 0, "m", "a"); }),
            step + "rows[0].direction is not finite");
  EXPECT_EQ(told([&](auto* c) { lcpbench_capture_row(c, 1, &beyond, &one, 0, 1, 0, 0, "m", "a"); }),
            step + "a coordinate of no block; blocks are given before rows");
  EXPECT_EQ(told([&](auto* c) { row(c, 0, 1), lcpbench_capture_row_impulse(c, 0, nan); }),
            step + "rows[0].impulse is not finite");
  EXPECT_EQ(told([&](auto* c) { row(c, 0, 1), lcpbench_capture_row_impulse(c, 1, 1); }),
            step + "no such bounded row in this step");
  const std::string friction = step + "friction of a row needs an earlier row whose lower bound is 0";
  EXPECT_EQ(told([&](auto* c) { lcpbench_capture_row_friction(c, 0, 1); }), friction);
  EXPECT_EQ(told([&](auto* c) { row(c, 0, 1), lcpbench_capture_row_friction(c, 0, 1); }), friction);
  EXPECT_EQ(told([&](auto* c) { row(c, -1, 1), row(c, -1, 1), lcpbench_capture_row_friction(c, 0, 1); }), friction);
  EXPECT_EQ(told([&](auto* c) { row(c, 0, 1), row(c, -1, 1), lcpbench_capture_row_friction(c, 0, -1); }),
            step + "friction of a row needs mu >= 0");
  lcpbench_capture* capture = lcpbench_capture_open(file_.c_str(), "mistakes", "engine", "1", 0.01);
  lcpbench_capture_step(capture, 7, 0);
  add(capture, body());
  ::testing::internal::CaptureStderr();
  row(capture, 0, 1);
  EXPECT_EQ(::testing::internal::GetCapturedStderr(),
            step + "rows[0]: rows and bodies in one step: give the bodies as blocks\n");
  EXPECT_NE(lcpbench_capture_close(capture), 0);
  EXPECT_EQ(lcpbench_capture_row(nullptr, 1, &zero, &one, 0, 1, 0, 0, "m", nullptr), -1);
}

// What is wrong in one step leaves that step out and is told at the end; the others are kept.
TEST_F(CaptureTest, MistakesAreToldAndDoNotSpoilTheFile) {
  const double point[3] = {0, 0, 0}, up[3] = {0, 0, 1};
  RigidBody broken = body();
  broken.mass = std::nan("");
  lcpbench_capture* capture = lcpbench_capture_open(file_.c_str(), "mistakes", "engine", "1", 0.01);
  ::testing::internal::CaptureStderr();
  for (int step = 0; step < 4; ++step) {
    lcpbench_capture_step(capture, step, 0);
    if (step == 1) add(capture, body());
    add(capture, step == 1 ? broken : body());
    if (step == 2) lcpbench_capture_contact(capture, 0, 7, point, up, nullptr, 0, 0, 0, nullptr);
    lcpbench_capture_end_step(capture);
  }
  EXPECT_NE(lcpbench_capture_close(capture), 0);
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "lcpbench_capture: step 1: bodies[1].mass is not finite\n");
  const ScenesFile scenes(file_.string());
  ASSERT_EQ(scenes.count(), 2u);
  EXPECT_EQ(scenes.step_number(1), 3);
  EXPECT_EQ(lcpbench_capture_open("/nonexistent/x.scenes", "s", "e", "1", 0.01), nullptr);
  EXPECT_EQ(lcpbench_capture_body(nullptr, 1, kTilted, point, point, point), -1);
  EXPECT_NE(lcpbench_capture_close(nullptr), 0);
}

TEST_F(CaptureTest, TheNumberThatIsNotFiniteIsNamed) {
  const double nan = std::nan(""), broken[3] = {0, 0, nan}, up[3] = {0, 0, 1}, side[3] = {1, 0, 0};
  const auto told = [&](bool bodies, auto&& give) {
    lcpbench_capture* capture = lcpbench_capture_open(file_.c_str(), "mistakes", "engine", "1", 0.01);
    lcpbench_capture_step(capture, 7, 0);
    ::testing::internal::CaptureStderr();
    if (bodies) add(capture, body());
    give(capture);
    lcpbench_capture_end_step(capture);
    lcpbench_capture_close(capture);
    const std::string text = ::testing::internal::GetCapturedStderr();
    return text.substr(0, text.find('\n'));
  };
  const auto contact = [&](lcpbench_capture* c, const double* normal, double b) {
    lcpbench_capture_contact(c, 0, -1, up, normal, side, 0.5, 4, b, nullptr);
  };
  const std::string step = "lcpbench_capture: step 7: ";
  EXPECT_EQ(told(true, [&](auto* c) { contact(c, up, 0), contact(c, broken, 0); }),
            step + "contacts[1].normal is not finite");
  EXPECT_EQ(told(true, [&](auto* c) { contact(c, up, nan); }), step + "contacts[0].b is not finite");
  EXPECT_EQ(told(true, [&](auto* c) { contact(c, up, 0), lcpbench_capture_impulse(c, 0, nan, 0, 0); }),
            step + "contacts[0].impulse is not finite");
  EXPECT_EQ(told(true, [&](auto* c) { lcpbench_capture_pose(c, 0, broken, kTilted); }), step + "poses is not finite");
  const double one = 1;
  const int first = 0;
  EXPECT_EQ(told(false, [&](auto* c) { lcpbench_capture_block(c, 1, &nan, &one); }),
            step + "blocks[0].G is not finite");
  EXPECT_EQ(told(false, [&](auto* c) { lcpbench_capture_block(c, 1, &one, &nan); }),
            step + "blocks[0].v is not finite");
  EXPECT_EQ(told(false,
                 [&](auto* c) {
                   lcpbench_capture_block(c, 1, &one, &one);
                   lcpbench_capture_rows(c, 1, &first, &nan, nullptr, nullptr, 0, 0, 0, nullptr);
                 }),
            step + "contacts[0].normal is not finite");
}

// A file of steps that descend could not be opened at all, nor one whose header has a number missing.
TEST_F(CaptureTest, MistakesInTheOrderOfStepsAndInTheHeaderDoNotSpoilTheFile) {
  const double broken[3] = {0, 0, std::nan("")}, half[3] = {1, 1, 1};
  lcpbench_capture* capture = lcpbench_capture_open(file_.c_str(), "mistakes", "engine", "1", HUGE_VAL);
  lcpbench_capture_gravity(capture, broken);
  lcpbench_capture_shape(capture, 0, "plane", broken, 3);
  lcpbench_capture_shape(capture, 0, "hull", half, 3);
  lcpbench_capture_shape(capture, 1, "box", half, 3);
  for (const long step : {-1L, 5L, 3L, 4L, 6L}) {
    lcpbench_capture_step(capture, step, 0);
    add(capture, body());
    lcpbench_capture_end_step(capture);
  }
  EXPECT_NE(lcpbench_capture_close(capture), 0);
  const ScenesFile scenes(file_.string());
  EXPECT_EQ(scenes.header().step_length, std::nullopt);
  EXPECT_TRUE(scenes.header().gravity.empty());
  ASSERT_EQ(scenes.header().shapes.size(), 1u);
  EXPECT_EQ(scenes.header().shapes[0].body, 1);
  ASSERT_EQ(scenes.count(), 2u);
  EXPECT_EQ(scenes.step_number(0), 5);
  EXPECT_EQ(scenes.step_number(1), 6);
}

TEST_F(CaptureTest, AStepWithoutItsEndIsTold) {
  lcpbench_capture* capture = lcpbench_capture_open(file_.c_str(), "mistakes", "engine", "1", 0.01);
  lcpbench_capture_step(capture, 0, 0);
  lcpbench_capture_step(capture, 1, 0);
  lcpbench_capture_end_step(capture);
  EXPECT_NE(lcpbench_capture_close(capture), 0);
  EXPECT_EQ(ScenesFile(file_.string()).count(), 1u);
}

TEST_F(CaptureTest, TheExamplesRun) {
  std::istringstream programs(CAPTURE_EXAMPLES);
  for (std::string program; std::getline(programs, program, ':');) {
    SCOPED_TRACE(program);
    ASSERT_EQ(std::system((program + " " + file_.string()).c_str()), 0);
    const ScenesFile scenes(file_.string());
    EXPECT_GE(scenes.count(), 40u);
    Index contacts = 0;
    for (std::size_t i = 0; i < scenes.count(); ++i) contacts += scenes.read(i).problem.contact()->nc();
    EXPECT_GT(contacts, 40);
    EXPECT_EQ(scenes.truncation(), "");
  }
}

}  // namespace
}  // namespace lcpbench::capture_test
