#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace lcpbench::report {

/// A CSV table (RFC 4180, LF) of JSON records, one row each. Nested members become columns "outer.inner"; numbers are
/// written as in the JSON, so both read back to the same doubles; null is empty.
/// @param example  a record with the members that all have: its names are the header, which stands also over no rows;
/// what a record lacks is empty
std::string csv_table(const nlohmann::ordered_json& example, const nlohmann::ordered_json& records);

}  // namespace lcpbench::report
