#pragma once

#include <cstdint>
#include <set>
#include <string>

#include "study/store/sqlite.h"

// The table `totals` of a store says for each other table how many rows it has, and the sum of their checksums modulo
// 2^62, whatever their order. Rows that are missing, or there twice, are seen by it; a row that was changed is seen by
// its own checksum.

namespace lcpbench {

/// Counts all rows. A blank store begins so; no store with rows gets new totals.
void count_totals(sqlite::Database& database);

/// From now on each row that this connection adds, changes or deletes is counted in the transaction that does so, by
/// triggers that only this connection has. What other connections change is not counted.
void keep_totals(sqlite::Database& database);

/// The number of rows of a table, and the sum of their checksums.
struct Total {
  void add(std::int64_t checksum);
  bool operator==(const Total&) const = default;

  std::int64_t rows = 0;
  std::int64_t digest = 0;
};

/// @throws InputError that names file and table unless this is what was counted.
void check_total(sqlite::Database& database, const std::string& table, const Total& found);

/// @param left_out  tables that are not counted
/// @throws InputError that names the file and the first table whose rows are not those that were counted.
void check_totals(sqlite::Database& database, const std::set<std::string>& left_out = {});

}  // namespace lcpbench
