#pragma once

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

/// @throws InputError that names the file and the first table whose rows are not those that were counted.
void check_totals(sqlite::Database& database);

}  // namespace lcpbench
