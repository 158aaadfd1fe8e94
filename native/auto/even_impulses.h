#pragma once

#include <cstdint>
#include <vector>

#include "core/problem.h"
#include "core/solver.h"
#include "native/answer_test/answer_test.h"
#include "native/contacts/contact_impulses.h"
#include "native/proximal_newton/contact_rows.h"
#include "native/proximal_newton/newton_matrix.h"

namespace lcpbench {

/// Of all impulses that give an answer's velocity and satisfy every condition of contact there, those of the least sum
/// of f_N^2 + |f_T|^2, f_T = C f_D the net friction. Soft contacts keep their impulses: the velocity decides them.
///
/// At a given velocity the impulse of a contact is in a cone: zero if it separates, the pyramid if it sticks, and if it
/// slides the face of the pyramid that dissipates the most. With J_c the rows of a contact's normal and tangents, P_c
/// the projection on its cone, and g the sum of J_c'f_c of the answer, f_c = P_c(J_c y) for the y that maximises
/// g'y - 1/2 sum |P_c(J_c y)|^2, the dual problem. It is concave, and quadratic by pieces: Newton's method with a
/// search along each step. [Qi, Sun 1993, A nonsmooth version of Newton's method]
///
/// Each set of faces that it passes costs one LU factorization of a matrix of the pairs of coordinates that contacts
/// couple.
class EvenImpulses {
 public:
  /// @param problem with contacts; must outlive the next load
  void load(const Problem& problem);
  /// Another velocity before the impact. @pre load() was called
  void set_velocity(const Vector& v);

  /// Replaces the impulses of a solved answer; its velocity stays. An answer keeps its own impulses if the others do
  /// not pass AnswerTest, or if their residual is in a larger class: 1e-9, 1e-6 or 1e-4 relative to max|q|.
  /// @param allowed see AnswerTest::allow() @returns why the answer keeps its own; "" if it does not
  const char* distribute(double allowed, double deadline_s, Answer& answer);

  /// Of the last distribute().
  std::int64_t factorizations() const { return factorizations_; }

 private:
  /// What a contact may carry: all that is between no, one or two rays (1, mu d), or the pyramid. Or it keeps its own.
  struct Cone {
    enum class Form { kRays, kPyramid, kKept };
    Form form = Form::kRays;
    int rays = 0;
    Eigen::Vector3d first = Eigen::Vector3d::Zero(), second = Eigen::Vector3d::Zero();
  };
  /// A y, the impulses P_c(J_c y), their slopes by J_c y, and what is left of g.
  struct Point {
    Vector y, left;
    Eigen::Matrix3Xd impulse;
    std::vector<Eigen::Matrix3d> slope;
  };

  bool prepare();
  Cone cone_of(std::size_t contact, double still) const;
  Eigen::Vector3d ray(std::size_t contact, Index direction) const;
  Eigen::Vector3d project(std::size_t contact, const Eigen::Vector3d& point, Eigen::Matrix3d& slope) const;
  Eigen::Vector3d pull(std::size_t contact, const Vector& y) const;
  void subtract(std::size_t contact, const Eigen::Vector3d& impulse, Vector& from) const;
  double size_of(const Vector& left) const;
  void find_cones(double still);
  bool maximise(double deadline_s);
  bool search();
  void refine();
  void take_impulses();

  const Problem* problem_ = nullptr;
  bool is_prepared_ = false;
  bool is_regular_ = false;
  Vector v_;
  ContactImpulses state_;
  AnswerTest test_;
  std::vector<ContactRows> rows_;
  ContactPolygons polygons_;
  NewtonMatrix matrix_;
  Vector masses_;  ///< the diagonal of G, ones where it is not given
  std::vector<Cone> cones_;
  Vector own_;            ///< impulses of the answer, as in ContactImpulses
  Eigen::Matrix3Xd net_;  ///< the same along normals and tangents
  Vector sum_, whole_;    ///< g of impulses brought into their cones, and as they are
  Point now_, next_;
  Vector step_;
  std::vector<Eigen::Matrix3d> factored_;  ///< the slopes of the factors
  Answer candidate_;
  std::int64_t factorizations_ = 0;
};

}  // namespace lcpbench
