// Compiled once per instruction-set level into the namespace LCPBENCH_LEVEL; see cholesky_engine.h for what may cross
// the border.
#include "native/kernels/cholesky_engine.h"

#if !defined(LCPBENCH_LEVEL)
#error "LCPBENCH_LEVEL names the instruction-set level"
#endif

namespace lcpbench::cholesky::LCPBENCH_LEVEL {
namespace {

using Count = std::ptrdiff_t;

#if defined(__AVX2__)
constexpr Count kPackBytes = 32;
constexpr Count kTall = 3;  // blocks of rows in a tile: as many as sixteen registers hold
#else
constexpr Count kPackBytes = 16;
constexpr Count kTall = 1;
#endif
typedef double Pack __attribute__((vector_size(kPackBytes)));

constexpr Count kLanes = kPackBytes / static_cast<Count>(sizeof(double));
constexpr Count kBlock = 4;                // rows, and columns, that are dealt with together
constexpr Count kPacks = kBlock / kLanes;  // of a block's column
constexpr Count kDepth = 64;               // columns of a panel: what is packed of them stays near
static_assert(kMargin == kBlock - 1 && work_size(1) == (1 + kMargin) * kDepth);

Pack load(const double* from) {
  Pack pack;
  __builtin_memcpy(&pack, from, sizeof(pack));
  return pack;
}
void store(double* to, Pack pack) { __builtin_memcpy(to, &pack, sizeof(pack)); }
double sum(Pack pack) {
  double lanes[static_cast<std::size_t>(kLanes)];
  store(lanes, pack);
  double total = lanes[0];
  for (Count lane = 1; lane < kLanes; ++lane) total += lanes[lane];
  return total;
}

/// Calls work<columns>() for the columns that are left of whole blocks; for none, nothing.
template <class Work>
void with_rest(Count columns, const Work& work) {
  switch (columns) {
    case 1: return work.template operator()<1>();
    case 2: return work.template operator()<2>();
    case 3: return work.template operator()<3>();
    default: return;
  }
}

/// B (rows x depth) as blocks of four rows, each by columns: block b begins at 4 b depth.
void pack_blocks(const double* b, Count stride, Count rows, Count depth, double* packed) {
  for (Count row = 0; row < rows; row += kBlock) {
    for (Count p = 0; p < depth; ++p, packed += kBlock) {
      for (Count r = 0; r < kBlock; r += kLanes) store(packed + r, load(b + p * stride + row + r));
    }
  }
}

/// Adds or subtracts left right' for `kBlocks` packed blocks of rows on the left, one on the right.
template <Count kBlocks, bool kAdd>
void update_tile(double* a, Count stride, const double* left, const double* right, Count depth) {
  constexpr Count kRows = kBlocks * kPacks;
  Pack total[static_cast<std::size_t>(kBlock)][static_cast<std::size_t>(kRows)] = {};
  for (Count p = 0; p < depth; ++p, left += kBlock, right += kBlock) {
    Pack rows[static_cast<std::size_t>(kRows)];
    for (Count block = 0; block < kBlocks; ++block) {
      for (Count r = 0; r < kPacks; ++r) rows[block * kPacks + r] = load(left + block * depth * kBlock + r * kLanes);
    }
    for (Count column = 0; column < kBlock; ++column) {
      for (Count r = 0; r < kRows; ++r) total[column][r] += rows[r] * right[column];
    }
  }
  for (Count column = 0; column < kBlock; ++column) {
    for (Count r = 0; r < kRows; ++r) {
      double* const to = a + column * stride + r * kLanes;
      store(to, kAdd ? load(to) + total[column][r] : load(to) - total[column][r]);
    }
  }
}

/// The lower triangle of a (rows x rows) plus or minus B C', B and C (rows x depth) packed.
template <bool kAdd>
void update(double* a, Count stride, Count rows, const double* b, const double* c, Count depth) {
  for (Count column = 0; column < rows; column += kBlock) {
    const double* const right = c + column * depth;
    Count row = column;
    const auto tile = [&]<Count kBlocks>() {
      for (; row + (kBlocks - 1) * kBlock < rows; row += kBlocks * kBlock) {
        update_tile<kBlocks, kAdd>(a + column * stride + row, stride, b + row * depth, right, depth);
      }
    };
    tile.template operator()<kTall>();
    if constexpr (kTall > 2) tile.template operator()<2>();
    tile.template operator()<1>();
  }
}

/// The first kColumns <= 4 columns of L in place of those of a (rows x kColumns).
template <Count kColumns>
bool factor_columns(double* a, Count stride, Count rows) {
  double l[static_cast<std::size_t>(kColumns)][static_cast<std::size_t>(kColumns)];
  double inverse[static_cast<std::size_t>(kColumns)];
  for (Count c = 0; c < kColumns; ++c) {
    double pivot = a[c * stride + c];
    for (Count p = 0; p < c; ++p) pivot -= l[c][p] * l[c][p];
    if (!(pivot > 0 && pivot < __builtin_inf())) return false;
    l[c][c] = __builtin_sqrt(pivot);
    inverse[c] = 1 / l[c][c];
    for (Count r = c + 1; r < kColumns; ++r) {
      double entry = a[c * stride + r];
      for (Count p = 0; p < c; ++p) entry -= l[r][p] * l[c][p];
      l[r][c] = entry * inverse[c];
    }
    for (Count r = c; r < kColumns; ++r) a[c * stride + r] = l[r][c];
  }
  for (Count row = kColumns; row < rows; row += kLanes) {
    Pack x[static_cast<std::size_t>(kColumns)];
    for (Count c = 0; c < kColumns; ++c) {
      x[c] = load(a + c * stride + row);
      for (Count p = 0; p < c; ++p) x[c] -= x[p] * l[c][p];
      x[c] *= inverse[c];
      store(a + c * stride + row, x[c]);
    }
  }
  return true;
}

/// Subtracts the part of the first kColumns columns from the columns after them, up to `columns`.
template <Count kColumns>
void subtract_columns(double* a, Count stride, Count rows, Count columns) {
  const auto subtract = [&]<Count kTogether>(Count c) {
    double factor[static_cast<std::size_t>(kTogether)][static_cast<std::size_t>(kColumns)];
    for (Count k = 0; k < kTogether; ++k) {
      for (Count p = 0; p < kColumns; ++p) factor[k][p] = a[p * stride + c + k];
    }
    double* const to = a + c * stride;
    for (Count row = c; row < rows; row += kLanes) {
      Pack x[static_cast<std::size_t>(kTogether)];
      for (Count k = 0; k < kTogether; ++k) x[k] = load(to + k * stride + row);
      for (Count p = 0; p < kColumns; ++p) {
        const Pack part = load(a + p * stride + row);
        for (Count k = 0; k < kTogether; ++k) x[k] -= part * factor[k][p];
      }
      for (Count k = 0; k < kTogether; ++k) store(to + k * stride + row, x[k]);
    }
  };
  Count c = kColumns;
  for (; c + 2 <= columns; c += 2) subtract.template operator()<2>(c);
  if (c < columns) subtract.template operator()<1>(c);
}

/// The first `columns` columns of L in place of those of a (rows x columns).
bool factor_panel(double* a, Count stride, Count rows, Count columns) {
  for (; columns >= kBlock; a += kBlock * (stride + 1), rows -= kBlock, columns -= kBlock) {
    if (!factor_columns<kBlock>(a, stride, rows)) return false;
    subtract_columns<kBlock>(a, stride, rows, columns);
  }
  bool is_factored = true;
  with_rest(columns, [&]<Count kColumns>() { is_factored = factor_columns<kColumns>(a, stride, rows); });
  return is_factored;
}

bool factor(double* a, Count stride, Count rows, Count columns, double* work) {
  while (columns > 0) {
    const Count depth = columns < kDepth ? columns : kDepth;
    if (!factor_panel(a, stride, rows, depth)) return false;
    rows -= depth;
    columns -= depth;
    pack_blocks(a + depth, stride, rows, depth, work);
    a += depth * (stride + 1);
    update<false>(a, stride, rows, work, work, depth);
  }
  return true;
}

void add_product(double* a, Count stride, const double* b, Count b_stride, Count rows, Count columns, double* work) {
  for (Count first = 0; first < columns; first += kDepth) {
    const Count depth = columns - first < kDepth ? columns - first : kDepth;
    pack_blocks(b + first * b_stride, b_stride, rows, depth, work);
    update<true>(a, stride, rows, work, work, depth);
  }
}

void swap(double& a, double& b) {
  const double keep = a;
  a = b;
  b = keep;
}

/// A square part of a panel, by columns.
struct Square {
  double entries[static_cast<std::size_t>(kDepth * kDepth)];

  double& at(Count row, Count column) { return entries[column * kDepth + row]; }
};

/// A = L U with partial pivoting, in place; row k was exchanged with row swaps[k].
bool factor_square(Square& a, Count order, int* swaps) {
  for (Count k = 0; k < order; ++k) {
    Count pivot = k;
    for (Count r = k + 1; r < order; ++r) {
      if (__builtin_fabs(a.at(r, k)) > __builtin_fabs(a.at(pivot, k))) pivot = r;
    }
    swaps[k] = static_cast<int>(pivot);
    for (Count c = 0; c < order && pivot != k; ++c) swap(a.at(k, c), a.at(pivot, c));
    const double inverse = 1 / a.at(k, k);
    if (!(__builtin_fabs(inverse) < __builtin_inf() && inverse != 0)) return false;
    for (Count r = k + 1; r < order; ++r) a.at(r, k) *= inverse;
    for (Count c = k + 1; c < order; ++c) {
      for (Count r = k + 1; r < order; ++r) a.at(r, c) -= a.at(r, k) * a.at(k, c);
    }
  }
  return true;
}

/// a := a T^-1 for a (rows x depth), with its margin, and the upper triangle T of `t`, whose diagonal is not read: of
/// that `inverse` has the reciprocals.
void solve_rows(double* a, Count stride, Count rows, Square& t, const double* inverse, Count depth) {
  Count c = 0;
  const auto columns = [&]<Count kTogether>() {
    for (Count row = 0; row < rows; row += kLanes) {
      Pack x[static_cast<std::size_t>(kTogether)];
      for (Count k = 0; k < kTogether; ++k) x[k] = load(a + (c + k) * stride + row);
      for (Count p = 0; p < c; ++p) {
        const Pack part = load(a + p * stride + row);
        for (Count k = 0; k < kTogether; ++k) x[k] -= part * t.at(p, c + k);
      }
      for (Count k = 0; k < kTogether; ++k) {
        for (Count p = 0; p < k; ++p) x[k] -= x[p] * t.at(c + p, c + k);
        x[k] *= inverse[c + k];
        store(a + (c + k) * stride + row, x[k]);
      }
    }
    c += kTogether;
  };
  while (c + kBlock <= depth) columns.template operator()<kBlock>();
  while (c < depth) columns.template operator()<1>();
}

bool factor_lu(double* lower, double* upper, Count stride, Count rows, Count columns, int* swaps, double* work) {
  Square own, transposed;
  for (Count first = 0, depth = 0; first < columns; first += depth) {
    depth = columns - first < kDepth ? columns - first : kDepth;
    const Count rest = rows - first - depth;
    double* const l = lower + first * (stride + 1);
    double* const u = upper + first * (stride + 1);
    for (Count c = 0; c < depth; ++c) {
      for (Count r = 0; r < depth; ++r) own.at(r, c) = r < c ? u[r * stride + c] : l[c * stride + r];
    }
    if (!factor_square(own, depth, swaps + first)) return false;
    double one[static_cast<std::size_t>(kDepth)], inverse[static_cast<std::size_t>(kDepth)];
    for (Count c = 0; c < depth; ++c) {
      one[c] = 1;
      inverse[c] = 1 / own.at(c, c);
      for (Count r = 0; r < depth; ++r) {
        transposed.at(r, c) = own.at(c, r);
        if (r >= c) l[c * stride + r] = r == c ? 1 : own.at(r, c);
        if (r >= c) u[c * stride + r] = own.at(c, r);
      }
    }
    for (Count k = 0; k < depth; ++k) {
      const Count other = swaps[first + k];
      swaps[first + k] = static_cast<int>(first + other);
      if (other == k) continue;
      for (Count c = 0; c < first; ++c) swap(lower[c * stride + first + k], lower[c * stride + first + other]);
      for (Count r = depth; r < depth + rest; ++r) swap(u[k * stride + r], u[other * stride + r]);
    }
    solve_rows(l + depth, stride, rest, own, inverse, depth);
    solve_rows(u + depth, stride, rest, transposed, one, depth);
    double* const packed_u = work + work_size(rows);
    pack_blocks(l + depth, stride, rest, depth, work);
    pack_blocks(u + depth, stride, rest, depth, packed_u);
    update<false>(l + depth * (stride + 1), stride, rest, work, packed_u, depth);
    update<false>(u + depth * (stride + 1), stride, rest, packed_u, work, depth);
  }
  return true;
}

/// x := ([l I])^-1 x for kColumns columns of L, from their first diagonal entry on.
template <Count kColumns>
void solve_lower_columns(const double* l, Count rows, Count stride, double* x) {
  double value[static_cast<std::size_t>(kColumns)];
  for (Count c = 0; c < kColumns; ++c) {
    double entry = x[c];
    for (Count p = 0; p < c; ++p) entry -= l[p * stride + c] * value[p];
    value[c] = x[c] = entry * l[c * stride + c];
  }
  Count row = kColumns;
  for (; row + kLanes <= rows; row += kLanes) {
    Pack rest = load(x + row);
    for (Count c = 0; c < kColumns; ++c) rest -= load(l + c * stride + row) * value[c];
    store(x + row, rest);
  }
  for (; row < rows; ++row) {
    for (Count c = 0; c < kColumns; ++c) x[row] -= l[c * stride + row] * value[c];
  }
}

/// The same with the transpose.
template <Count kColumns>
void solve_transposed_columns(const double* l, Count rows, Count stride, double* x) {
  Pack totals[static_cast<std::size_t>(kColumns)] = {};
  Count row = kColumns;
  for (; row + kLanes <= rows; row += kLanes) {
    const Pack rest = load(x + row);
    for (Count c = 0; c < kColumns; ++c) totals[c] += load(l + c * stride + row) * rest;
  }
  double total[static_cast<std::size_t>(kColumns)] = {};
  for (; row < rows; ++row) {
    for (Count c = 0; c < kColumns; ++c) total[c] += l[c * stride + row] * x[row];
  }
  // Scaled beforehand, so that each value waits for one multiplication with the last.
  double value[static_cast<std::size_t>(kColumns)];
  double own[static_cast<std::size_t>(kColumns)][static_cast<std::size_t>(kColumns)];
  for (Count c = 0; c < kColumns; ++c) {
    const double inverse = l[c * stride + c];
    value[c] = (x[c] - total[c] - sum(totals[c])) * inverse;
    for (Count p = c + 1; p < kColumns; ++p) own[c][p] = l[c * stride + p] * inverse;
  }
  for (Count p = kColumns; p-- > 1;) {
    for (Count c = 0; c < p; ++c) value[c] -= own[c][p] * value[p];
  }
  __builtin_memcpy(x, value, sizeof(value));
}

void solve_lower(const double* l, Count rows, Count columns, double* x) {
  const Count stride = rows;
  for (; columns >= kBlock; l += kBlock * (stride + 1), x += kBlock, rows -= kBlock, columns -= kBlock) {
    solve_lower_columns<kBlock>(l, rows, stride, x);
  }
  with_rest(columns, [&]<Count kColumns>() { solve_lower_columns<kColumns>(l, rows, stride, x); });
}

void solve_transposed(const double* l, Count rows, Count columns, double* x) {
  const Count stride = rows;
  Count done = columns / kBlock * kBlock;
  const auto at = [&](Count column) { return l + column * (stride + 1); };
  with_rest(columns - done, [&]<Count kColumns>() {
    solve_transposed_columns<kColumns>(at(done), rows - done, stride, x + done);
  });
  while (done > 0) {
    done -= kBlock;
    solve_transposed_columns<kBlock>(at(done), rows - done, stride, x + done);
  }
}

/// Columns `first` to `first` + kWide - 1 of L^-1, row by row from row `first` on in x; their squares are added up.
constexpr Count kWide = 2 * kBlock;
constexpr Count kWidePacks = kWide / kLanes;

/// kRows rows of these columns, of which `before` are known; they stand in x after those.
template <Count kRows>
void invert_rows(const double* l, Count stride, Count before, double* x, Pack* squares) {
  Pack rows[static_cast<std::size_t>(kRows)][static_cast<std::size_t>(kWidePacks)];
  double* const own = x + before * kWide;
  for (Count r = 0; r < kRows; ++r) {
    for (Count p = 0; p < kWidePacks; ++p) rows[r][p] = load(own + r * kWide + p * kLanes);
  }
  for (Count j = 0; j < before; ++j) {
    for (Count p = 0; p < kWidePacks; ++p) {
      const Pack known = load(x + j * kWide + p * kLanes);
      for (Count r = 0; r < kRows; ++r) rows[r][p] -= known * l[j * stride + before + r];
    }
  }
  for (Count r = 0; r < kRows; ++r) {
    const double* const column = l + (before + r) * stride + before;
    for (Count p = 0; p < kWidePacks; ++p) {
      rows[r][p] *= column[r];
      squares[p] += rows[r][p] * rows[r][p];
      store(own + r * kWide + p * kLanes, rows[r][p]);
      for (Count other = r + 1; other < kRows; ++other) rows[other][p] -= rows[r][p] * column[other];
    }
  }
}

void measure_inverse(const double* l, Count rows, double* lengths, double* work) {
  for (Count first = 0; first < rows; first += kWide) {
    const Count order = rows - first;
    const Count together = order < kWide ? order : kWide;
    __builtin_memset(work, 0, static_cast<std::size_t>(order * kWide) * sizeof(double));
    for (Count c = 0; c < together; ++c) work[c * kWide + c] = 1;
    Pack squares[static_cast<std::size_t>(kWidePacks)] = {};
    const double* const diagonal = l + first * (rows + 1);
    Count row = 0;
    for (; row + kBlock <= order; row += kBlock) invert_rows<kBlock>(diagonal, rows, row, work, squares);
    for (; row < order; ++row) invert_rows<1>(diagonal, rows, row, work, squares);
    for (Count c = 0; c < together; ++c) {
      double lanes[static_cast<std::size_t>(kLanes)];
      store(lanes, squares[c / kLanes]);
      lengths[first + c] = __builtin_sqrt(lanes[c % kLanes]);
    }
  }
}

}  // namespace

const Engine kEngine{factor, factor_lu, add_product, solve_lower, solve_transposed, measure_inverse};

}  // namespace lcpbench::cholesky::LCPBENCH_LEVEL
