#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "study/paper/grids.h"

namespace lcpbench::paper {

/// What one comparison says of its claim, at a family-wise error of 5 % within the claim.
enum class Stance {
  kSupports,
  kOpposes,
  kUndecided,
  kShown  ///< no test: a number without an interval, shown as evidence beside those that are tested
};
const char* name_of(Stance stance);

/// One quantity against one bound, or against two that it should lie between.
struct Comparison {
  std::string what;   ///< the quantity in words, with set and solvers
  std::string scope;  ///< reading and measure
  double value = 0;
  double bound = 0;
  bool above = true;                         ///< the claim says that the quantity is above the bound
  std::optional<double> within;              ///< the claim says that it lies above the bound and below this one
  bool share = true;                         ///< a share or a difference of shares, shown in points; else a ratio
  std::function<Interval(double)> interval;  ///< at a normal quantile; none for a number that is no estimate
  std::optional<double> p_value;             ///< of an exact test, which has to agree for a stance
  std::string detail;                        ///< counts, tests
  Stance stance = Stance::kUndecided;
};

/// The result of a claim's test, found from its comparisons.
enum class Word {
  kConfirmed,     ///< some comparisons support it, none opposes; of a claim on every set: all support it
  kInPart,        ///< some support it, some oppose; of a claim on every set: at least half support it, none opposes
  kContradicted,  ///< some oppose it, none supports
  kExplained,     ///< confirmed as the paper measured, and all comparisons that name the cause support the cause
  kUndecided,     ///< no comparison is decided at this number of trials
  kNotTested,     ///< the store does not hold the data
};
const char* name_of(Word word);

struct Claim {
  std::string id;
  std::string statement;
  std::string rule;           ///< how the word is found
  std::string cause;          ///< what `explained` says; "" for claims without a tested explanation
  std::string needs;          ///< what a store must hold
  bool on_every_set = false;  ///< the claim speaks of every set: one that is undecided leaves it unconfirmed
  std::vector<Comparison> comparisons;
  std::vector<Comparison> explanation;
  std::vector<Comparison> beyond;  ///< beside the claim: other solvers; no part in the word
  Word word = Word::kNotTested;
};

/// Drops comparisons without a number (a solver that met no odd trial has no held-out share), then decides all stances
/// and the word. Within each list, m comparisons that have an interval are made at the normal quantile of 5 %/m, and at
/// exact p-values of 5 %/m (Bonferroni), so that a stance is due to chance in at most 5 % of studies.
void judge(Claim& claim);

/// The claims with their comparisons, not judged yet.
std::vector<Claim> paper_claims(const Summary& summary, const std::vector<Grid>& grids);

/// Every claim of the paper, and what this project adds to them, tested on the summary's data. Claims are about
/// methods: grids by the rules of 2012, which repeat them for the tables, take no part. Grids with refusals take no
/// part either, nor do those that met less than half as many problems as the largest sweep of their set: beside it they
/// decide nothing, and their comparisons would cost the others power.
std::vector<Claim> test_claims(const Summary& summary, const std::vector<Grid>& grids);

/// One record per comparison, for claims-paper.csv; a claim without any has one that says what is needed.
nlohmann::ordered_json claims_json(const std::vector<Claim>& claims);

}  // namespace lcpbench::paper
