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

/// The impulses that an answer's velocity v+ has if all hard contacts yield by the same compliance r, in the limit of r
/// = 0: w_N = N'v + b + r f_N, and r f_T for the net friction f_T = C f_D alike (see ContactProblem). They satisfy
/// every condition of contact at v+. Soft contacts keep their impulses: the velocity decides them.
///
/// With J_c the rows of a contact's normal and tangents, and y = (v+ - v) / r, the contact carries f_c(J_c y): the
/// normal impulse n is that of J_c y if it is above zero and the contact does not separate; the friction is the point
/// nearest to that of J_c y in the polygon of size mu n if the contact sticks, and if it slides in the corner or side
/// that dissipates the most. The size of the polygon does not push back on n: f is the projection on the pyramid, and
/// its sum of squares the least one, only where contacts stick and press with friction below its limit. With g the sum
/// of J_c'f_c of the answer, and D the diagonal of J'J,
///     s D y + sum J_c'f_c(J_c y) = g
/// is at s = 0 the equation for y. It is linear by pieces: Newton's method with a line search, from zero. If that
/// fails, s falls from 1 to zero, and each solution is the next one's start. [Qi, Sun 1993, A nonsmooth version of
/// Newton's method]
///
/// Each set of pieces that it passes costs one LU factorization of a matrix of the pairs of coordinates that contacts
/// couple. If v+ is not the limit of v, no y exists.
class EvenImpulses {
 public:
  /// @param problem with contacts; must outlive the next load
  void load(const Problem& problem);
  /// Another velocity before the impact. @pre load() was called
  void set_velocity(const Vector& v);

  /// Replaces the impulses of a solved answer; its velocity stays. An answer keeps its own impulses if the others do
  /// not pass AnswerTest, or if their residual is in a larger class: 1e-9, 1e-6 or 1e-4 relative to the scale.
  /// @param error see AnswerTest::allow() @returns why the answer keeps its own; "" if it does not
  const char* distribute(double error, double deadline_s, Answer& answer);

  /// Of the last distribute().
  std::int64_t factorizations() const { return factorizations_; }

 private:
  /// What a contact may carry with the normal impulse n: n alone, or with friction at a corner, on a side or anywhere
  /// in the polygon of size mu n. Or it carries nothing, or keeps its own.
  struct Section {
    enum class Form { kNothing, kNormal, kCorner, kSide, kPolygon, kKept };
    Form form = Form::kNothing;
    Index corner = 0;  ///< of a side the first
  };
  /// A y, the impulses that it gives, their slopes by J_c y, and the residual of the equation.
  struct Point {
    Vector y, residual;
    Eigen::Matrix3Xd impulse;
    std::vector<Eigen::Matrix3d> slope;
  };

  bool prepare();
  void find_sections(double still);
  Section section_of(std::size_t contact, double still) const;
  // Steps to y, in their order.
  void begin();
  void follow_path(double deadline_s);
  bool balance(double deadline_s);
  bool search();
  void find_residual(Point& point) const;
  Eigen::Vector3d carry(std::size_t contact, const Eigen::Vector3d& point, Eigen::Matrix3d& slope) const;
  double size_of(const Vector& residual) const;
  // The impulses at y.
  const char* settle(double tolerance, double deadline_s);
  void refine();

  const Problem* problem_ = nullptr;
  bool is_prepared_ = false;
  bool is_regular_ = false;
  Vector v_;
  ContactImpulses state_;
  AnswerTest test_;
  std::vector<ContactRows> rows_;
  ContactPolygons polygons_;
  NewtonMatrix matrix_;
  Vector masses_;    ///< the diagonal of G, ones where it is not given
  Vector diagonal_;  ///< D, not less than the rounding of levers that are zero
  double path_ = 0;  ///< s
  std::vector<Section> sections_;
  Vector own_;            ///< impulses of the answer, as in ContactImpulses
  Eigen::Matrix3Xd net_;  ///< the same along normals and tangents
  Vector sum_, whole_;    ///< g of impulses brought into their sections, and as they are
  Point now_, next_;
  Vector step_;
  std::vector<Eigen::Matrix3d> factored_;  ///< the slopes of the factors
  Answer candidate_;
  std::int64_t factorizations_ = 0;
};

}  // namespace lcpbench
