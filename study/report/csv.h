#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace lcpbench::report {

/// A CSV table (RFC 4180, LF) of JSON records, one row each. Nested members become columns "outer.inner"; columns are
/// those of the first record. Numbers are written as in the JSON, so both read back to the same doubles; null is empty.
std::string csv_table(const nlohmann::ordered_json& records);

}  // namespace lcpbench::report
