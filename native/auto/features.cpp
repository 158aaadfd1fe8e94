#include "native/auto/features.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "native/auto/powers.h"
#include "native/contacts/contact_impulses.h"
#include "native/proofs/doubtful_inertia.h"

namespace lcpbench {
namespace {

constexpr double kLargestSlip = 1024;
constexpr double kLargestMu = 2;
constexpr double kLargestRatio = 0x1p30;

/// max|d'v| over the first half of the directions d of each contact, which the others oppose.
double fastest_slip(const ContactProblem& contact, const Vector& v) {
  double slip = 0;
  Index direction = 0;
  for (const int edges : contact.edges) {
    for (Index t = 0; t < edges / 2; ++t) slip = std::max(slip, std::abs(dot_column(contact.D, direction + t, v)));
    direction += edges;
  }
  return slip;
}

/// The largest entry of G's diagonal over the least; 1 where G is not given.
double ratio_of_masses(const ContactProblem& contact) {
  if (may_be_singular(contact)) return 1;
  double least = std::numeric_limits<double>::infinity(), largest = 0;
  for_each_matrix(contact.inertia, [&](const Matrix& G, Index) {
    for (const double mass : G.diagonal()) {
      if (mass > 0) least = std::min(least, mass);
      largest = std::max(largest, mass);
    }
  });
  return largest > 0 ? std::min(largest / least, kLargestRatio) : 1;
}

/// Two bodies and one have none.
bool has_separator(const ContactProblem& contact) {
  const auto* bodies = std::get_if<BlockInertia>(&contact.inertia);
  return bodies != nullptr && bodies->blocks.size() > 2;
}

}  // namespace

double fastest_approach(const ContactProblem& contact, const Vector& v) {
  double approach = 0;
  for (Index c = 0; c < contact.nc(); ++c) {
    approach = max_or_infinity(approach, -(dot_column(contact.N, c, v) + contact.offset(c)));
  }
  return approach;
}

void Features::begin(const ContactProblem& contact, Index idle) {
  contacts_ = static_cast<double>(std::max<Index>(contact.nc(), 1));
  coordinates_ = static_cast<double>(std::max<Index>(contact.ngc() - idle, 1));
  Index rows = contact.nc();
  largest_mu_ = 0;
  for (Index c = 0; c < contact.nc(); ++c) {
    largest_mu_ = std::max(largest_mu_, contact.mu(c));
    if (contact.mu(c) > 0 && contact.edges[static_cast<std::size_t>(c)] > 0) rows += 2;
  }
  redundancy_ = static_cast<double>(rows) / coordinates_;
  masses_ = -1;
  if (has_separator(contact)) graph_.reserve(contact);
  forget_slip();
}

double Features::slip_ratio(const ContactProblem& contact, const Vector& v) {
  if (has_slip_) return slip_ratio_;
  has_slip_ = true;
  slip_ratio_ = 0;
  if (!contact.frictional()) return 0;
  const double slip = fastest_slip(contact, v);
  return slip_ratio_ = slip > 0 ? slip / (largest_mu_ * fastest_approach(contact, v)) : 0;
}

const std::array<double, kFeatures>& Features::measure(const ContactProblem& contact, const Vector& v, double digits) {
  if (is_measured_) return values_;
  is_measured_ = true;
  if (masses_ < 0) {
    const double separator = has_separator(contact) ? graph_.separator_size(contact) : coordinates_;
    separator_ = log2_of(std::max(separator, 1.0));
    masses_ = log2_of(ratio_of_masses(contact));
  }
  const double slip = slip_ratio(contact, v);
  of(Feature::kOne) = 1;
  of(Feature::kContacts) = log2_of(contacts_);
  of(Feature::kCoordinates) = log2_of(coordinates_);
  of(Feature::kEdges) = log2_of(std::max(static_cast<double>(lcp_size(contact)) / contacts_, 1.0));
  of(Feature::kSeparator) = separator_;
  of(Feature::kRedundancy) = log2_of(std::max(redundancy_, 0x1p-30));
  of(Feature::kSlip) = log2_of(1 + (slip < kLargestSlip ? slip : kLargestSlip));
  of(Feature::kFriction) = std::min(largest_mu_, kLargestMu);
  of(Feature::kMasses) = masses_;
  of(Feature::kDigits) = digits;
  return values_;
}

}  // namespace lcpbench
