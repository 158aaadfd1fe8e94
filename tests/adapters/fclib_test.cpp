// FCLIB files, written here by fclib itself, and what is refused of them.

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <hdf5.h>
#include <unistd.h>

extern "C" {  // the header does not say so itself
#include <fclib.h>
}

#include "adapters/fclib/fclib_problem.h"
#include "core/error.h"
#include "core/io/problem_io.h"
#include "core/io/scenes_file.h"
#include "tests/support/program_run.h"

namespace lcpbench {
namespace {

namespace fs = std::filesystem;

/// A matrix in one of fclib's ways of storing it, with the memory for it.
struct Stored {
  std::vector<int> p, i;
  std::vector<double> x;
  fclib_matrix matrix{};

  Stored(const Matrix& dense, int kind, bool as_in_the_header = false) {
    const int rows = static_cast<int>(dense.rows());
    const int cols = static_cast<int>(dense.cols());
    const bool by_rows = kind == -2;
    if (kind < 0) p.push_back(0);
    for (int line = 0; line < (by_rows ? rows : cols); ++line) {
      for (int k = 0; k < (by_rows ? cols : rows); ++k) {
        const double value = by_rows ? dense(line, k) : dense(k, line);
        if (value == 0) continue;
        i.push_back(k);
        x.push_back(value);
        if (kind >= 0) p.push_back(line);
      }
      if (kind < 0) p.push_back(static_cast<int>(x.size()));
    }
    if (as_in_the_header) std::swap(p, i);
    const int entries = static_cast<int>(x.size());
    matrix = {entries, rows, cols, p.data(), i.data(), x.data(), kind < 0 ? kind : entries, nullptr};
  }
};

constexpr int kTriplets = 0;
constexpr int kColumns = -1;
constexpr int kRows = -2;

/// Two contacts on two blocks of inertia, 2 x 2 and 1 x 1.
const Matrix kM{{2, 0.5, 0}, {0.5, 1, 0}, {0, 0, 4}};
const Matrix kH{{1, 0, 0.5, 0, 0, 0.25}, {0, 1, 0, 0, 0, 0}, {0, 0, 0, 1, 2, 3}};

class FclibTest : public ::testing::Test {
 protected:
  FclibTest() : folder_(fs::temp_directory_path() / ("lcpbench-fclib-" + std::to_string(::getpid()))) {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~FclibTest() override { fs::remove_all(folder_); }

  std::string path(const std::string& name = "problem.hdf5") const { return (folder_ / name).string(); }

  std::string global(Stored M, Stored H, std::vector<double> w, Stored* G = nullptr, int dimension = 3) const {
    std::vector<double> mu{0.5, 0.25, 0.75}, f{1, -2, 0.1}, b{0};
    fclib_global problem{};
    problem.M = &M.matrix;
    problem.H = &H.matrix;
    problem.G = G != nullptr ? &G->matrix : nullptr;
    problem.mu = mu.data();
    problem.f = f.data();
    problem.b = G != nullptr ? b.data() : nullptr;
    problem.w = w.data();
    problem.spacedim = dimension;
    fs::remove(path());
    EXPECT_EQ(fclib_write_global(&problem, path().c_str()), 1);
    return path();
  }

  std::string local(Stored W) const {
    std::vector<double> mu{0.5}, q{-1, 0.25, 0.125};
    fclib_local problem{};
    problem.W = &W.matrix;
    problem.mu = mu.data();
    problem.q = q.data();
    problem.spacedim = 3;
    fs::remove(path());
    EXPECT_EQ(fclib_write_local(&problem, path().c_str()), 1);
    return path();
  }

  /// The error, without the file's name.
  std::string error_of(const std::string& file) const {
    try {
      read_fclib(file, false);
    } catch (const InputError& error) {
      return std::string(error.what()).substr(file.size() + 2);
    }
    return "no error";
  }

  fs::path folder_;
};

const std::vector<double> kNoW(6, 0.0);

TEST_F(FclibTest, GlobalProblemsOfEveryStorage) {
  ContactProblem expected;
  expected.v = kM.llt().solve(Vector{{1, -2, 0.1}});
  expected.N = Matrix{{1, 0}, {0, 0}, {0, 1}};
  expected.D = Matrix{{0, 0.5, 0, -0.5, 0, 0.25, 0, -0.25}, {1, 0, -1, 0, 0, 0, 0, 0}, {0, 0, 0, 0, 2, 3, -2, -3}};
  expected.edges = {4, 4};
  for (const int M : {kTriplets, kColumns, kRows}) {
    for (const int H : {kTriplets, kColumns, kRows}) {
      const Problem problem = read_fclib(global(Stored(kM, M), Stored(kH, H), kNoW), false);
      const ContactProblem& read = *problem.contact();
      EXPECT_EQ(problem.name(), "problem.hdf5");
      EXPECT_EQ(dense_inertia(read.inertia), kM);
      EXPECT_EQ(std::get<BlockInertia>(read.inertia).blocks.size(), 2u);
      EXPECT_TRUE(read.v.isApprox(expected.v, 1e-15));
      EXPECT_EQ(to_dense(read.N), to_dense(expected.N));
      EXPECT_EQ(to_dense(read.D), to_dense(expected.D));
      EXPECT_EQ(read.edges, expected.edges);
      EXPECT_EQ(read.mu, (Vector{{0.5, 0.25}}));
      EXPECT_FALSE(read.has_offset());
    }
  }
}

TEST_F(FclibTest, TheVelocityOfTheSurroundingsIsAnOffset) {
  const auto read = [&](const std::vector<double>& w, int dimension) {
    return *read_fclib(global(Stored(kM, kColumns), Stored(kH, kColumns), w, nullptr, dimension), false).contact();
  };
  const ContactProblem normal = read({0.5, 0, 0, -0.25, 0, 0}, 3);
  EXPECT_EQ(normal.b, (Vector{{0.5, -0.25}}));
  EXPECT_FALSE(normal.is_soft());
  const ContactProblem tangential = read({0, 0.125, 0, 0, 1, -2}, 3);
  EXPECT_FALSE(tangential.has_offset());
  EXPECT_EQ(tangential.offset_t, (Vector{{0.125, 0, 1, -2}}));
  const ContactProblem plane = read({0.5, 0.125, 0, 0, 0, -2}, 2);
  EXPECT_EQ(plane.b, (Vector{{0.5, 0, 0}}));
  EXPECT_EQ(plane.offset_t, (Vector{{0.125, 0, 0, 0, -2, 0}}));
  EXPECT_EQ(error_of(global(Stored(kM, kColumns), Stored(kH, kColumns), {0, 0, 0, 0, NAN, 0})),
            "/fclib_global/vectors/w[4]: a number that is not finite");
}

TEST_F(FclibTest, ThePlaneHasTwoDirections) {
  const Problem problem = read_fclib(global(Stored(kM, kColumns), Stored(kH, kColumns), kNoW, nullptr, 2), false);
  EXPECT_EQ(problem.contact()->edges, (std::vector<int>{2, 2, 2}));
  EXPECT_EQ(to_dense(problem.contact()->N), (Matrix{{1, 0.5, 0}, {0, 0, 0}, {0, 0, 2}}));
}

TEST_F(FclibTest, LocalProblems) {
  const Matrix W{{2, 0.5, 0}, {0.5, 1, 0}, {0, 0, 1}};
  const Problem problem = read_fclib(local(Stored(W, kRows)), false);
  const ContactProblem& read = *problem.contact();
  EXPECT_EQ(std::get<InverseInertia>(read.inertia).Ginv, W);
  EXPECT_EQ(read.v, (Vector{{-1, 0.25, 0.125}}));
  EXPECT_EQ(to_dense(read.N), (Matrix{{1}, {0}, {0}}));
  EXPECT_EQ(to_dense(read.D), (Matrix{{0, 0, 0, 0}, {1, 0, -1, 0}, {0, 1, 0, -1}}));
}

TEST_F(FclibTest, AsymmetryIsNamedAndMayBeTakenOut) {
  const Matrix W{{2, 0.5, 0}, {0.502, 1, 0}, {0, 0, 1}};
  const std::string file = local(Stored(W, kRows));
  EXPECT_EQ(error_of(file),
            "/fclib_local/W: not symmetric: its triangles differ by 0.0020000000000000018, its largest entry is 2; "
            "--symmetrize takes their mean");
  const Problem problem = read_fclib(file, true);
  EXPECT_EQ(std::get<InverseInertia>(problem.contact()->inertia).Ginv(0, 1), 0.501);
  EXPECT_EQ(error_of(local(Stored(Matrix{{2, 0.5, 0}, {0.5 + 1e-14, 1, 0}, {0, 0, 1}}, kRows))), "no error");
}

TEST_F(FclibTest, WhatIsOutsideOfTheModelIsNamed) {
  Stored G(Matrix{{1}, {0}, {0}}, kColumns);
  EXPECT_EQ(error_of(global(Stored(kM, kColumns), Stored(kH, kColumns), kNoW, &G)),
            "/fclib_global/G: equality constraints are outside of the model");
  EXPECT_EQ(error_of(global(Stored(Matrix::Ones(3, 3), kColumns), Stored(kH, kColumns), kNoW)),
            "/fclib_global/M: not positive definite");
  const auto with_group = [&](const std::string& name, const std::function<void(hid_t)>& fill) {
    const hid_t file = H5Fcreate(path("made.hdf5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    const hid_t group = H5Gcreate2(file, name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    fill(group);
    H5Gclose(group);
    H5Fclose(file);
    return path("made.hdf5");
  };
  const auto dimension = [](int value) {
    return [value](hid_t group) {
      const hid_t space = H5Screate(H5S_SCALAR);
      const hid_t set = H5Dcreate2(group, "spacedim", H5T_NATIVE_INT, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
      H5Dwrite(set, H5T_NATIVE_INT, H5S_ALL, H5S_ALL, H5P_DEFAULT, &value);
      H5Dclose(set);
      H5Sclose(space);
    };
  };
  EXPECT_EQ(error_of(with_group("/fclib_global_rolling", [](hid_t) {})),
            "/fclib_global_rolling: rolling friction is outside of the model");
  EXPECT_EQ(error_of(with_group("/fclib_local", dimension(5))),
            "/fclib_local: rolling friction (spacedim 5) is outside of the model");
  EXPECT_EQ(error_of(with_group("/fclib_local", dimension(4))), "/fclib_local/spacedim is 4, expected 2 or 3");
  EXPECT_EQ(error_of(with_group("/fclib_local", dimension(3))), "/fclib_local/W/m: missing");
  EXPECT_EQ(error_of(with_group("/other", [](hid_t) {})), "has neither /fclib_global nor /fclib_local");
  EXPECT_EQ(error_of("/etc/passwd"), "cannot be opened as an HDF5 file");
}

/// A file of fclib, of which parts are replaced.
class ChangedFclibTest : public FclibTest {
 protected:
  ChangedFclibTest() : name_(global(Stored(kM, kColumns), Stored(kH, kColumns), kNoW)) {
    file_ = H5Fopen(name_.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  }

  /// A dataset in the place of one that is there. @param creation  how it is stored
  void replace(const char* name, hid_t type, const void* numbers, hsize_t count, hid_t creation = H5P_DEFAULT) {
    H5Ldelete(file_, name, H5P_DEFAULT);
    const hid_t space = H5Screate_simple(1, &count, nullptr);
    const hid_t set = H5Dcreate2(file_, name, type, space, H5P_DEFAULT, creation, H5P_DEFAULT);
    ASSERT_GE(set, 0);
    if (numbers != nullptr) H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers);
    H5Dclose(set);
    H5Sclose(space);
  }

  std::string error() {
    H5Fclose(file_);
    return error_of(name_);
  }

  std::string name_;
  hid_t file_ = -1;
};

// Pointers that go back may not lead beyond the end of x on their way.
TEST_F(ChangedFclibTest, PointersThatDescendAreNamed) {
  const std::vector<int> pointers{0, 5, 2, 2};
  const std::vector<double> values{2, 0.5};
  replace("/fclib_global/M/p", H5T_NATIVE_INT, pointers.data(), pointers.size());
  replace("/fclib_global/M/x", H5T_NATIVE_DOUBLE, values.data(), values.size());
  EXPECT_EQ(error(), "/fclib_global/M/p: entry 1 does not ascend");
}

// A size is only a claim: the transpose of 2^26 empty columns takes seconds and gigabytes.
TEST_F(ChangedFclibTest, MoreRowsThanTheFileHasBytesAreRefused) {
  const int rows = 1 << 26;
  replace("/fclib_global/M/m", H5T_NATIVE_INT, &rows, 1);
  replace("/fclib_global/M/n", H5T_NATIVE_INT, &rows, 1);
  H5Fflush(file_, H5F_SCOPE_GLOBAL);
  const std::string bytes = std::to_string(fs::file_size(name_));
  EXPECT_EQ(error(), "/fclib_global/M: 67108864 numbers in a file of " + bytes + " bytes");
}

TEST_F(ChangedFclibTest, NumbersThatNobodyWroteAreRefused) {
  replace("/fclib_global/M/x", H5T_NATIVE_DOUBLE, nullptr, 1 << 26);
  EXPECT_NE(error().find("/fclib_global/M/x: 67108864 numbers in a file of "), std::string::npos);
}

// One entry far from the diagonal joins all rows to one block, which is stored dense.
TEST_F(ChangedFclibTest, ABlockTooLargeToBeStoredDenseIsRefusedBeforeItIsMade) {
  const int rows = 40'000;
  const auto count = static_cast<std::size_t>(rows);
  std::vector<int> p(count + 1), i(count + 2);
  std::vector<double> x(count + 2, 1.0), f(count, 0.0);
  for (std::size_t k = 0; k < count; ++k) {
    p[k] = static_cast<int>(k + (k > 0 ? 1 : 0));
    i[k + (k > 0 ? 1 : 0)] = static_cast<int>(k);
  }
  p[count] = rows + 2;
  i[1] = rows - 1;
  x[1] = 0.25;
  i[count] = 0;
  i[count + 1] = rows - 1;
  x[count] = 0.25;
  replace("/fclib_global/M/m", H5T_NATIVE_INT, &rows, 1);
  replace("/fclib_global/M/n", H5T_NATIVE_INT, &rows, 1);
  replace("/fclib_global/M/p", H5T_NATIVE_INT, p.data(), p.size());
  replace("/fclib_global/M/i", H5T_NATIVE_INT, i.data(), i.size());
  replace("/fclib_global/M/x", H5T_NATIVE_DOUBLE, x.data(), x.size());
  replace("/fclib_global/H/m", H5T_NATIVE_INT, &rows, 1);
  replace("/fclib_global/vectors/f", H5T_NATIVE_DOUBLE, f.data(), f.size());
  EXPECT_EQ(error(), "/fclib_global/M: its dense diagonal blocks have more than 67108864 numbers");
}

// Else a problem from somewhere tells its author what is in any file of the reader's.
TEST_F(ChangedFclibTest, NoOtherFileIsRead) {
  const std::vector<double> secret{0.5, 0.25, 0.75};
  std::ofstream(path("secret"), std::ios::binary).write(reinterpret_cast<const char*>(secret.data()), 24);
  const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_external(creation, path("secret").c_str(), 0, 24);
  replace("/fclib_global/vectors/f", H5T_NATIVE_DOUBLE, nullptr, 3, creation);
  H5Pclose(creation);
  EXPECT_EQ(error(), "/fclib_global/vectors/f: its numbers are in another file, which is not read");
}

/// A file whose dimension is a link to another file. Made before any file is read: reading takes the links out of HDF5.
const std::string kLinked = [] {
  const std::string name = (fs::temp_directory_path() / ("lcpbench-link-" + std::to_string(::getpid()))).string();
  const hid_t file = H5Fcreate(name.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  H5Gclose(H5Gcreate2(file, "/fclib_local", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  H5Lcreate_external(name.c_str(), "/other", file, "/fclib_local/spacedim", H5P_DEFAULT, H5P_DEFAULT);
  const hid_t space = H5Screate(H5S_SCALAR);
  const hid_t set = H5Dcreate2(file, "/other", H5T_NATIVE_INT, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  const int dimension = 3;
  H5Dwrite(set, H5T_NATIVE_INT, H5S_ALL, H5S_ALL, H5P_DEFAULT, &dimension);
  H5Dclose(set);
  H5Sclose(space);
  H5Fclose(file);
  return name;
}();

TEST_F(FclibTest, NoLinkToAnotherFileIsFollowed) {
  EXPECT_EQ(error_of(kLinked), "/fclib_local/spacedim: is not a dataset of this file");
  fs::remove(kLinked);
}

TEST_F(FclibTest, WritesAScenesFile) {
  const std::string first = local(Stored(Matrix::Identity(3, 3), kRows));
  fs::copy(first, path("second.hdf5"));
  const ProgramRun run = run_program(folder_, "import fclib problem.hdf5 second.hdf5 --out out.scenes");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out, "out.scenes#0: problem.hdf5, 1 contacts\nout.scenes#1: second.hdf5, 1 contacts\n");
  const ScenesFile scenes(path("out.scenes"));
  ASSERT_EQ(scenes.count(), 2u);
  EXPECT_EQ(problem_hash(scenes.read(1).problem), problem_hash(read_fclib(first, false)));
  EXPECT_EQ(scenes.read(1).problem.name(), "second.hdf5");
}

TEST_F(FclibTest, AFileThatCannotBeReadLeavesTheOldOutput) {
  local(Stored(Matrix::Identity(3, 3), kRows));
  std::ofstream(path("out.scenes")) << "old";
  const ProgramRun run = run_program(folder_, "import fclib problem.hdf5 /etc/passwd --out out.scenes");
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_EQ(run.err, "lcpbench: /etc/passwd: cannot be opened as an HDF5 file\n");
  EXPECT_EQ(read_file(path("out.scenes")), "old");
  EXPECT_FALSE(fs::exists(path("out.scenes.part")));
}

}  // namespace
}  // namespace lcpbench
