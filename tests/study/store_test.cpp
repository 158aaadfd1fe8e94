// What a user relies on: a store gives back exactly what went in, and says clearly when a file cannot be used.

#include "study/store/store.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "study/store/answer_scan.h"
#include "study/store/vector_codec.h"
#include "tests/support/checks.h"
#include "tests/support/study_support.h"

namespace lcpbench::store_test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::vector<std::uint64_t> bits(const Vector& vector) {
  std::vector<std::uint64_t> result;
  for (const double value : vector) result.push_back(std::bit_cast<std::uint64_t>(value));
  return result;
}

Vector awkward_numbers() {
  Vector vector(8);
  vector << 0.0, -0.0, std::bit_cast<double>(0x7ff8'dead'beef'0001ULL), kInfinity, -kInfinity,
      std::numeric_limits<double>::denorm_min(), 1.0 / 3.0, 0.0;
  return vector;
}

ProblemResult one_result(const std::string& set, const SolverRow& solver, const Vector& z) {
  ProblemResult result;
  result.problem = {.id = problem_id(set, 7, 3),
                    .set_id = set_id(set),
                    .seed = 7,
                    .trial = 3,
                    .kind = "lcp",
                    .n = z.size(),
                    .hash = "ab",
                    .theory = ""};
  AnswerRow cell;
  cell.solver_id = solver.id();
  cell.claim = Claim::kSolved;
  cell.counters = {5, 4, 3};
  cell.detail = "it's \"fine\"";
  cell.errors.solved = cell.errors.usable = true;
  cell.errors.natural_residual = 1e-300;
  cell.errors.backward_row_norm = kInfinity;
  cell.times.solve_cpu_s = 0.1;
  cell.times.repeats = 12;
  std::string bytes = encode_vector(z);
  cell.z = content_id(bytes);
  result.vectors.emplace_back(*cell.z, std::move(bytes));
  result.answers.push_back(cell);
  return result;
}

SolverRow some_solver() {
  SolverRow solver;
  solver.name = "lemke";
  solver.settings = "engine=dense";
  solver.library = "native";
  return solver;
}

/// Begins a store with one finished cell.
void fill(const std::filesystem::path& file, const Vector& z) {
  Store store = Store::open_for_writing(file);
  store.begin();
  store.add_run("2026-01-01T00:00:00Z", "{}");
  store.add_set("a/set");
  store.add_solver(some_solver());
  store.add(one_result("a/set", some_solver(), z));
  store.commit();
}

TEST(VectorCodecTest, KeepsEveryBit) {
  const Vector vector = awkward_numbers();
  EXPECT_EQ(bits(decode_vector(encode_vector(vector))), bits(vector));
  EXPECT_EQ(decode_vector(encode_vector(Vector())).size(), 0);
}

TEST(VectorCodecTest, RefusesDamagedBytes) {
  std::string bytes = encode_vector(awkward_numbers());
  EXPECT_THROW(decode_vector(bytes.substr(0, bytes.size() - 1)), InputError);
  EXPECT_THROW(decode_vector(""), InputError);
  bytes[4] = 100;  // an index beyond the length
  EXPECT_THROW(decode_vector(bytes), InputError);
  EXPECT_THROW(decode_vector(std::string("\xff\xff\xff\xff", 4)), InputError);
}

TEST(StoreTest, ASnapshotDoesNotSeeWhatAnotherProcessCommits) {
  const ScratchFolder folder;
  const std::filesystem::path file = folder / "s.db";
  Store writer = Store::open_for_writing(file);
  Store reader = Store::open_for_reading(file);
  const auto add_set = [&](const std::string& name) {
    writer.begin();
    writer.add_set(name);
    writer.commit();
  };
  add_set("a/set");
  {
    const sqlite::ReadSnapshot snapshot(reader.database());
    const sqlite::ReadSnapshot inner(reader.database());  // nests
    EXPECT_EQ(reader.sets().size(), 1U);
    add_set("b/set");
    EXPECT_EQ(reader.sets().size(), 1U);
  }
  EXPECT_EQ(reader.sets().size(), 2U);
}

TEST(StoreTest, GivesBackWhatWentIn) {
  const ScratchFolder folder;
  const std::filesystem::path file = folder / "s.db";
  fill(file, awkward_numbers());
  Store store = Store::open_for_reading(file);
  const std::int64_t problem = problem_id("a/set", 7, 3);
  const std::optional<Answer> answer = store.answer(problem, some_solver().id());
  ASSERT_TRUE(answer.has_value());
  EXPECT_EQ(bits(answer->z), bits(awkward_numbers()));
  EXPECT_EQ(answer->detail, "it's \"fine\"");
  EXPECT_EQ(answer->counters.pivots, 4);
  EXPECT_EQ(store.done(problem), std::vector<std::int64_t>{some_solver().id()});
  EXPECT_EQ(store.solvers().at(0).row, some_solver());
  int cells = 0;
  store.for_each_answer([&](const StoredAnswer& cell) {
    ++cells;
    EXPECT_EQ(cell.seed, 7U);
    EXPECT_EQ(cell.verdict, Verdict::kSolved);
    EXPECT_EQ(cell.errors.natural_residual, 1e-300);
    EXPECT_EQ(cell.errors.backward_row_norm, kInfinity);
    EXPECT_TRUE(std::isnan(cell.errors.work_gain_j));
    EXPECT_EQ(cell.times.solve_cpu_s, 0.1);
    EXPECT_EQ(cell.times.repeats, 12);
  });
  EXPECT_EQ(cells, 1);
}

void add(const std::filesystem::path& file, const ProblemResult& result) {
  Store store = Store::open_for_writing(file);
  store.begin();
  store.add(result);
  store.commit();
}

TEST(StoreTest, FirstRowOfACellStays) {
  const ScratchFolder folder;
  const std::filesystem::path file = folder / "s.db";
  fill(file, Vector::Ones(2));
  const std::string before = dump(file);
  ProblemResult again = one_result("a/set", some_solver(), Vector::Ones(2));
  again.answers[0].claim = Claim::kCrashed;
  add(file, again);
  EXPECT_EQ(dump(file), before);
}

TEST(StoreTest, AnswersToAnotherProblemUnderTheSameNameAreRefused) {
  const ScratchFolder folder;
  const std::filesystem::path file = folder / "s.db";
  fill(file, Vector::Ones(2));
  const std::string before = dump(file);
  SolverRow added = some_solver();
  added.name = "another";
  ProblemResult changed = one_result("a/set", added, Vector::Ones(2));
  changed.problem.hash = "cd";
  const std::string cause = input_error([&] { add(file, changed); });
  EXPECT_TRUE(contains(cause, "trial 3 of seed 7 of set 'a/set' is another problem")) << cause;
  EXPECT_EQ(dump(file), before);
}

TEST(StoreTest, AtRestIsOneFileAndABlankOneOfAKilledStartIsAFreshStore) {
  const ScratchFolder folder;
  std::ofstream(folder / "s.db").close();
  EXPECT_NO_THROW(fill(folder / "s.db", Vector::Ones(2)));
  for (const char* suffix : {"-wal", "-shm", ".lock"}) {
    EXPECT_FALSE(std::filesystem::exists((folder / "s.db").string() + suffix)) << suffix;
  }
}

TEST(StoreTest, ForeignFilesAreNamedAndLeftAlone) {
  const ScratchFolder folder;
  const std::string text(5000, 'x');
  std::ofstream(folder / "text.db") << text;
  const std::string expected = (folder / "text.db").string() + ": not an lcpbench store";
  EXPECT_EQ(input_error([&] { Store::open_for_writing(folder / "text.db"); }), expected);
  EXPECT_EQ(input_error([&] { Store::open_for_reading(folder / "text.db"); }), expected);
  EXPECT_EQ(input_error([&] { Store::remove(folder / "text.db"); }), expected);
  EXPECT_EQ(std::filesystem::file_size(folder / "text.db"), text.size());

  sqlite::Database(folder / "other.db", sqlite::Mode::kReadWriteCreate).execute("CREATE TABLE mine (x)");
  EXPECT_EQ(input_error([&] { Store::open_for_writing(folder / "other.db"); }),
            (folder / "other.db").string() + ": not an lcpbench store");
  EXPECT_TRUE(contains(input_error([&] { Store::open_for_reading(folder / "none.db"); }), "no such store"));
}

SolverRow some_sweep() {
  SolverRow sweep = some_solver();
  sweep.sweep = "grid{engine=dense}";
  return sweep;
}

SolverRow some_cell(const std::string& setting) {
  SolverRow cell = some_sweep();
  cell.settings = setting;
  cell.all_settings = setting + ",b=0";
  return cell;
}

const std::vector<SolverRow> kThreeCells{some_cell("a=1"), some_cell("a=2"), some_cell("a=3")};

/// Cells 0 and 2 claim solved, cell 1 does not.
ProblemResult swept_result(const Vector& z) {
  ProblemResult result = one_result("a/set", some_sweep(), z);
  result.answers[0].cells = {0, 2};
  result.answers.push_back(result.answers[0]);
  result.answers[1].cells = {1};
  result.answers[1].claim = Claim::kUnsolvable;
  result.answers[1].z.reset();
  result.answers[1].errors = {};
  return result;
}

void fill_with_sweep(const std::filesystem::path& file) {
  Store store = Store::open_for_writing(file);
  store.begin();
  store.add_run("2026-01-01T00:00:00Z", "{}");
  store.add_set("a/set");
  store.add_solver(some_sweep(), kThreeCells);
  store.add(swept_result(Vector::Ones(2)));
  store.commit();
}

TEST(StoreTest, EveryCellOfASweepHasItsAnswer) {
  const ScratchFolder folder;
  fill_with_sweep(folder / "s.db");
  Store store = Store::open_for_reading(folder / "s.db");
  const std::int64_t problem = problem_id("a/set", 7, 3);
  EXPECT_EQ(store.cell_count(), 3);
  EXPECT_EQ(store.done(problem), std::vector<std::int64_t>{some_sweep().id()});
  EXPECT_EQ(store.solvers().at(0).cells, kThreeCells);
  EXPECT_EQ(store.solvers().at(0).cells.at(2).text(), "lemke{a=3}");
  for (const std::uint32_t cell : {0U, 2U}) {
    EXPECT_EQ(store.answer(problem, some_sweep().id(), cell).value().claim, Claim::kSolved) << cell;
  }
  EXPECT_EQ(store.answer(problem, some_sweep().id(), 1).value().claim, Claim::kUnsolvable);
  EXPECT_FALSE(store.answer(problem, some_sweep().id(), 3).has_value());
  const std::vector<std::string> cells = store.database().texts(
      "SELECT cell || ' ' || part || ' ' || settings || ' ' || claim || ' ' || verdict FROM judged_cells ORDER BY "
      "cell");
  // One cell's answer, which passes, does not prove that the other one's claim is false.
  EXPECT_EQ(cells,
            (std::vector<std::string>{"0 0 a=1 solved solved", "1 1 a=2 unsolvable open", "2 0 a=3 solved solved"}));
}

TEST(StoreTest, SweepOverAnotherGridIsRefused) {
  const ScratchFolder folder;
  fill_with_sweep(folder / "s.db");
  Store store = Store::open_for_writing(folder / "s.db");
  for (const std::size_t cells : {2U, 4U}) {
    std::vector<SolverRow> grid = kThreeCells;
    grid.resize(cells, some_cell("a=4"));
    const std::string cause = input_error([&] { store.add_solver(some_sweep(), grid); });
    EXPECT_TRUE(contains(cause, "sweep 'grid{engine=dense}' of 'lemke{engine=dense}' with other grid values")) << cause;
  }
}

TEST(StoreTest, AnotherFormatIsRefusedInOneLineAndCanBeThrownAway) {
  const ScratchFolder folder;
  fill(folder / "s.db", Vector::Ones(2));
  for (const int format : {3, 10, 99}) {
    sqlite::Database(folder / "s.db", sqlite::Mode::kReadWriteCreate)
        .execute(fmt::format("PRAGMA user_version = {}", format));
    const std::string expected = fmt::format("{}: store format {}, this lcpbench ", (folder / "s.db").string(), format);
    EXPECT_TRUE(contains(input_error([&] { Store::open_for_reading(folder / "s.db"); }), expected));
    EXPECT_TRUE(contains(input_error([&] { Store::open_for_writing(folder / "s.db"); }), expected));
  }
  Store::remove(folder / "s.db");
  EXPECT_FALSE(std::filesystem::exists(folder / "s.db"));
}

TEST(StoreTest, FolderIsCalledAFolder) {
  const ScratchFolder folder;
  const std::filesystem::path path = folder / "there";
  std::filesystem::create_directory(path);
  const std::string expected = path.string() + ": is a folder, expected a store";
  EXPECT_EQ(input_error([&] { Store::open_for_reading(path); }), expected);
  EXPECT_EQ(input_error([&] { Store::open_for_writing(path); }), expected);
  EXPECT_EQ(input_error([&] { Store::remove(path); }), expected);
  EXPECT_TRUE(std::filesystem::is_directory(path));
}

TEST(StoreTest, APipeIsNoStore) {
  const ScratchFolder folder;
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_EQ(input_error([&] { Store::open_for_writing(folder / "pipe"); }),
            (folder / "pipe").string() + ": is not a regular file");
}

TEST(StoreTest, WordThatIsNoClaimNamesTheStore) {
  const ScratchFolder folder;
  const std::filesystem::path file = folder / "s.db";
  fill(file, Vector::Ones(2));
  change_rows(file, "UPDATE answers SET claim = 'sure'");
  Store store = Store::open_for_reading(file);
  EXPECT_EQ(input_error([&] { store.for_each_answer([](const StoredAnswer&) {}); }),
            file.string() + ": unknown claim 'sure'");
}

TEST(StoreTest, SolverWithOtherDefaultsIsRefused) {
  const ScratchFolder folder;
  Store store = Store::open_for_writing(folder / "s.db");
  SolverRow solver = some_solver();
  store.add_solver(solver);
  solver.all_settings = "engine=dense,new_default=1";
  EXPECT_TRUE(contains(input_error([&] { store.add_solver(solver); }), "other defaults"));
}

}  // namespace
}  // namespace lcpbench::store_test
