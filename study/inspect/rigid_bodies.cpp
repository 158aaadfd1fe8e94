#include "study/inspect/rigid_bodies.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace lcpbench {
namespace {

constexpr Index kBody = 6;

std::optional<BodyBlock> body_block(const Matrix& block) {
  const double mass = block(0, 0);
  const bool linear = block.topLeftCorner(3, 3) == Matrix(mass * Eigen::Matrix3d::Identity());
  if (!linear || !(mass > 0) || !block.topRightCorner(3, 3).isZero(0)) return std::nullopt;
  return BodyBlock{mass, block.bottomRightCorner(3, 3)};
}

std::vector<BodyBlock> bodies_of_blocks(const std::vector<Matrix>& blocks) {
  std::vector<BodyBlock> bodies;
  for (const Matrix& block : blocks) {
    const std::optional<BodyBlock> body = block.rows() == kBody ? body_block(block) : std::nullopt;
    if (!body) return {};
    bodies.push_back(*body);
  }
  return bodies;
}

std::vector<BodyBlock> bodies_of_matrix(const Matrix& G) {
  if (G.rows() == 0 || G.rows() % kBody != 0) return {};
  std::vector<Matrix> blocks;
  Matrix rest = G;
  for (Index at = 0; at < G.rows(); at += kBody) {
    blocks.emplace_back(G.block(at, at, kBody, kBody));
    rest.block(at, at, kBody, kBody).setZero();
  }
  return rest.isZero(0) ? bodies_of_blocks(blocks) : std::vector<BodyBlock>{};
}

Eigen::Vector3d principal_moments(const Eigen::Matrix3d& inertia) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(inertia, Eigen::EigenvaluesOnly).eigenvalues();
}

/// I1 + I2 >= I3 for ascending principal moments; thin bodies meet it with equality, to rounding.
bool is_mass_distribution(const Eigen::Vector3d& moments) {
  return moments(0) > 0 && moments(0) + moments(1) >= moments(2) * (1 - 1e-6);
}

}  // namespace

std::vector<BodyBlock> rigid_bodies(const Inertia& inertia) {
  if (const auto* blocks = std::get_if<BlockInertia>(&inertia)) return bodies_of_blocks(blocks->blocks);
  if (const auto* dense = std::get_if<DenseInertia>(&inertia)) return bodies_of_matrix(dense->G);
  if (const auto* inverse = std::get_if<InverseInertia>(&inertia)) return bodies_of_matrix(inverse->Ginv);
  return {};
}

bool has_free_bodies(const Problem& problem) {
  if (problem.scene() != nullptr) return true;
  if (problem.contact() == nullptr) return false;
  const Inertia& inertia = problem.contact()->inertia;
  const auto is_free = [](const Matrix& G) { return G.isDiagonal(0) || !bodies_of_matrix(G).empty(); };
  if (const auto* blocks = std::get_if<BlockInertia>(&inertia)) return std::ranges::all_of(blocks->blocks, is_free);
  const auto* dense = std::get_if<DenseInertia>(&inertia);
  return dense != nullptr ? is_free(dense->G) : !rigid_bodies(inertia).empty();
}

std::optional<bool> reads_as_inverse(const BodyBlock& body, double arm) {
  const Eigen::Vector3d moments = principal_moments(body.inertia);
  if (!(moments(0) > 0)) return std::nullopt;
  const bool possible = is_mass_distribution(moments);
  const bool inverse_possible = is_mass_distribution(moments.cwiseInverse().reverse());
  if (possible != inverse_possible) return inverse_possible;
  if (!(arm > 0)) return std::nullopt;
  const double gyration = std::sqrt(moments(2) / body.mass);
  const double gyration_of_inverse = std::sqrt(body.mass / moments(0));
  const double gyration_of_inverse_moments = 1 / std::sqrt(body.mass * moments(0));  // the mass as it stands
  const double arm_in_radii = arm / gyration;
  const auto plausible = [](double radii) { return radii >= 0.3 && radii <= 3; };
  const bool inverse_fits = plausible(arm / gyration_of_inverse) || plausible(arm / gyration_of_inverse_moments);
  if (inverse_fits && (arm_in_radii < 0.05 || arm_in_radii > 20)) return true;
  return plausible(arm_in_radii) ? std::optional<bool>(false) : std::nullopt;
}

bool lengths_look_too_large(const BodyBlock& body, double arm) {
  // [kg/m^3] mass over the cubed radius of gyration: 20 for a ball of air, 1e-4 for one of steel in kg and mm
  constexpr double kLightest = 1e-2;
  constexpr double kLongestArm = 10;  // [m]
  const double gyration = std::sqrt(principal_moments(body.inertia)(2) / body.mass);
  const bool one_unit = arm == 0 || (arm > 0.1 * gyration && arm < 10 * gyration);
  return (one_unit && body.mass < kLightest * gyration * gyration * gyration) ||
         (arm > kLongestArm && arm > 100 * gyration);
}

}  // namespace lcpbench
