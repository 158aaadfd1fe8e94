#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/problem.h"
#include "core/settings.h"
#include "core/spec.h"
#include "core/warm_start.h"

namespace lcpbench {

/// A problem as a step of a simulation.
struct TimeStep {
  Problem problem;
  std::vector<ContactId> contact_ids;  ///< what each contact is called, also in the step before; empty: not known
  std::vector<std::string> notes;      ///< how it differs from the step of the engine, each as "what: how many"
};

/// A family of problems, each a function of (set with its options, seed, trial) alone: the same bits on every machine,
/// compiler, thread and order of calls.
class ProblemSet {
 public:
  virtual ~ProblemSet() = default;
  /// Canonical name: options in declaration order, defaults left out.
  virtual std::string name() const = 0;
  /// Trial >= 0 of the stream `seed`. Thread-safe. @throws InputError when trial >= count().
  virtual Problem generate(std::uint64_t seed, std::int64_t trial) const = 0;
  /// The same with what a captured step says of it. Thread-safe.
  virtual TimeStep step(std::uint64_t seed, std::int64_t trial) const { return {generate(seed, trial), {}, {}}; }
  /// Whether trial `trial` is the time step after that of trial - 1.
  virtual bool follows(std::int64_t /*trial*/) const { return false; }
  /// How many problems there are, where that is finite (files); nullopt for random sets.
  virtual std::optional<std::int64_t> count() const { return std::nullopt; }
  /// Name and version of the engine that captured all its problems; "" where there is none, or it is not known.
  virtual std::string engine() const { return {}; }
  /// What is wrong with its files although they can be read, in a sentence; "" as a rule.
  virtual std::string note() const { return {}; }
};

struct SetInfo {
  std::string name;
  std::string size;     ///< "n 2..20", in words
  std::string source;   ///< citation
  std::string summary;  ///< one line
  std::vector<SettingInfo> options;
};

/// Every named set, in a fixed order.
std::vector<SetInfo> list_sets();

/// Opens a set by name and options, or "file:PATH" (a problem file, a folder of them in name order, or a scenes file:
/// its captured steps in order).
/// @throws InputError for unknown names and bad options.
std::unique_ptr<ProblemSet> open_set(const std::string& text);

/// Whether all of `text` matches a glob: '*' stands for any run of characters, '/' and braces included, '?' for any
/// one, everything else for itself. O(length of pattern times length of text).
bool glob_matches(std::string_view pattern, std::string_view text);

/// The canonical names of all sets that match: a name with options, or a glob over names. Options may follow a glob
/// ("paper/*/exp2{redundancy=combination}") and are given to every match.
/// @throws InputError when nothing matches.
std::vector<std::string> expand_sets(const std::string& pattern);

}  // namespace lcpbench
