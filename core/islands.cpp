#include "core/islands.h"

#include <algorithm>
#include <variant>

#include "core/entries.h"

namespace lcpbench {
namespace {

/// Disjoint sets of the indices 0 to count - 1, joined one pair at a time, in memory of the caller's. Runs of
/// neighbours that were seen in one set are kept: sets only grow, so that they stay in one.
class DisjointSets {
 public:
  DisjointSets(Index count, std::vector<Index>& parents, std::vector<Index>& run_ends)
      : parent_(parents), run_end_(run_ends) {
    parent_.resize(static_cast<std::size_t>(count));
    run_end_.resize(static_cast<std::size_t>(count));
    for (Index i = 0; i < count; ++i) {
      parent(i) = i;
      run_end_[static_cast<std::size_t>(i)] = i + 1;
    }
  }

  Index find(Index i) {
    while (parent(i) != i) i = parent(i) = parent(parent(i));
    return i;
  }
  /// Whether these are in one set. False where only find() would tell.
  bool are_one(Index first, Index number) {
    Index same = 1;
    while (same < number && parent(first + same) == parent(first)) ++same;
    return same >= number;
  }
  /// Joins the set of i to that of a representative. The lower representative stays one: the sets do not depend on the
  /// order of calls. @returns the representative
  Index unite(Index representative, Index i) {
    if (parent(i) == representative) return representative;
    const Index other = find(i);
    const Index lower = std::min(representative, other);
    parent(std::max(representative, other)) = lower;
    return lower;
  }

  /// These are in one set.
  void keep_run(Index first, Index number) { std::fill_n(run_ends() + first, number, first + number); }
  /// Joins these, of which none was joined before.
  void join_run(Index first, Index number) {
    std::fill_n(parent_.data() + first, number, first);
    keep_run(first, number);
  }

  const Index* parents() const { return parent_.data(); }
  /// The indices i to run_ends()[i] - 1 are in one set.
  Index* run_ends() { return run_end_.data(); }

 private:
  Index& parent(Index i) { return parent_[static_cast<std::size_t>(i)]; }
  std::vector<Index>& parent_;
  std::vector<Index>& run_end_;
};

/// Joins all rows that it visits.
class Joined {
 public:
  explicit Joined(DisjointSets& sets) : sets_(sets) {}
  void operator()(Index row) { representative_ = any() ? sets_.unite(representative_, row) : sets_.find(row); }
  bool any() const { return representative_ >= 0; }
  /// Of the set with all rows; -1 where there was none.
  Index representative() const { return representative_; }

  /// Keeps that rows `first` to `end` - 1 are in the set, the last that it was told.
  void keep_run(Index first, Index end) {
    run_ = first;
    run_end_ = end;
  }
  bool has_run(Index first, Index last) const { return first >= run_ && last < run_end_; }

 private:
  DisjointSets& sets_;
  Index representative_ = -1;
  Index run_ = 0;
  Index run_end_ = 0;
};

/// Joins the rows of the nonzero entries of columns of one Jacobian.
class ColumnJoiner {
 public:
  ColumnJoiner(const Jacobian& J, DisjointSets& sets) : J_(J), parents_(sets.parents()), run_ends_(sets.run_ends()) {
    const auto* sparse = std::get_if<SparseMatrix>(&J);
    if (sparse == nullptr || !sparse->isCompressed()) return;
    values_ = sparse->valuePtr();
    rows_ = sparse->innerIndexPtr();
    begins_ = sparse->outerIndexPtr();
  }

  void join(Index column, Joined& joined) const {
    if (begins_ == nullptr) {
      return for_each_entry(J_, column, [&](Index row, double) { joined(row); });
    }
    const int begin = begins_[column];
    const int end = begins_[column + 1];
    if (begin < end && !joined.has_run(rows_[begin], rows_[end - 1])) join_runs(begin, end, joined);
  }

 private:
  /// Of a run that is one set it looks at the first entry that joins it.
  void join_runs(int begin, int end, Joined& joined) const {
    Index representative = joined.representative();
    Index run = -1;  // rows run to run_end - 1 are in the set
    Index run_end = -1;
    for (int k = begin; k < end;) {
      const Index row = rows_[k];
      if (parents_[row] != representative) {
        if (values_[k] == 0) {
          ++k;
          continue;
        }
        joined(row);
        representative = joined.representative();
      }
      if (row != run_end) run = row;
      run_end = run_ends_[row];
      run_ends_[run] = run_end;
      const Index last = k + (run_end - row) - 1;  // where the run's last row is if all its rows have entries
      if (last < end && rows_[last] == run_end - 1) {
        k = static_cast<int>(last) + 1;
      } else {
        while (k < end && rows_[k] < run_end) ++k;
      }
    }
    if (run >= 0) joined.keep_run(run, run_end);
  }

  const Jacobian& J_;
  const Index* parents_;  // most of the rows that were joined last have the representative for a parent
  Index* run_ends_;
  const double* values_ = nullptr;  // these of compressed sparse columns
  const int* rows_ = nullptr;
  const int* begins_ = nullptr;
};

/// A column without zeros. Of a symmetric positive definite matrix, or a factor.
bool has_full_column(const Matrix& matrix) {
  if (matrix.rows() == 0) return true;
  return matrix.cols() > 0 && (matrix.col(0).array() != 0).all();
}

/// Stops where the columns so far have joined all rows. @pre none of them was joined before
void join_columns(const Matrix& matrix, Index offset, DisjointSets& sets) {
  if (has_full_column(matrix)) return sets.join_run(offset, matrix.rows());
  bool is_one = false;
  for (Index j = 0; j < matrix.cols() && !is_one; ++j) {
    Joined joined(sets);
    for_each_entry(matrix, j, [&](Index row, double) { joined(offset + row); });
    is_one = sets.are_one(offset, matrix.rows());
  }
  if (is_one) sets.keep_run(offset, matrix.rows());
}

/// Calls visit(i, load) for each row of friction.
template <class Visit>
void for_each_friction_row(const BoundedRows& rows, const Visit& visit) {
  for (std::size_t i = 0; i < rows.bounds.friction_of.size(); ++i) {
    if (const int of = rows.bounds.friction_of[i]; of >= 0) visit(i, static_cast<std::size_t>(of));
  }
}

/// Of each row a coordinate that it moves, or the row that bounds its friction, or another row of that friction; -1
/// where there is none.
void join_rows(const BoundedRows& rows, DisjointSets& sets, std::vector<Index>& coordinates) {
  const ColumnJoiner columns(rows.R, sets);
  for (Index i = 0; i < rows.size(); ++i) {
    Joined joined(sets);
    columns.join(i, joined);
    coordinates[static_cast<std::size_t>(i)] = joined.representative();
  }
  for_each_friction_row(rows, [&](std::size_t i, std::size_t load) {
    Joined joined(sets);
    for (const Index coordinate : {coordinates[load], coordinates[i]}) {
      if (coordinate >= 0) joined(coordinate);
    }
    coordinates[load] = joined.representative();
  });
  for_each_friction_row(rows, [&](std::size_t i, std::size_t load) { coordinates[i] = coordinates[load]; });
}

}  // namespace

bool couples_all(const Inertia& inertia) {
  const auto* bodies = std::get_if<BlockInertia>(&inertia);
  bool all = bodies == nullptr || bodies->blocks.size() <= 1;
  for_each_matrix(inertia, [&](const Matrix& matrix, Index) { all = all && has_full_column(matrix); });
  return all;
}

void IslandNumbers::reserve(Index ngc, Index nc) {
  of_contact.reserve(static_cast<std::size_t>(nc));
  for (std::vector<Index>* by_coordinate : {&of_coordinate, &parent_, &run_end_, &number_}) {
    by_coordinate->reserve(static_cast<std::size_t>(ngc));
  }
}

void IslandNumbers::find(const ContactProblem& problem) {
  DisjointSets sets(problem.ngc(), parent_, run_end_);
  for_each_matrix(problem.inertia, [&](const Matrix& matrix, Index first) { join_columns(matrix, first, sets); });
  of_contact.resize(problem.edges.size());  // at first a coordinate that it moves; its island's number below
  const ColumnJoiner normals(problem.N, sets);
  const ColumnJoiner tangents(problem.D, sets);
  Index direction = 0;
  for (Index c = 0; c < problem.nc(); ++c) {
    const int edges = problem.edges[static_cast<std::size_t>(c)];
    Joined joined(sets);
    normals.join(c, joined);
    for (Index t = 0; t < edges / 2; ++t) {  // the second half of the directions are the negatives of the first
      tangents.join(direction + t, joined);
    }
    direction += edges;
    of_contact[static_cast<std::size_t>(c)] = joined.representative();
  }
  of_row.resize(static_cast<std::size_t>(problem.rows.size()));
  if (problem.has_rows()) join_rows(problem.rows, sets, of_row);

  count = 0;
  number_.assign(static_cast<std::size_t>(problem.ngc()), -1);
  const auto number = [&](std::vector<Index>& coordinates, const auto& yields) {
    for (std::size_t i = 0; i < coordinates.size(); ++i) {
      if (coordinates[i] < 0) {
        if (yields(static_cast<Index>(i)) > 0) coordinates[i] = count++;
        continue;
      }
      Index& own = number_[static_cast<std::size_t>(sets.find(coordinates[i]))];
      if (own < 0) own = count++;
      coordinates[i] = own;
    }
  };
  number(of_contact, [&](Index contact) { return problem.normal_compliance(contact); });
  number(of_row, [&](Index row) {
    return problem.rows.bounds.friction_of[static_cast<std::size_t>(row)] >= 0 ? 0.0 : problem.rows.yields(row);
  });
  for_each_friction_row(problem.rows, [&](std::size_t i, std::size_t load) { of_row[i] = of_row[load]; });
  of_coordinate.resize(static_cast<std::size_t>(problem.ngc()));
  for (Index i = 0; i < problem.ngc(); ++i) {
    of_coordinate[static_cast<std::size_t>(i)] = number_[static_cast<std::size_t>(sets.find(i))];
  }
}

void IslandNumbers::take_as_one(const ContactProblem& problem) {
  count = 1;
  of_contact.assign(problem.edges.size(), 0);
  of_row.assign(static_cast<std::size_t>(problem.rows.size()), 0);
  of_coordinate.assign(static_cast<std::size_t>(problem.ngc()), 0);
}

std::vector<Island> find_islands(const ContactProblem& problem) {
  IslandNumbers numbers;
  numbers.find(problem);
  std::vector<Island> islands;
  numbers.list(islands);
  return islands;
}

void IslandNumbers::list(std::vector<Island>& islands) const {
  islands.resize(static_cast<std::size_t>(count));
  for (Island& island : islands) {
    island.contacts.clear();
    island.coordinates.clear();
    island.rows.clear();
  }
  if (count == 1) {
    islands.front().contacts.reserve(of_contact.size());
    islands.front().coordinates.reserve(of_coordinate.size());
  }
  for (std::size_t c = 0; c < of_contact.size(); ++c) {
    if (of_contact[c] < 0) continue;
    islands[static_cast<std::size_t>(of_contact[c])].contacts.push_back(static_cast<Index>(c));
  }
  for (std::size_t i = 0; i < of_row.size(); ++i) {
    if (of_row[i] >= 0) islands[static_cast<std::size_t>(of_row[i])].rows.push_back(static_cast<Index>(i));
  }
  for (std::size_t i = 0; i < of_coordinate.size(); ++i) {
    if (of_coordinate[i] < 0) continue;
    islands[static_cast<std::size_t>(of_coordinate[i])].coordinates.push_back(static_cast<Index>(i));
  }
}

RowIslands row_islands(const ContactProblem& problem) {
  thread_local IslandNumbers islands;  // reuses its memory
  islands.find(problem);
  const ContactLayout layout = contact_layout(problem);
  RowIslands rows;
  rows.of_row.resize(static_cast<std::size_t>(layout.size()));
  // By number in `islands`, the number in `rows`, where contacts that are in none of `islands` are counted, too.
  std::vector<Index> numbers(static_cast<std::size_t>(islands.count), -1);
  const auto number_of = [&](Index island) {
    Index number = island < 0 ? -1 : numbers[static_cast<std::size_t>(island)];
    if (number < 0) number = rows.count++;
    if (island >= 0) numbers[static_cast<std::size_t>(island)] = number;
    return number;
  };
  for (Index c = 0; c < problem.nc(); ++c) {
    const auto contact = static_cast<std::size_t>(c);
    const Index number = number_of(islands.of_contact[contact]);
    const auto set = [&](Index row) { rows.of_row[static_cast<std::size_t>(row)] = number; };
    set(c);
    for (Index t = layout.friction_begin[contact]; t < layout.friction_begin[contact + 1]; ++t) {
      set(layout.friction_offset() + t);
    }
    if (layout.lambda[contact] >= 0) set(layout.lambda_offset() + layout.lambda[contact]);
  }
  const auto first = static_cast<std::size_t>(layout.row_offset());
  std::fill(rows.of_row.begin() + layout.row_offset(), rows.of_row.end(), -1);
  for (std::size_t i = 0; i < islands.of_row.size(); ++i) {
    const int of = problem.rows.bounds.friction_of[i];
    const std::size_t load = of >= 0 ? static_cast<std::size_t>(of) : i;
    Index& of_load = rows.of_row[first + load];
    if (of_load < 0) of_load = number_of(islands.of_row[load]);
    rows.of_row[first + i] = of_load;
  }
  return rows;
}

RowIslands row_islands(const Matrix& M) {
  RowIslands rows;
  std::vector<Index> queue;
  find_row_islands(M, rows, queue);
  return rows;
}

void find_row_islands(const Matrix& M, RowIslands& rows, std::vector<Index>& queue) {
  const Index n = M.rows();
  rows.of_row.assign(static_cast<std::size_t>(n), -1);
  rows.count = 0;
  queue.clear();
  queue.reserve(static_cast<std::size_t>(n));
  std::size_t next = 0;  // in the queue, which ends as a list of all rows
  for (Index first = 0; first < n; ++first) {
    const auto join = [&](Index row) {
      Index& island = rows.of_row[static_cast<std::size_t>(row)];
      if (island >= 0) return;
      island = rows.count;
      queue.push_back(row);
    };
    if (rows.of_row[static_cast<std::size_t>(first)] >= 0) continue;
    for (join(first); next < queue.size() && queue.size() < static_cast<std::size_t>(n); ++next) {
      const Index row = queue[next];
      for (Index other = 0; other < n; ++other) {
        if (rows.of_row[static_cast<std::size_t>(other)] < 0 && (M(other, row) != 0 || M(row, other) != 0)) join(other);
      }
    }
    ++rows.count;
  }
}

}  // namespace lcpbench
