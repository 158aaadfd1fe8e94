#include "native/auto/prediction.h"

#include <algorithm>

#include "native/active_set/active_set.h"
#include "native/auto/methods.h"
#include "native/auto/powers.h"
#include "native/contact_lemke/contact_lemke.h"

namespace lcpbench {
namespace {

constexpr double kLargestLog = 60;

/// Of dense methods, of velocity_ipm, of contact_ipm, and of others that converge, whose work is less certain.
constexpr double kShapeOfDense = 1.1, kShapeOfInteriorPoint = 2, kShapeOfNewton = 3, kShapeOfConverging = 0.7;

/// Of contact_ipm, over its prediction: where another method is about as fast, that one ends at rest or to rounding.
constexpr double kCaution = 2;

/// A dense matrix of so many numbers (1.8 MB) is in no fast cache: a multiplication takes twice as long.
constexpr double kCachedNumbers = 230'000;

/// What a multiplication of a dense method takes, over that of a small problem.
double slowness(const Problem& problem, Index idle) {
  const auto order = static_cast<double>(problem.contact()->ngc() - idle);
  return 1 + order * order / kCachedNumbers;
}

/// Where a stack has as many contacts as coordinates, from this log of their number on, active_set takes many more
/// steps than the problems of the fit: up to so many times their work.
constexpr double kManyCoordinates = 7, kDegenerate = 8;

/// 2 to the power of the row's sum.
template <std::size_t kCount>
double power_of_sum(const std::array<double, kCount>& row, const std::array<double, kFeatures>& features) {
  double sum = 0;
  for (std::size_t k = 0; k < kCount; ++k) sum += row[k] * features[k];
  return power_of_two(std::clamp(sum, 0.0, kLargestLog));
}

}  // namespace

Entrant predict_load(AutoMethod method, const Problem& problem, Index idle) {
  const double weight = slowness(problem, idle) * prediction::row_of(method, problem.contact()->frictional()).weight;
  const bool is_active_set = method == AutoMethod::kActiveSet;
  const double work = is_active_set ? ActiveSet::load_work(problem, idle) : ContactLemke::load_work(problem, idle);
  const double test = is_active_set ? 0 : ContactLemke::test_work(problem, idle);
  return {.shape = kShapeOfDense, .load_cost = weight * work, .least_cost = weight * (work + test), .weight = weight};
}

Entrant predict(AutoMethod method, const Problem& problem, Index idle, const std::array<double, kFeatures>& features) {
  const prediction::Row& row = prediction::row_of(method, problem.contact()->frictional());
  const bool is_newton = method == AutoMethod::kVelocityIpm || method == AutoMethod::kContactIpm;
  const double shape_of_newton = method == AutoMethod::kVelocityIpm ? kShapeOfInteriorPoint : kShapeOfNewton;
  Entrant entrant{.shape = is_newton ? shape_of_newton : kShapeOfConverging,
                  .load_cost = power_of_sum(row.load, features),
                  .weight = row.weight,
                  .converges = true,
                  .falls_late = is_newton,
                  .learns = method == AutoMethod::kPsor,
                  .is_reserve = method == AutoMethod::kOverRelaxedPsor};
  if (Methods::is_dense(method)) entrant = predict_load(method, problem, idle);
  // Without friction it solves what the others give up.
  entrant.is_reserve = entrant.is_reserve || (method == AutoMethod::kContactLemke && !problem.contact()->frictional());
  const double solve = power_of_sum(row.solve, features);
  const bool is_degenerate = method == AutoMethod::kActiveSet &&
                             features[static_cast<std::size_t>(Feature::kRedundancy)] >= 0 &&
                             features[static_cast<std::size_t>(Feature::kCoordinates)] >= kManyCoordinates;
  entrant.cost = entrant.load_cost + (is_degenerate ? kDegenerate : 1) * entrant.weight / row.weight * solve;
  if (method == AutoMethod::kContactIpm) entrant.cost *= kCaution;
  return entrant;
}

}  // namespace lcpbench
