#include "native/auto/order.h"

#include <algorithm>
#include <cmath>

#include "native/auto/methods.h"

namespace lcpbench {
namespace {

/// First turn of a method: work = factor n^(quarters / 4), n the geometric mean of the numbers of contacts and of
/// coordinates that contacts move. Measured on 978 islands with friction and 228 without: that much is enough on nine
/// of ten that the method solves, but for friction_ipm and psor without friction (five of ten) and psor with it (four).
/// What these do not solve soon takes them long. results/auto/lines.py counts.
struct Line {
  AutoMethod method;
  double factor;
  int quarters;
  double price = 1;  ///< see Turn
};

constexpr Line kContactLemke{AutoMethod::kContactLemke, 0x1p12, 9};
constexpr Line kLateLemke{AutoMethod::kContactLemke, 0x1p9, 9};  // enough on six of ten
constexpr Line kContactIpm{AutoMethod::kContactIpm, 0x1.6p14, 7};
constexpr Line kFrictionIpm{AutoMethod::kFrictionIpm, 0x1p13, 7, 2};
constexpr Line kPsor{AutoMethod::kPsor, 0x1p10, 7, 4};

constexpr Line kActiveSet{AutoMethod::kActiveSet, 0x1p7, 9};
constexpr Line kVelocityIpm{AutoMethod::kVelocityIpm, 0x1p14, 5, 3};
constexpr Line kFrictionlessPsor{AutoMethod::kPsor, 0x1p9, 7, 4};
constexpr Line kFrictionlessLemke{AutoMethod::kContactLemke, 0x1.4p8, 9};

using Lines = std::array<Line, Order::kMaxTurns>;

/// Pivoting is the fastest while either number is small. Sweeps soon come to a loose error, and to any where contacts
/// do not oppose each other.
constexpr Lines kSmall{kContactLemke, kContactIpm, kFrictionIpm, kPsor},
    kSmallAndLoose{kContactLemke, kPsor, kContactIpm, kFrictionIpm},
    kMediumAndLoose{kPsor, kContactLemke, kContactIpm, kFrictionIpm},
    kLarge{kContactIpm, kLateLemke, kFrictionIpm, kPsor},
    kSweepsFirst{kPsor, kContactIpm, kLateLemke, kFrictionIpm};
constexpr Lines kFrictionless{kActiveSet, kVelocityIpm, kFrictionlessPsor, kFrictionlessLemke},
    kLargeFrictionless{kVelocityIpm, kActiveSet, kFrictionlessPsor, kFrictionlessLemke},
    kLargeFrictionlessAndLoose{kFrictionlessPsor, kVelocityIpm, kActiveSet, kFrictionlessLemke};

constexpr double kLooseError = 1e-3;
/// See redundancy(): from this on contacts oppose each other, and sweeps take long.
constexpr double kOpposed = 1.25;
/// Of the smaller one of both numbers: up to so many contact_lemke is first. A robot has a dense block of inertia,
/// whose cube each step of an interior point takes.
constexpr double kMaxForPivots = 60, kMaxForPivotsIfLoose = 30, kMaxForPivotsIfUnopposed = 20,
                 kMaxForPivotsOfARobot = 200;
/// Of n.
constexpr double kMaxForActiveSet = 150;

Index largest_block(const Inertia& inertia) {
  Index largest = 0;
  for_each_matrix(inertia, [&](const Matrix& G, Index) { largest = std::max(largest, G.rows()); });
  return largest;
}

const Lines& lines_of(const ContactProblem& contact, bool is_robot, bool is_opposed, double fewer, double n,
                      double error) {
  const bool is_loose = error >= kLooseError;
  if (!contact.frictional()) {
    if (n <= kMaxForActiveSet) return kFrictionless;
    return is_loose ? kLargeFrictionlessAndLoose : kLargeFrictionless;
  }
  if (is_robot && fewer <= kMaxForPivotsOfARobot) return kSmall;
  if (fewer > kMaxForPivots) return is_loose ? kSweepsFirst : kLarge;
  if (fewer > kMaxForPivotsIfUnopposed && !is_opposed) return kSweepsFirst;
  if (!is_loose) return kSmall;
  return fewer > kMaxForPivotsIfLoose ? kMediumAndLoose : kSmallAndLoose;
}

/// Of roots and products alone, which every machine rounds alike.
double power_in_quarters(double n, int quarters) {
  const double root = std::sqrt(std::sqrt(n));
  double power = 1;
  for (int k = 0; k < quarters; ++k) power *= root;
  return power;
}

}  // namespace

double redundancy(const ContactProblem& contact, Index idle) {
  Index rows = contact.nc();
  for (Index c = 0; c < contact.nc(); ++c) {
    if (contact.mu(c) > 0 && contact.edges[static_cast<std::size_t>(c)] > 0) rows += 2;
  }
  return static_cast<double>(rows) / static_cast<double>(std::max<Index>(contact.ngc() - idle, 1));
}

void Order::choose(const Problem& problem, Index idle, double error) {
  const ContactProblem& contact = *problem.contact();
  const auto contacts = static_cast<double>(std::max<Index>(contact.nc(), 1));
  // Pivoting takes soft contacts by their rigid equivalent, which has a coordinate more for each row that yields.
  const Index yielding = contact.is_soft() ? (contact.frictional() ? 3 : 1) * contact.nc() : 0;
  const auto coordinates = static_cast<double>(std::max<Index>(contact.ngc() - idle + yielding, 1));
  const double n = std::sqrt(contacts * coordinates);
  const Index block = largest_block(contact.inertia);
  const bool is_robot = 2 * block > contact.ngc(), is_opposed = redundancy(contact, idle) >= kOpposed;
  unknowns_ = static_cast<double>(problem.size());
  block_ = static_cast<double>(block);
  count_ = 0;
  for (const Line& line : lines_of(contact, is_robot, is_opposed, std::min(contacts, coordinates), n, error)) {
    if (!Methods::takes(line.method, problem)) continue;
    turns_[count_++] = {line.method, std::max(line.factor * power_in_quarters(n, line.quarters), kLeastWork),
                        line.price};
  }
}

void Order::put_first(AutoMethod method) {
  const auto end = turns_.begin() + static_cast<std::ptrdiff_t>(count_);
  const auto found = std::ranges::find(turns_.begin(), end, method, &Turn::method);
  if (found != end) std::rotate(turns_.begin(), found, found + 1);
}

void Order::put_rest_first() {
  put_first(AutoMethod::kFrictionIpm);
  Turn& first = turns_.front();
  if (first.method != AutoMethod::kFrictionIpm) return;
  first.work = std::min(first.work, kWorkOfNineOverHalf * likely_work_of_rest() / first.price);
}

bool Order::has(AutoMethod method) const {
  return std::ranges::any_of(turns(), [method](const Turn& turn) { return turn.method == method; });
}

}  // namespace lcpbench
