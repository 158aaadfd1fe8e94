#include "adapters/fclib/fclib_problem.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "adapters/fclib/hdf5_file.h"
#include "core/error.h"
#include "core/io/problem_checks.h"
#include "core/settings.h"

namespace lcpbench {
namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;

/// Above it the two triangles of a matrix differ by more than the rounding of whoever assembled it.
constexpr double kRoundingAsymmetry = 1e-10;

struct Stored {
  int rows = 0;
  int cols = 0;
  int kind = 0;  ///< number of triplets; -1: compressed columns, -2: compressed rows
  std::vector<int> p;
  std::vector<int> i;
  std::vector<double> x;
};

Stored read_stored(const Hdf5File& file, const std::string& path) {
  Stored stored{file.integer(path + "/m"), file.integer(path + "/n"), file.integer(path + "/nz"), {}, {}, {}};
  if (stored.rows < 0 || stored.cols < 0 || stored.kind < -2) file.fail(path, ": negative sizes");
  // Each row and column of a problem's matrices has a number of its own in one of the vectors.
  file.check_count(path, static_cast<std::size_t>(std::max(stored.rows, stored.cols)));
  stored.p = file.integers(path + "/p");
  stored.i = file.integers(path + "/i");
  stored.x = file.reals(path + "/x");
  const std::size_t pointers = stored.kind >= 0    ? static_cast<std::size_t>(stored.kind)
                               : stored.kind == -1 ? static_cast<std::size_t>(stored.cols) + 1
                                                   : static_cast<std::size_t>(stored.rows) + 1;
  if (stored.p.size() < pointers) file.fail(path + "/p", ": fewer entries than the sizes ask for");
  const std::size_t entries =
      stored.kind >= 0 ? pointers : static_cast<std::size_t>(std::max(0, stored.p[pointers - 1]));
  if (stored.i.size() < entries || stored.x.size() < entries) {
    file.fail(path, ": fewer entries in i or x than the sizes ask for");
  }
  return stored;
}

bool all_below(const std::vector<int>& indices, int count, int limit) {
  return std::all_of(indices.begin(), indices.begin() + count, [&](int index) { return index >= 0 && index < limit; });
}

/// Triplets as Siconos writes them have the column in p and the row in i; fclib.h's comment says the reverse. Where
/// only one of the two fits the sizes it is taken, else Siconos', which wrote the public files.
Triplets triplets(const Hdf5File& file, const std::string& path, const Stored& stored) {
  const bool by_siconos =
      all_below(stored.p, stored.kind, stored.cols) && all_below(stored.i, stored.kind, stored.rows);
  const bool by_header = all_below(stored.p, stored.kind, stored.rows) && all_below(stored.i, stored.kind, stored.cols);
  if (!by_siconos && !by_header) file.fail(path, ": triplets beyond the matrix, read either way round");
  Triplets result;
  for (std::size_t k = 0; k < static_cast<std::size_t>(stored.kind); ++k) {
    const int row = by_siconos ? stored.i[k] : stored.p[k];
    const int column = by_siconos ? stored.p[k] : stored.i[k];
    result.emplace_back(row, column, stored.x[k]);
  }
  return result;
}

/// The entries of compressed columns or rows.
Triplets compressed(const Hdf5File& file, const std::string& path, const Stored& stored) {
  const bool columns = stored.kind == -1;
  const int lines = columns ? stored.cols : stored.rows;
  const int limit = columns ? stored.rows : stored.cols;
  Triplets result;
  for (int line = 0; line < lines; ++line) {
    const int begin = stored.p[static_cast<std::size_t>(line)];
    const int end = stored.p[static_cast<std::size_t>(line) + 1];
    if (begin < 0 || end < begin || static_cast<std::size_t>(end) > std::min(stored.i.size(), stored.x.size())) {
      file.fail(path + "/p", ": entry " + std::to_string(line + 1) + " does not ascend");
    }
    for (auto k = static_cast<std::size_t>(begin); k < static_cast<std::size_t>(end); ++k) {
      const int index = stored.i[k];
      if (index < 0 || index >= limit) file.fail(path + "/i", ": an index beyond the matrix");
      result.emplace_back(columns ? index : line, columns ? line : index, stored.x[k]);
    }
  }
  return result;
}

SparseMatrix read_matrix(const Hdf5File& file, const std::string& path) {
  const Stored stored = read_stored(file, path);
  const Triplets entries = stored.kind >= 0 ? triplets(file, path, stored) : compressed(file, path, stored);
  SparseMatrix matrix(stored.rows, stored.cols);
  matrix.setFromTriplets(entries.begin(), entries.end());
  if (!all_finite(matrix)) file.fail(path + "/x", ": a number that is not finite");
  return matrix;
}

Vector read_vector(const Hdf5File& file, const std::string& path, Index expected) {
  const std::vector<double> numbers = file.reals(path);
  if (static_cast<Index>(numbers.size()) != expected) {
    file.fail(path,
              ": " + count_of(static_cast<Index>(numbers.size()), "entry") + ", expected " + std::to_string(expected));
  }
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (!std::isfinite(numbers[i])) file.fail(path, "[" + std::to_string(i) + "]: a number that is not finite");
  }
  return Eigen::Map<const Vector>(numbers.data(), expected);
}

/// The symmetric matrix of two triangles that agree up to rounding.
SparseMatrix symmetric(const Hdf5File& file, const std::string& path, const SparseMatrix& matrix, bool symmetrize) {
  if (matrix.rows() != matrix.cols()) file.fail(path, ": not square");
  const SparseMatrix transpose = matrix.transpose();
  const double largest = matrix.coeffs().size() > 0 ? matrix.coeffs().abs().maxCoeff() : 0.0;
  const SparseMatrix difference = matrix - transpose;
  const double apart = difference.coeffs().size() > 0 ? difference.coeffs().abs().maxCoeff() : 0.0;
  if (!symmetrize && !(apart <= kRoundingAsymmetry * largest)) {
    file.fail(path, ": not symmetric: its triangles differ by " + format_real(apart) + ", its largest entry is " +
                        format_real(largest) + "; --symmetrize takes their mean");
  }
  return 0.5 * (matrix + transpose);
}

/// The diagonal blocks that no entry leaves.
BlockInertia diagonal_blocks(const Hdf5File& file, const SparseMatrix& M) {
  BlockInertia inertia;
  Index begin = 0;
  Index last = -1;  // row of the block's entries so far
  std::size_t numbers = 0;
  for (Index column = 0; column < M.cols(); ++column) {
    last = std::max(last, column);
    for (SparseMatrix::InnerIterator it(M, column); it; ++it) last = std::max(last, it.row());
    if (last > column) continue;
    const auto order = static_cast<std::size_t>(column + 1 - begin);
    numbers += order * order;
    if (numbers > kMaxNumbers) {
      file.fail("/fclib_global/M",
                ": its dense diagonal blocks have more than " + std::to_string(kMaxNumbers) + " numbers");
    }
    inertia.blocks.push_back(Matrix(M.block(begin, begin, column + 1 - begin, column + 1 - begin)));
    begin = column + 1;
  }
  return inertia;
}

/// M^-1 f, by a Cholesky factorization of each block. @throws InputError where a block is not positive definite
Vector solve(const Hdf5File& file, const Inertia& inertia, const Vector& f) {
  Vector v(f.size());
  for_each_matrix(inertia, [&](const Matrix& block, Index at) {
    const Eigen::LLT<Matrix> cholesky(block);
    if (cholesky.info() != Eigen::Success) file.fail("/fclib_global/M", ": not positive definite");
    v.segment(at, block.rows()) = cholesky.solve(f.segment(at, block.rows()));
  });
  return v;
}

/// Columns of N and D from those of H: normal first, then the tangents, each also turned round.
void set_directions(const SparseMatrix& H, int dimension, ContactProblem& problem) {
  const Index contacts = H.cols() / dimension;
  const int edges = 2 * (dimension - 1);
  Triplets normals;
  Triplets tangents;
  for (Index contact = 0; contact < contacts; ++contact) {
    for (Index direction = 0; direction < dimension; ++direction) {
      for (SparseMatrix::InnerIterator it(H, contact * dimension + direction); it; ++it) {
        if (direction == 0) {
          normals.emplace_back(it.row(), contact, it.value());
          continue;
        }
        const Index column = contact * edges + direction - 1;
        tangents.emplace_back(it.row(), column, it.value());
        tangents.emplace_back(it.row(), column + edges / 2, -it.value());
      }
    }
  }
  SparseMatrix N(H.rows(), contacts);
  SparseMatrix D(H.rows(), contacts * edges);
  N.setFromTriplets(normals.begin(), normals.end());
  D.setFromTriplets(tangents.begin(), tangents.end());
  problem.N = N;
  problem.D = D;
  problem.edges.assign(static_cast<std::size_t>(contacts), edges);
}

int read_dimension(const Hdf5File& file, const std::string& group) {
  const int dimension = file.integer(group + "/spacedim");
  if (dimension == 5) file.fail(group, ": rolling friction (spacedim 5) is outside of the model");
  if (dimension != 2 && dimension != 3) {
    file.fail(group + "/spacedim", " is " + std::to_string(dimension) + ", expected 2 or 3");
  }
  return dimension;
}

/// @param forces  entries of r
void set_friction(const Hdf5File& file, const std::string& group, Index forces, ContactProblem& problem,
                  const SparseMatrix& H, int dimension) {
  if (forces % dimension != 0) file.fail(group, ": the forces are no multiple of spacedim");
  problem.mu = read_vector(file, group + "/vectors/mu", forces / dimension);
  set_directions(H, dimension, problem);
}

void refuse_equalities(const Hdf5File& file, const std::string& group) {
  if (!file.has(group + "/n") || file.integer(group + "/n") <= 0) return;
  file.fail(group, ": equality constraints are outside of the model");
}

ContactProblem read_global(const Hdf5File& file, bool symmetrize) {
  const std::string group = "/fclib_global";
  const int dimension = read_dimension(file, group);
  refuse_equalities(file, group + "/G");
  const SparseMatrix M = symmetric(file, group + "/M", read_matrix(file, group + "/M"), symmetrize);
  const SparseMatrix H = read_matrix(file, group + "/H");
  if (H.rows() != M.rows()) file.fail(group + "/H", ": as many rows as M are expected");
  ContactProblem problem;
  problem.inertia = diagonal_blocks(file, M);
  problem.v = solve(file, problem.inertia, read_vector(file, group + "/vectors/f", M.rows()));
  set_friction(file, group, H.cols(), problem, H, dimension);
  const Vector w = read_vector(file, group + "/vectors/w", H.cols());
  problem.b.resize(problem.nc());
  problem.offset_t.setZero(2 * problem.nc());
  for (Index i = 0; i < w.size(); ++i) {
    const Index contact = i / dimension, direction = i % dimension;
    (direction == 0 ? problem.b(contact) : problem.offset_t(2 * contact + direction - 1)) = w(i);
  }
  for (Vector* offset : {&problem.b, &problem.offset_t}) {
    if (offset->isZero(0)) offset->resize(0);
  }
  return problem;
}

ContactProblem read_local(const Hdf5File& file, bool symmetrize) {
  const std::string group = "/fclib_local";
  const int dimension = read_dimension(file, group);
  refuse_equalities(file, group + "/V");
  const SparseMatrix W = symmetric(file, group + "/W", read_matrix(file, group + "/W"), symmetrize);
  if (static_cast<std::size_t>(W.rows()) * static_cast<std::size_t>(W.rows()) > kMaxNumbers) {
    file.fail(group + "/W", ": " + std::to_string(W.rows()) + " rows are too many for a dense matrix");
  }
  ContactProblem problem;
  problem.v = read_vector(file, group + "/vectors/q", W.rows());
  problem.inertia = InverseInertia{Matrix(W)};
  SparseMatrix picks(W.rows(), W.rows());
  picks.setIdentity();
  set_friction(file, group, W.rows(), problem, picks, dimension);
  return problem;
}

}  // namespace

Problem read_fclib(const std::string& name, bool symmetrize) {
  const Hdf5File file(name);
  for (const char* group : {"/fclib_global_rolling", "/fclib_local_rolling"}) {
    if (file.has(group)) file.fail(group, ": rolling friction is outside of the model");
  }
  const bool global = file.has("/fclib_global");
  if (!global && !file.has("/fclib_local")) throw input_error(name, "has neither /fclib_global nor /fclib_local");
  ContactProblem problem = global ? read_global(file, symmetrize) : read_local(file, symmetrize);
  check_contact(problem, name);
  return Problem(problem_name_of_file(name), std::move(problem));
}

}  // namespace lcpbench
