#pragma once

#include <span>
#include <string>
#include <string_view>

#include "core/io/json_document.h"
#include "core/problem.h"

namespace lcpbench {

/// The fields of a problem file's object, for documents that hold one.
std::span<const Field> problem_fields();

/// Puts a problem together from its object's parsed fields.
class ProblemParts {
 public:
  /// An item of the lists "bodies" and "contacts": see DocumentEvents.
  void add(std::string_view list, const std::string& path, const Record& item, const std::string& origin);
  /// The problem, once its object is complete. @throws InputError
  Problem finish(const Record& record, const std::string& origin);

 private:
  RigidScene scene_;
};

}  // namespace lcpbench
