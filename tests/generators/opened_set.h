#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "core/spec.h"

// A generator's set with its options read, as the tests of the generators draw from it.

namespace lcpbench::testing {

constexpr std::uint64_t kDrawSeed = 20120101;

/// @param draw  (set, reading, seed, trial) -> sample
template <class Set, auto draw_sample>
struct OpenedSet {
  const Set* set = nullptr;
  decltype(set->parse("", {})) reading;

  auto draw(std::uint64_t trial, std::uint64_t seed = kDrawSeed) const {
    return draw_sample(*set, reading, seed, trial);
  }
};

/// @param text  the set's name, with options in braces. @throws std::logic_error when there is no such set.
template <auto draw_sample, class Set>
OpenedSet<Set, draw_sample> opened_set(const std::vector<Set>& sets, const std::string& text) {
  const Spec spec = parse_spec(text);
  for (const Set& set : sets) {
    if (set.name == spec.name) return {&set, set.parse(set.name, spec.options)};
  }
  throw std::logic_error("no set " + text);
}

/// Draws trials in a row, in two threads, and each alone in the other order.
/// @param same  whether two samples are equal, bit for bit
template <class Opened, class Same>
void expect_order_and_threads_do_not_matter(const Opened& opened, Same same) {
  constexpr std::uint64_t kTrials = 60;
  std::vector<decltype(opened.draw(0))> batch;
  for (std::uint64_t trial = 0; trial < kTrials; ++trial) batch.push_back(opened.draw(trial));
  std::vector<decltype(opened.draw(0))> threaded(kTrials);
  const auto work = [&](std::uint64_t first) {
    for (std::uint64_t trial = first; trial < kTrials; trial += 2) threaded[trial] = opened.draw(trial);
  };
  std::thread other(work, 1);
  work(0);
  other.join();
  for (std::uint64_t trial = kTrials; trial-- > 0;) {
    ASSERT_TRUE(same(batch[trial], threaded[trial])) << trial;
    ASSERT_TRUE(same(batch[trial], opened.draw(trial))) << trial;
  }
  EXPECT_FALSE(same(batch[0], batch[1]));
}

}  // namespace lcpbench::testing
