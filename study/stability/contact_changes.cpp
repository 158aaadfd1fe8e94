#include "study/stability/contact_changes.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace lcpbench {
namespace {

/// One factor for each column of D from one for each contact.
Vector of_columns(const std::vector<int>& edges, const Vector& of_contacts) {
  std::vector<double> factors;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    factors.insert(factors.end(), static_cast<std::size_t>(edges[i]), of_contacts(static_cast<Index>(i)));
  }
  return Eigen::Map<const Vector>(factors.data(), static_cast<Index>(factors.size()));
}

bool positive_definite(const Matrix& matrix) {
  if (matrix.rows() == 0) return true;
  const Eigen::LLT<Matrix> cholesky(matrix);
  return cholesky.info() == Eigen::Success && cholesky.matrixLLT().diagonal().minCoeff() > 0;
}

}  // namespace

/// Changes a Jacobian as a dense matrix; a sparse one stays sparse.
void change(Jacobian& J, const std::function<Matrix(const Matrix&)>& of_dense) {
  const Matrix result = of_dense(to_dense(J));
  if (std::holds_alternative<SparseMatrix>(J)) {
    J = SparseMatrix(result.sparseView(0, 0));
  } else {
    J = result;
  }
}

void change_inertia(Inertia& inertia, const EntryChange& multiply, const EntryChange& divide) {
  const auto all = [](auto& matrix, const EntryChange& entry) { matrix = matrix.unaryExpr(entry).eval(); };
  if (auto* dense = std::get_if<DenseInertia>(&inertia)) {
    all(dense->G, multiply);
  } else if (auto* blocks = std::get_if<BlockInertia>(&inertia)) {
    for (Matrix& block : blocks->blocks) all(block, multiply);
  } else if (auto* factors = std::get_if<FactoredInertia>(&inertia)) {
    all(factors->alpha, multiply);
  } else {
    all(std::get<InverseInertia>(inertia).Ginv, divide);
  }
}

void change_length_of_bodies(ContactProblem& contact, const EntryChange& multiply, const EntryChange& divide) {
  const auto arms = [&](const Matrix& J) {
    Matrix result = J;
    for (Index i = 0; i < J.rows(); ++i) {
      if (is_angular(i)) result.row(i) = J.row(i).unaryExpr(multiply).eval();
    }
    return result;
  };
  change(contact.N, arms);
  change(contact.D, arms);
  for (Index i = 0; i < contact.v.size(); ++i) {
    if (!is_angular(i)) contact.v(i) = multiply(contact.v(i));
  }
  contact.b = contact.b.unaryExpr(multiply).eval();
  const auto moments = [](Matrix& G, const EntryChange& entry) {
    for (Index j = 0; j < G.cols(); ++j) {
      for (Index i = 0; i < G.rows(); ++i) {
        if (is_angular(i) && is_angular(j)) G(i, j) = entry(entry(G(i, j)));
      }
    }
  };
  if (auto* blocks = std::get_if<BlockInertia>(&contact.inertia)) {
    for (Matrix& block : blocks->blocks) moments(block, multiply);
  } else if (auto* dense = std::get_if<DenseInertia>(&contact.inertia)) {
    moments(dense->G, multiply);
  } else {
    moments(std::get<InverseInertia>(contact.inertia).Ginv, divide);
  }
}

void scale_contacts(ContactProblem& contact, const Vector& factors) {
  change(contact.N, [&](const Matrix& N) { return Matrix(N * factors.asDiagonal()); });
  if (contact.has_offset()) contact.b = Vector(contact.b.cwiseProduct(factors));
  change(contact.D, [&](const Matrix& D) { return Matrix(D * of_columns(contact.edges, factors).asDiagonal()); });
}

void select_contacts(ContactProblem& contact, const std::vector<Index>& order) {
  const ContactLayout layout = contact_layout(contact);
  std::vector<Index> columns;
  std::vector<int> edges;
  for (const Index i : order) {
    const auto c = static_cast<std::size_t>(i);
    for (Index t = layout.friction_begin[c]; t < layout.friction_begin[c + 1]; ++t) columns.push_back(t);
    edges.push_back(contact.edges[c]);
  }
  change(contact.N, [&](const Matrix& N) { return Matrix(N(Eigen::all, order)); });
  change(contact.D, [&](const Matrix& D) { return Matrix(D(Eigen::all, columns)); });
  contact.mu = Vector(contact.mu(order));
  if (contact.has_offset()) contact.b = Vector(contact.b(order));
  contact.edges = std::move(edges);
}

void shift_directions(ContactProblem& contact, const std::vector<int>& by) {
  const ContactLayout layout = contact_layout(contact);
  std::vector<Index> columns;
  for (std::size_t i = 0; i < contact.edges.size(); ++i) {
    for (int t = 0; t < contact.edges[i]; ++t) {
      columns.push_back(layout.friction_begin[i] + (t + by[i]) % contact.edges[i]);
    }
  }
  change(contact.D, [&](const Matrix& D) { return Matrix(D(Eigen::all, columns)); });
}

void move_last_contact(ContactProblem& contact, const Vector& normal, const Matrix& directions) {
  change(contact.N, [&](Matrix N) {
    N.rightCols(1) = normal;
    return N;
  });
  change(contact.D, [&](Matrix D) {
    const Index half = directions.cols();
    D.middleCols(D.cols() - 2 * half, half) = directions;
    D.rightCols(half) = -directions;
    return D;
  });
}

bool has_definite_inertia(const Inertia& inertia) {
  if (const auto* dense = std::get_if<DenseInertia>(&inertia)) return positive_definite(dense->G);
  if (const auto* inverse = std::get_if<InverseInertia>(&inertia)) return positive_definite(inverse->Ginv);
  const auto* blocks = std::get_if<BlockInertia>(&inertia);
  return blocks == nullptr || std::all_of(blocks->blocks.begin(), blocks->blocks.end(), positive_definite);
}

void Nudge::operator()(double& x) {
  if (x == 0) return;
  const bool up = (draws_.integer(0, 1) == 0) == forth_;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const double neighbour = std::nextafter(x, up ? kInfinity : -kInfinity);
  largest_change_ = std::max(largest_change_, std::abs((neighbour - x) / x));
  x = neighbour;
}

void Nudge::vector(Vector& x) {
  for (double& entry : x) (*this)(entry);
}

void Nudge::matrix(Matrix& A) {
  for (Index j = 0; j < A.cols(); ++j) {
    for (Index i = 0; i < A.rows(); ++i) (*this)(A(i, j));
  }
}

void Nudge::symmetric(Matrix& A) {
  for (Index j = 0; j < A.cols(); ++j) {
    for (Index i = j; i < A.rows(); ++i) {
      (*this)(A(i, j));
      A(j, i) = A(i, j);
    }
  }
}

void Nudge::inertia(Inertia& inertia) {
  if (auto* dense = std::get_if<DenseInertia>(&inertia)) {
    symmetric(dense->G);
  } else if (auto* blocks = std::get_if<BlockInertia>(&inertia)) {
    for (Matrix& block : blocks->blocks) symmetric(block);
  } else if (auto* factors = std::get_if<FactoredInertia>(&inertia)) {
    matrix(factors->X);
    vector(factors->alpha);
  } else {
    symmetric(std::get<InverseInertia>(inertia).Ginv);
  }
}

void Nudge::directions(ContactProblem& contact) {
  const ContactLayout layout = contact_layout(contact);
  change(contact.D, [&](Matrix D) {
    for (std::size_t i = 0; i < contact.edges.size(); ++i) {
      const Index half = contact.edges[i] / 2;
      for (Index t = layout.friction_begin[i]; t < layout.friction_begin[i] + half; ++t) {
        for (Index row = 0; row < D.rows(); ++row) {
          (*this)(D(row, t));
          if (D(row, t) != 0) D(row, t + half) = -D(row, t);  // a zero keeps its sign
        }
      }
    }
    return D;
  });
}

void Nudge::contact(ContactProblem& contact) {
  vector(contact.v);
  change(contact.N, [&](Matrix N) {
    matrix(N);
    return N;
  });
  directions(contact);
  vector(contact.mu);
  inertia(contact.inertia);
  vector(contact.b);
}

}  // namespace lcpbench
