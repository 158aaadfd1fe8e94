// Scenes files out and in again, cut off, damaged, compressed or plain; and sparse problems, which they are made of.

#include "core/io/scenes_file.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "core/error.h"
#include "core/io/problem_io.h"
#include "generators/scenes/scenes.h"
#include "generators/sets.h"

namespace lcpbench::scenes_file_test {
namespace {

namespace fs = std::filesystem;

const std::string kHeader = R"({"format":"lcpbench-scenes","version":1,"scene":"test"})";
const std::string kProblem =
    R"("problem":{"format":"lcpbench-problem","version":1,"name":"p","kind":"contact","v":[-1,0],)"
    R"("N":{"starts":[0,1],"rows":[0],"values":[1]},"G_blocks":[[[2]],[[3]]]})";

std::string plain_line(int step) { return R"({"step":)" + std::to_string(step) + "," + kProblem + "}"; }

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

template <class F>
std::string error_of(F&& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

/// Two blocks of two coordinates, a contact of each with four edges, and one without.
ContactProblem sparse_problem(double speed) {
  ContactProblem problem;
  problem.v = Vector{{-speed, 0.25, -0.5, 1e-300}};
  SparseMatrix N(4, 3);
  N.insert(0, 0) = 1;
  N.insert(2, 1) = 1.0 / 3;
  N.insert(3, 2) = -1;
  SparseMatrix D(4, 8);
  for (int contact = 0; contact < 2; ++contact) {
    const int row = 2 * contact;
    D.insert(row + 1, 4 * contact) = 1;
    D.insert(row, 4 * contact + 1) = 0.1;
    D.insert(row + 1, 4 * contact + 2) = -1;
    D.insert(row, 4 * contact + 3) = -0.1;
  }
  N.makeCompressed();
  D.makeCompressed();
  problem.N = N;
  problem.D = D;
  problem.edges = {4, 4, 0};
  problem.mu = Vector{{0.5, 0.25, 0}};
  problem.inertia = BlockInertia{{Matrix{{2, 0.5}, {0.5, 1}}, Matrix{{3, 0}, {0, 4}}}};
  return problem;
}

SceneStep step_of(int number) {
  SceneStep step;
  step.step = number;
  step.time = 0.1 * number;
  step.problem = Problem("step", sparse_problem(1.0 / (1 + number)));
  step.gap = {-1e-3, 0.0, 0.5};
  step.contact_ids = {"a", "\"b\" \\", ""};
  step.poses = {{0, 0, 1, 1, 0, 0, 0}, {}};
  step.notes = {"left \"out\": 3"};
  step.engine_impulses = Vector::LinSpaced(11, 0.0, 1.0);
  step.engine_velocity = Vector{{0, 0.25, 0, 1e-300}};
  return step;
}

class ScenesFileTest : public ::testing::Test {
 protected:
  ScenesFileTest() : folder_(fs::temp_directory_path() / ("lcpbench-scenes-" + std::to_string(::getpid()))) {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~ScenesFileTest() override { fs::remove_all(folder_); }

  std::string path(const std::string& name = "t.scenes") const { return (folder_ / name).string(); }

  std::string write(const std::string& bytes) const {
    std::ofstream(path(), std::ios::binary | std::ios::trunc) << bytes;
    return path();
  }

  std::string written(int steps) const {
    ScenesWriter writer(path(), {.scene = "test", .engine = "none", .gravity = {0, 0, -9.81}});
    for (int i = 0; i < steps; ++i) writer.add(step_of(10 * i));
    writer.close();
    std::ostringstream bytes;
    bytes << std::ifstream(path(), std::ios::binary).rdbuf();
    return bytes.str();
  }

  /// The error of a file whose second line is this, without the file's name.
  std::string error_of_line(const std::string& line) const {
    const std::string file = write(kHeader + "\n" + line + "\n");
    const std::string error = error_of([&] { ScenesFile(file).read(0); });
    return error.starts_with(file) ? error.substr(file.size() + 2) : error;
  }

  fs::path folder_;
};

void expect_equal(const SceneStep& read, const SceneStep& expected) {
  EXPECT_EQ(read.step, expected.step);
  EXPECT_EQ(read.time, expected.time);
  EXPECT_EQ(problem_hash(read.problem), problem_hash(expected.problem));
  EXPECT_EQ(read.gap, expected.gap);
  EXPECT_EQ(read.contact_ids, expected.contact_ids);
  EXPECT_EQ(read.poses, expected.poses);
  EXPECT_EQ(read.notes, expected.notes);
  EXPECT_EQ(read.engine_impulses, expected.engine_impulses);
  EXPECT_EQ(read.engine_velocity, expected.engine_velocity);
}

TEST_F(ScenesFileTest, ComesBackEqualAndInAnyOrder) {
  written(20);
  const ScenesFile scenes(path());
  EXPECT_EQ(scenes.header().scene, "test");
  EXPECT_EQ(scenes.header().gravity, (std::vector<double>{0, 0, -9.81}));
  EXPECT_EQ(scenes.truncation(), "");
  ASSERT_EQ(scenes.count(), 20u);
  for (const int i : {0, 19, 7, 8, 3, 3}) expect_equal(scenes.read(static_cast<std::size_t>(i)), step_of(10 * i));
  EXPECT_EQ(scenes.index_of(190), 19u);
  EXPECT_EQ(error_of([&] { scenes.index_of(95); }),
            path() + ": has no step 95; the one before is 90; the next one is 100");
}

TEST_F(ScenesFileTest, HeadersThatCouldNotBeReadAgainAreNotWritten) {
  const auto error_with = [&](const ScenesHeader& header) { return error_of([&] { ScenesWriter(path(), header); }); };
  EXPECT_EQ(error_with({.scene = "test", .step_length = std::nan("")}),
            path() + ": step_length has nan, expected finite numbers");
  EXPECT_EQ(error_with({.scene = "test", .gravity = {0, 0, -INFINITY}}),
            path() + ": gravity has -inf, expected finite numbers");
  EXPECT_EQ(error_with({.scene = "test", .gravity = {0, -9.81}}), path() + ": gravity: 2 entries, expected 3");
  EXPECT_EQ(error_with({.scene = "\xFF"}), path() + ": scene: not UTF-8");
  EXPECT_EQ(error_with({.scene = "test", .shapes = {{.body = 0, .type = "box", .size = {1, std::nan(""), 1}}}}),
            path() + ": shapes: size has nan, expected finite numbers");
}

TEST_F(ScenesFileTest, AHullHasThreeNumbersForEachOf4To256Corners) {
  const auto error_with = [&](std::size_t entries) {
    const ScenesHeader header = {
        .scene = "test", .shapes = {{0, "ball", {1}}, {0, "hull", std::vector<double>(entries, 0.5)}}};
    return error_of([&] { ScenesWriter(path(), header).close(); });
  };
  for (const std::size_t good : {12U, 15U, 768U}) {
    EXPECT_EQ(error_with(good), "no error");
    EXPECT_EQ(ScenesFile(path()).header().shapes[1].size.size(), good);
  }
  const std::string wanted = " entries, expected three for each of 4 to 256 corners of the hull";
  for (const std::size_t bad : {0U, 9U, 13U, 771U}) {
    EXPECT_EQ(error_with(bad), path() + ": shapes: size: " + std::to_string(bad) + wanted);
  }
  write(R"({"format":"lcpbench-scenes","version":1,"scene":"s","shapes":[{"body":0,"type":"hull","size":[1,2,3]}]})");
  EXPECT_EQ(error_of([&] { ScenesFile{path()}; }), path() + ": line 1: shapes[0].size: 3" + wanted);
}

TEST_F(ScenesFileTest, StepsThatCouldNotBeReadAgainAreNotWritten) {
  ScenesWriter writer(path(), {.scene = "test"});
  writer.add(step_of(5));
  const auto error_of_step = [&](const SceneStep& step) { return error_of([&] { writer.add(step); }); };
  EXPECT_EQ(error_of_step(step_of(5)), path() + ": step 5: numbers start at 0 and ascend");
  EXPECT_EQ(error_of_step(step_of(-1)), path() + ": step -1: numbers start at 0 and ascend");
  SceneStep blown_up = step_of(6);
  blown_up.engine_velocity = Vector::Constant(blown_up.problem.contact()->ngc(), std::nan(""));
  EXPECT_EQ(error_of_step(blown_up), "step 6: engine.velocity has nan, expected finite numbers");
  SceneStep named = step_of(6);
  named.contact_ids.assign(static_cast<std::size_t>(named.problem.contact()->nc()), "\xFF");
  EXPECT_EQ(error_of_step(named), "step 6: contact_ids: not UTF-8");
  const auto error_with = [&](const auto& change) {
    SceneStep step = step_of(6);
    change(step);
    return error_of_step(step);
  };
  EXPECT_EQ(error_with([](SceneStep& step) { step.gap.pop_back(); }), "step 6: gap: 2 entries, expected 3");
  EXPECT_EQ(error_with([](SceneStep& step) { step.contact_ids.pop_back(); }),
            "step 6: contact_ids: 2 entries, expected 3");
  EXPECT_EQ(error_with([](SceneStep& step) { step.poses[0].pop_back(); }), "step 6: poses: 6 entries, expected 7");
  EXPECT_EQ(error_with([](SceneStep& step) { step.notes[0] = "\xff"; }), "step 6: notes: not UTF-8");
  EXPECT_EQ(error_with([](SceneStep& step) { step.engine_impulses = Vector::Zero(3); }),
            "step 6: engine.impulses: 3 entries, expected 11");
  EXPECT_EQ(error_with([](SceneStep& step) { step.engine_velocity = Vector::Zero(3); }),
            "step 6: engine.velocity: 3 entries, expected 4");
  EXPECT_EQ(error_with([](SceneStep& step) { step.problem = Problem("bare", step.problem.lcp()); }),
            "step 6: problem: is a bare LCP, expected one with contacts");
  EXPECT_EQ(error_with([](SceneStep& step) { step.step = (std::int64_t{1} << 53) + 1; }),
            "step 9007199254740993: numbers are from 0 to 2^53");
  const std::string long_line = error_with([](SceneStep& step) { step.contact_ids[0].assign(1U << 28, 'a'); });
  EXPECT_TRUE(long_line.starts_with("step 6: a line of 268")) << long_line;
  writer.add(step_of(6));
  writer.close();
  const ScenesFile scenes(path());
  ASSERT_EQ(scenes.count(), 2u);
  expect_equal(scenes.read(1), step_of(6));
}

TEST_F(ScenesFileTest, SparseStorageStaysSparse) {
  written(1);
  const Problem problem = ScenesFile(path()).read(0).problem;
  EXPECT_TRUE(std::holds_alternative<SparseMatrix>(problem.contact()->N));
  EXPECT_TRUE(std::holds_alternative<SparseMatrix>(problem.contact()->D));
  EXPECT_TRUE(std::holds_alternative<BlockInertia>(problem.contact()->inertia));
}

// A file of more than one frame: steps in the middle are reached without what lies before them.
TEST_F(ScenesFileTest, LongFilesAreReadAtRandomByManyThreads) {
  ScenesWriter writer(path(), {.scene = "long"}, 1);
  const std::string padding(40000, ' ');
  for (int i = 0; i < 400; ++i) writer.add_line(replaced(plain_line(i), ",\"N\"", padding + ",\"N\""));
  writer.close();
  const ScenesFile scenes(path());
  ASSERT_EQ(scenes.count(), 400u);
  std::vector<std::thread> threads;
  std::vector<int> wrong(4, 0);
  for (std::size_t t = 0; t < wrong.size(); ++t) {
    threads.emplace_back([&, t] {
      for (std::size_t i = t; i < 400; i += 37) wrong[t] += scenes.read(399 - i).step != static_cast<int>(399 - i);
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, std::vector<int>(4, 0));
}

TEST_F(ScenesFileTest, ACutOffFileGivesItsCompleteSteps) {
  const std::string whole = written(6);
  std::size_t last = 0;
  for (std::size_t size = whole.size() / 4; size < whole.size(); size += 7) {
    write(whole.substr(0, size));
    const ScenesFile scenes(path());
    ASSERT_LE(scenes.count(), 6u);
    EXPECT_GE(scenes.count(), last);
    EXPECT_NE(scenes.truncation().find("truncated"), std::string::npos) << size;
    last = scenes.count();
    for (std::size_t i = 0; i < last; ++i) expect_equal(scenes.read(i), step_of(static_cast<int>(10 * i)));
  }
  EXPECT_GE(last, 5u);

  const std::string text = kHeader + "\n" + plain_line(1) + "\n" + plain_line(2);
  EXPECT_EQ(ScenesFile(write(text)).count(), 2u) << "a last line without its end";
  EXPECT_EQ(ScenesFile(path()).truncation(), "");
  EXPECT_EQ(ScenesFile(write(text.substr(0, text.size() - 1))).count(), 1u);
  EXPECT_EQ(open_set("file:" + path())->note(), ScenesFile(path()).truncation());
  EXPECT_EQ(ScenesFile(path()).truncation(),
            path() +
                ": truncated, as a capture that was stopped leaves it: the line of the next step is incomplete; 1 "
                "complete step can be read");
}

TEST_F(ScenesFileTest, ErrorsNameFileLineAndField) {
  const std::string good = plain_line(3);
  EXPECT_EQ(error_of_line(good), "no error");
  EXPECT_EQ(error_of_line("[1]"), "line 2: does not begin with {\"step\": NUMBER");
  EXPECT_EQ(error_of_line(replaced(good, "3", "-3")), "line 2: does not begin with {\"step\": NUMBER");
  EXPECT_EQ(error_of_line(good + "\n" + good), "line 3: step 3 behind step 3: steps ascend");
  EXPECT_EQ(error_of_line(R"({"step":3})"), "line 2: problem: missing");
  EXPECT_EQ(error_of_line(good + "x"), "line 2: column 172: not valid JSON: unexpected 'x'");
  EXPECT_EQ(error_of_line(replaced(good, "[-1,0]", "[-1,\"0\"]")),
            "line 2: problem: v[1]: expected a finite number, found a text");
  EXPECT_EQ(error_of_line(replaced(good, "\"v\"", "\"u\"")), "line 2: problem: unknown field 'u' of kind 'contact'");
  EXPECT_EQ(error_of_line(replaced(good, "[[[2]],[[3]]]", "[[[2]],[[0]]]")),
            "line 2: problem: G_blocks[1]: not positive definite (Cholesky factorization fails)");
  const std::string with_extras = replaced(good, kProblem, kProblem + R"(,"gap":[1],"contact_ids":["a"])");
  EXPECT_EQ(error_of_line(with_extras), "no error");
  EXPECT_EQ(error_of_line(replaced(with_extras, "[1],\"contact_ids", "[1,2],\"contact_ids")),
            "line 2: gap: 2 entries, expected 1");
  EXPECT_EQ(error_of_line(replaced(with_extras, "[\"a\"]", "[1]")),
            "line 2: contact_ids[0]: expected a text, found a number");
  EXPECT_EQ(error_of_line(replaced(good, kProblem, kProblem + R"(,"poses":[[1,2]])")),
            "line 2: poses[0]: 2 entries, expected 7");
  EXPECT_EQ(error_of_line(replaced(good, kProblem, kProblem + R"(,"engine":{"impulses":[]})")),
            "line 2: engine.impulses: 0 entries, expected 1");
}

TEST_F(ScenesFileTest, AnEngineHasAnImpulseForEachBoundedRow) {
  const std::string with_rows = replaced(plain_line(3), ",\"G_blocks\"",
                                         R"(,"rows":{"R":[[1,0],[0,1]],"lower":[null,-1],"upper":[null,1]},"G_blocks")");
  const auto line = [&](const std::string& impulses) {
    return with_rows.substr(0, with_rows.size() - 1) + R"(,"engine":{"impulses":)" + impulses + "}}";
  };
  EXPECT_EQ(error_of_line(line("[1]")), "line 2: engine.impulses: 1 entry, expected 3");
  EXPECT_EQ(error_of_line(line("[1,2,3]")), "no error");
  write(kHeader + "\n" + line("[1,2,3]"));
  SceneStep step = ScenesFile(path()).read(0);
  EXPECT_EQ(*step.problem.engine_impulses(), (Vector{{1, 2, 3}}));
  EXPECT_EQ(complete_impulses(*step.problem.contact(), step.engine_impulses), (Vector{{1, 2, 3}}));
  step.engine_impulses = Vector::Zero(1);
  EXPECT_EQ(error_of([&] { scenes_line(step); }), "step 3: engine.impulses: 1 entry, expected 3");
}

TEST_F(ScenesFileTest, WhatIsNoScenesFileIsSaid) {
  const auto opened = [&](const std::string& bytes) {
    const std::string file = write(bytes);
    return replaced(error_of([&] { ScenesFile{file}; }), file + ": ", "");
  };
  EXPECT_EQ(opened(""), "empty file");
  EXPECT_EQ(opened("hello"), "not a scenes file");
  EXPECT_EQ(opened("{\"format\":"), "truncated in its first line");
  EXPECT_EQ(opened(replaced(kHeader, "scenes", "problem")),
            "line 1: format: 'lcpbench-problem', expected 'lcpbench-scenes'");
  EXPECT_EQ(opened(replaced(kHeader, "1", "2")), "line 1: version: 2 is not known; this program reads version 1");
  EXPECT_EQ(opened(replaced(kHeader, ",\"scene\":\"test\"", "")), "line 1: scene: missing");
  std::string damaged = written(3);
  damaged[damaged.size() / 2] ^= 0x55;
  EXPECT_NE(opened(damaged), "no error");
  EXPECT_EQ(error_of([&] { ScenesFile(path("none.scenes")); }), path("none.scenes") + ": no such file");
}

// 300 MiB of spaces in one line, which compress to some kilobytes.
TEST_F(ScenesFileTest, ALineThatWouldFillTheMemoryIsRefused) {
  ScenesWriter writer(path(), {.scene = "bomb"}, 1);
  const std::string spaces(300U << 20, ' ');
  writer.add_line("{\"step\":1" + spaces);
  writer.close();
  EXPECT_LT(fs::file_size(path()), 100000u);
  EXPECT_EQ(error_of([&] { ScenesFile{path()}; }), path() + ": a line of more than 268435456 bytes");
}

// Compressed, such files are small: 40 million blank lines, and 20 lines of 100 MiB each.
TEST_F(ScenesFileTest, AFileThatExpandsWithoutEndIsRefusedAtOnce) {
  {
    ScenesWriter writer(path(), {.scene = "bomb"}, 1);
    writer.add_line(std::string(40'000'000, '\n'));
    writer.close();
  }
  EXPECT_LT(fs::file_size(path()), 10000u);
  EXPECT_EQ(error_of([&] { ScenesFile{path()}; }), path() + ": more than 1000 blank lines at its end");
  {
    ScenesWriter writer(path(), {.scene = "bomb"}, 1);
    const std::string spaces(100U << 20, ' ');
    for (int i = 0; i < 20; ++i) writer.add_line("{\"step\":" + std::to_string(i) + spaces);
    writer.close();
  }
  EXPECT_LT(fs::file_size(path()), 300000u);
  EXPECT_EQ(error_of([&] { ScenesFile{path()}; }),
            path() + ": its text is more than 1024 times as long as its compressed bytes");
}

TEST_F(ScenesFileTest, AStepIsAProblemAndAFileIsASet) {
  written(4);
  EXPECT_EQ(problem_hash(read_problem(path() + "#20")), problem_hash(step_of(20).problem));
  EXPECT_EQ(error_of([&] { read_problem(path() + "#5"); }),
            path() + ": has no step 5; the one before is 0; the next one is 10");
  EXPECT_EQ(error_of([&] { read_problem(path() + "#x"); }), path() + "#x: 'x' is not the number of a step");
  EXPECT_EQ(error_of([&] { read_problem(path()); }), path() + ": holds steps: name one problem as t.scenes#STEP");
  const auto set = open_set("file:" + path());
  EXPECT_EQ(set->name(), "file:" + path());
  EXPECT_EQ(set->count(), 4);
  EXPECT_EQ(problem_hash(set->generate(5, 3)), problem_hash(step_of(30).problem));
  EXPECT_EQ(open_set("file:" + path() + "#30")->count(), 1);
}

// The collection: what is in the repository is what the program holds.
TEST(CollectedScenesTest, AreTheFilesOfTheRepository) {
  std::size_t bytes = 0;
  ASSERT_FALSE(collected_scenes().empty());
  for (const CollectedScene& scene : collected_scenes()) {
    SCOPED_TRACE(scene.name);
    bytes += scene.bytes.size();
    const std::string file =
        LCPBENCH_SOURCE_DIR "/generators/scenes" + scene.name.substr(scene.name.find('/')) + ".scenes";
    const ScenesFile on_disk(file);
    const auto set = open_set(scene.name);
    ASSERT_EQ(set->count(), static_cast<std::int64_t>(on_disk.count()));
    EXPECT_EQ(on_disk.truncation(), "");
    for (std::size_t i = 0; i < on_disk.count(); ++i) {
      EXPECT_EQ(problem_hash(set->generate(1, static_cast<std::int64_t>(i))), problem_hash(on_disk.read(i).problem));
    }
  }
  EXPECT_LE(bytes, 3'000'000u);
}

TEST(SparseProblemTest, IsTheDenseProblem) {
  const ContactProblem sparse = sparse_problem(1);
  ContactProblem dense = sparse;
  dense.N = to_dense(sparse.N);
  dense.D = to_dense(sparse.D);
  dense.inertia = DenseInertia{dense_inertia(sparse.inertia)};
  const std::string line = problem_json_line(Problem("p", sparse));
  EXPECT_EQ(problem_hash(parse_problem_json(line, "line")), problem_hash(Problem("p", dense)));
  EXPECT_EQ(problem_json(Problem("p", sparse)), problem_json(Problem("p", dense))) << "small files are dense";
  EXPECT_EQ(line.find('\n'), std::string::npos);
  EXPECT_NE(line.find("\"G_blocks\":[[[2,0.5],[0.5,1]],[[3,0],[0,4]]]"), std::string::npos);
}

TEST(SparseProblemTest, ErrorsNameTheEntry) {
  const std::string good = "{" + kProblem.substr(kProblem.find('{') + 1);
  const auto error = [&](const std::string& from, const std::string& to) {
    return error_of([&] { parse_problem_json(replaced(good, from, to), "f"); });
  };
  EXPECT_EQ(error("\"v\"", "\"v\""), "no error");
  EXPECT_EQ(error("\"rows\":[0]", "\"rows\":[2]"), "f: N.rows[0] is 2, expected 0 to 1");
  EXPECT_EQ(error("\"rows\":[0]", "\"rows\":[-1]"), "f: N.rows[0] is -1, expected 0 to 1");
  EXPECT_EQ(error("\"values\":[1]", "\"values\":[1,2]"), "f: N.values: 2 entries, expected 1");
  EXPECT_EQ(error("[0,1],\"rows\":[0],\"values\":[1]", "[0,2],\"rows\":[0,0],\"values\":[1,1]"),
            "f: N.rows[1] is 0 for the second time in column 0");
  EXPECT_EQ(error("[0,1],\"rows\"", "[1,1],\"rows\""), "f: N.starts[0] is 1, expected 0");
  EXPECT_EQ(error("[0,1],\"rows\"", "[0,0],\"rows\""), "f: N.starts: ends with 0, expected 1, the number of entries");
  EXPECT_EQ(error("[0,1],\"rows\"", "[0,7,1],\"rows\""), "f: N.starts[1]: the entries do not ascend");
  EXPECT_EQ(error("[0,1],\"rows\"", "[0,-7,1],\"rows\""), "f: N.starts[1]: the entries do not ascend");
  EXPECT_EQ(error("\"rows\":[0],", ""), "f: N.rows: missing");
  EXPECT_EQ(error("[[[2]],[[3]]]", "[[[2]]]"), "f: G_blocks: 1 x 1, expected 2 x 2");
  EXPECT_EQ(error("[[[2]],[[3]]]", "[[[2,1]],[[3]]]"), "f: G_blocks[0]: row 0 has 2 entries, expected 1");
  EXPECT_EQ(error("[[[2]],[[3]]]", "[[],[[3]]]"), "f: G_blocks[0]: empty");
  EXPECT_EQ(error("[[[2]],[[3]]]", "[[2],[[3]]]"), "f: G_blocks[0][0]: expected a list of numbers, found a number");
  EXPECT_EQ(error("\"G_blocks\"", "\"G\":[[2,0],[0,3]],\"G_blocks\""), "f: G and G_blocks: only one may be given");
}

TEST(SparseProblemTest, UnpairedColumnsAreFound) {
  ContactProblem problem = sparse_problem(1);
  std::get<SparseMatrix>(problem.D).coeffRef(1, 2) = -2;
  EXPECT_EQ(error_of([&] { problem_json(Problem("p", problem)); }),
            "p: D: contact 0: column 2 is not the negative of column 0 (row 1)");
  std::get<SparseMatrix>(problem.D).coeffRef(1, 2) = -1;
  std::get<SparseMatrix>(problem.D).coeffRef(3, 2) = 1;
  EXPECT_EQ(error_of([&] { problem_json(Problem("p", problem)); }),
            "p: D: contact 0: column 2 is not the negative of column 0 (row 3)");
}

}  // namespace
}  // namespace lcpbench::scenes_file_test
