// Compiled once per instruction-set level into the namespace LCPBENCH_LEVEL; see tableau_engine.h for what may cross
// the border.
#include "native/lcp_ladder/tableau_engine.h"

#if !defined(LCPBENCH_LEVEL)
#error "LCPBENCH_LEVEL names the instruction-set level"
#endif

namespace lcpbench::tableau::LCPBENCH_LEVEL {
namespace {

using Count = std::ptrdiff_t;

double* aligned(double* column) {
  return static_cast<double*>(__builtin_assume_aligned(column, kLine * sizeof(double)));
}

/// Multiples of pivot columns that one column gets, one after the other.
struct Terms {
  const double* pivots[kMostWaiting];
  double factors[kMostWaiting];
  Count rows[kMostWaiting];
  Count count = 0;
};

template <Count kTerms>
void add(double* to, Count entries, const Terms& terms, Count first) {
  double* const __restrict column = aligned(to);
  const double* pivots[static_cast<std::size_t>(kTerms)];
  double factors[static_cast<std::size_t>(kTerms)];
  for (Count t = 0; t < kTerms; ++t) {
    pivots[t] = aligned(const_cast<double*>(terms.pivots[first + t]));
    factors[t] = terms.factors[first + t];
  }
  for (Count i = 0; i < entries; ++i) {
    double entry = column[i];
    for (Count t = 0; t < kTerms; ++t) entry += pivots[t][i] * factors[t];
    column[i] = entry;
  }
}

/// An entry of a column after all terms: in the row of an exchange the factor itself stands.
double entry_after(double entry, Count row, const Terms& terms) {
  for (Count t = 0; t < terms.count; ++t) {
    if (terms.rows[t] == row) {
      entry = terms.factors[t];
    } else {
      entry += terms.pivots[t][row] * terms.factors[t];
    }
  }
  return entry;
}

Terms terms_of(const Tableau& tableau, Count column) {
  Terms terms;
  for (Count e = tableau.known[column]; e < tableau.waiting; ++e) {
    const double factor = tableau.factors[e * tableau.columns + column];
    if (factor == 0) continue;  // the entry in its row is zero, and stays so
    terms.pivots[terms.count] = tableau.pivots + e * tableau.stride;
    terms.factors[terms.count] = factor;
    terms.rows[terms.count++] = tableau.rows[e];
  }
  return terms;
}

void bring_up_to_date(Tableau& tableau, Count column) {
  if (tableau.known[column] == tableau.waiting) return;
  const Terms terms = terms_of(tableau, column);
  tableau.known[column] = tableau.waiting;
  double* const entries = tableau.A + column * tableau.stride;
  double in_rows[kMostWaiting];
  for (Count t = 0; t < terms.count; ++t) in_rows[t] = entry_after(entries[terms.rows[t]], terms.rows[t], terms);
  Count t = 0;
  for (; t + 8 <= terms.count; t += 8) add<8>(entries, tableau.stride, terms, t);
  for (; t + 4 <= terms.count; t += 4) add<4>(entries, tableau.stride, terms, t);
  for (; t + 2 <= terms.count; t += 2) add<2>(entries, tableau.stride, terms, t);
  if (t < terms.count) add<1>(entries, tableau.stride, terms, t);
  for (t = 0; t < terms.count; ++t) entries[terms.rows[t]] = in_rows[t];
}

/// A row with all exchanges, as bring_up_to_date() has it.
void read_row(const Tableau& tableau, Count row, double* to) {
  for (Count k = 0; k < tableau.columns; ++k) to[k] = tableau.A[k * tableau.stride + row];
  for (Count e = 0; e < tableau.waiting; ++e) {
    const double* const factors = tableau.factors + e * tableau.columns;
    const double pivot = tableau.pivots[e * tableau.stride + row];
    const bool is_its_row = tableau.rows[e] == row;
    for (Count k = 0; k < tableau.columns; ++k) {
      const double after = is_its_row ? factors[k] : to[k] + pivot * factors[k];
      to[k] = tableau.known[k] > e ? to[k] : after;
    }
  }
}

void exchange(Tableau& tableau, Count row, Count column) {
  if (tableau.waiting == kMostWaiting) {
    for (Count k = 0; k < tableau.columns; ++k) bring_up_to_date(tableau, k);
    for (Count k = 0; k < tableau.columns; ++k) tableau.known[k] = 0;
    tableau.waiting = 0;
  }
  bring_up_to_date(tableau, column);
  double* const pivot = aligned(tableau.A + column * tableau.stride);
  double* const as_it_was = aligned(tableau.pivots + tableau.waiting * tableau.stride);
  double* const factors = tableau.factors + tableau.waiting * tableau.columns;
  const double inverse = 1 / pivot[row];
  read_row(tableau, row, factors);
  for (Count k = 0; k < tableau.columns; ++k) factors[k] *= -inverse;
  for (Count i = 0; i < tableau.stride; ++i) {
    as_it_was[i] = pivot[i];
    pivot[i] *= inverse;
  }
  pivot[row] = inverse;
  tableau.rows[tableau.waiting++] = row;
  tableau.known[column] = tableau.waiting;
}

}  // namespace

const Engine kEngine = {bring_up_to_date, exchange};

}  // namespace lcpbench::tableau::LCPBENCH_LEVEL
