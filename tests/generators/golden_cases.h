#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "core/spec.h"
#include "generators/hard/hard.h"
#include "generators/made/made.h"
#include "generators/paper/paper.h"
#include "generators/planted.h"
#include "generators/rest/rest.h"
#include "generators/rigid/rigid.h"

// What the golden hashes are taken of, and how: shared by the program that is built with several compilers and by the
// test of the library.

namespace lcpbench::golden {

constexpr std::uint64_t kSeed = 1;
constexpr std::uint64_t kTrials = 200;

/// FNV-1a, 64 bits, over the little-endian bytes of 64-bit words.
class Hash {
 public:
  void add(std::uint64_t word) {
    for (int byte = 0; byte < 8; ++byte) {
      value_ ^= (word >> (8 * byte)) & 0xff;
      value_ *= 0x100000001b3U;
    }
  }
  void add(double number) { add(std::bit_cast<std::uint64_t>(number)); }
  void add_size(std::size_t size) { add(static_cast<std::uint64_t>(size)); }
  std::string text() const {
    char digits[17];
    std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(value_));
    return digits;
  }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325U;
};

/// One set under one option that is off its default, or under none.
template <class Set>
struct Case {
  const Set* set = nullptr;
  Options options;

  std::string name() const { return Spec{set->name, set->changed(set->name, options)}.text(); }
};

inline std::vector<std::string> split_choices(const std::string& range) {
  std::vector<std::string> choices;
  std::size_t begin = 0;
  for (std::size_t end = range.find('|'); end != std::string::npos; end = range.find('|', begin)) {
    choices.push_back(range.substr(begin, end - begin));
    begin = end + 1;
  }
  choices.push_back(range.substr(begin));
  return choices;
}

/// The values of an option to try: every other choice; one larger number; half a real one, 4096 instead of 0, or 1/2 if
/// it is at most 1.
inline std::vector<std::string> other_values(const SettingInfo& option) {
  if (option.type == "integer") return {std::to_string(std::stoll(option.default_value) + 3)};
  if (option.type == "real") {
    const double usual = std::stod(option.default_value);
    const bool is_share = option.range.ends_with(", 1]");
    return {format_real(usual != 0 ? usual / 2 : is_share ? 0.5 : 4096)};
  }
  std::vector<std::string> values;
  for (const std::string& choice : split_choices(option.range)) {
    if (choice != option.default_value) values.push_back(choice);
  }
  return values;
}

/// Whether a set has the condition number that the sets of its kind are compared at, or none.
template <class Set>
bool one_of_its_kind(const Set& set) {
  if constexpr (requires { set.condition; }) return set.condition == 0 || set.condition == 1e8;
  return true;
}

/// Every set as it is; every set with each other redundancy; and one set of each kind of experiment with
/// every other option too. The large set is left at its defaults: it takes longer than all others together.
template <class Set>
std::vector<Case<Set>> cases(const std::vector<Set>& sets) {
  std::vector<Case<Set>> all;
  for (const Set& set : sets) {
    all.push_back({&set, {}});
    const bool large = set.name.find("extra100") != std::string::npos;
    const bool repeats_another = set.name.find("/exp6-") != std::string::npos;
    const bool every_option = !repeats_another && one_of_its_kind(set);
    for (const SettingInfo& option : set.options()) {
      if (large || !(every_option || option.name == "redundancy")) continue;
      for (const std::string& value : other_values(option)) all.push_back({&set, {{option.name, value}}});
    }
  }
  return all;
}

/// Made sets have few and small trials here, for they have up to 20,000 contacts by default.
constexpr std::uint64_t kMadeTrials = 5;

inline std::vector<Case<MadeSet>> made_cases() {
  std::vector<Case<MadeSet>> all;
  for (const MadeSet& set : made_sets()) all.push_back({&set, {{"nc_max", "150"}}});
  return all;
}

constexpr std::uint64_t kRestTrials = 40;

inline std::vector<Case<RestSet>> rest_cases() {
  std::vector<Case<RestSet>> all;
  for (const RestSet& set : rest_sets()) {
    all.push_back({&set, {}});
    all.push_back({&set, {{"margin", "0.5"}}});
  }
  return all;
}

}  // namespace lcpbench::golden
