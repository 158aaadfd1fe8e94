#pragma once

#include <string>

#include "core/io/json_document.h"
#include "core/problem.h"

namespace lcpbench {

/// The problem of a parsed problem file, or of a document that holds one. @throws InputError
Problem problem_of_json(const Json& json, const std::string& origin);

}  // namespace lcpbench
