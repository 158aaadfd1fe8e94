#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "core/problem.h"
#include "core/solver.h"
#include "native/answer_test/answer_test.h"
#include "native/velocity_ipm/sparse_factorization.h"

namespace lcpbench {

/// The guess that contacts which pressed in the last step press again and none of them slips: what holds in a scene
/// that rests.
///
/// With the columns a of these contacts the velocity is then the projection of v onto {u : a'u + b = 0}, in the metric
/// of the inertia. The impulses are those of the last step and the least change of them that gives this velocity, each
/// contact's measured against its own load: Newton's steps on (A'G*A) f = -(A'v + b) through the Cholesky factors of
/// G + A W A', whose weights W stand in for the inverse of the singular A'G*A. A contact that would have to pull is
/// let go, one that approaches is held, and the guess tried again, a few times. The answer is tested as those of
/// friction_ipm are.
///
/// An answer is handed out only if its velocity is that of least energy: what is not held leaves the pyramids'
/// (N + mu d)'u + b >= 0. So a step that can rest is brought to rest.
///
/// Needs the inertia as blocks or as one matrix G. Keeps the order of elimination and all memory where the next problem
/// has the same graph of bodies and contacts.
class HeldContacts {
 public:
  HeldContacts();

  /// Whether it can be loaded: G itself is given.
  static bool takes(const ContactProblem& contact);

  /// Whether some contact pressed in the last answer, brought to these contacts, and none slipped. O(n)
  static bool held(const ContactProblem& contact, const Vector& v, const Vector& start);

  /// O(nonzeros of N and D), and of another graph than the last its order of elimination.
  /// @param problem must outlive the next load @pre takes()
  void load(const Problem& problem, const Vector& v);
  void set_velocity(const Vector& v);

  /// At most kTries factorizations of the sparse G + A W A', and one test of the answer. Allocates nothing.
  /// @param start the last answer brought to these contacts (n) @param work counts the factorizations
  /// @returns whether the guess was right: answer is then kSolved, with its velocity
  bool solve(const Vector& start, double deadline_s, Answer& answer, Counters& work);

 private:
  /// A body that a contact touches.
  struct Part {
    int body = 0;
    int row = 0;    ///< of its first coordinate in the contact's columns
    int first = 0;  ///< that coordinate in the problem
    int size = 0;
    int place = 0;  ///< that coordinate in the order of elimination
  };
  /// A contact's columns [N_c, first half of D_c], on the coordinates of the bodies that it touches.
  struct Columns {
    std::size_t parts = 0, end_parts = 0;  ///< in parts_
    std::size_t entries = 0;               ///< in entries_, rows x columns
    std::size_t first = 0;                 ///< of its impulses in impulses_
    int rows = 0;
    int columns = 0;
  };
  /// Blocks of the inertia that follow each other and are touched by the same contacts.
  struct Body {
    int size = 0;
    int first = 0;           ///< coordinate in the problem
    std::size_t block = 0;   ///< of the inertia, its first
    std::size_t factor = 0;  ///< of its part of G, in inertia_factors_

    bool operator==(const Body&) const = default;
  };
  /// A body in the order of elimination.
  struct Place {
    int first = 0;                         ///< its first coordinate
    int rank = 0;                          ///< its number
    std::size_t below = 0, end_below = 0;  ///< bodies coupled with it and eliminated later, in below_
  };
  struct Below {
    int body = 0;
    int skip = 0;  ///< rows of a column of the first body's that stand between its own and those of this one
  };

  bool has_last_sizes() const;
  void find_graph();
  void find_bodies();
  void find_columns();
  void analyze();
  void place_bodies(const SparseMatrix& graph);
  void lay_out_matrix();
  int skip(int body, int below) const;
  void find_coupled();
  bool fill_columns();
  bool fill_column(const Jacobian& J, Index number, const Columns& contact, double* column) const;
  void factor_inertia();
  void take_room();
  void measure_scale();
  void take_start(const Vector& start);
  void weigh();
  bool factor();
  bool are_alike(const Columns& a, const Columns& b) const;
  void add_to_matrix(std::size_t first, std::size_t end);
  void respond();
  double miss();
  double improve();
  void approach();
  bool is_confirmed();
  double clearance(std::size_t contact);
  bool change_guess();
  void write(Answer& answer) const;

  void multiply(const Columns& contact, const Vector& x, double* products) const;
  void add_columns(const Columns& contact, const double* factors, Vector& to) const;
  void add_response(Vector& impulse, Vector& to) const;
  double offset(std::size_t contact) const { return contact_->offset(static_cast<Index>(contact)); }

  const Problem* problem_ = nullptr;
  const ContactProblem* contact_ = nullptr;
  AnswerTest test_;
  bool has_test_ = false;  ///< test_ holds the problem
  std::unique_ptr<SparseFactorization> factors_;

  // The graph:
  std::vector<Index> block_sizes_;
  std::vector<int> body_of_;  ///< of each coordinate
  std::vector<Body> bodies_, last_bodies_;
  std::vector<Columns> contacts_;
  std::vector<Part> parts_;
  std::vector<std::pair<int, int>> coupled_, last_coupled_;

  // What follows from bodies and couplings alone:
  std::vector<Place> places_;  ///< of each body
  std::vector<Below> below_;
  SparseMatrix matrix_;  ///< lower triangle of G + A W A', in the order of elimination

  std::vector<double> entries_, inertia_factors_;
  std::vector<double> strength_;           ///< by contact: what is put for 1 / (a'G*a) of its normal
  Vector given_v_;                         ///< in the order of the problem
  Vector v_, u_, step_, impulse_;          ///< in the order of elimination
  std::vector<char> held_;                 ///< by contact
  std::vector<double> load_;               ///< by contact: the weight of its columns
  std::vector<double> impulses_, misses_;  ///< by column: f, and A'u + b
  std::vector<double> scaled_;             ///< one contact's columns
  std::vector<double> product_;            ///< of two bodies, a block of the matrix
  std::vector<std::uint64_t> signatures_;  ///< by block: of the contacts that touch it
  std::vector<Index> last_touched_;        ///< by block
  bool is_definite_ = false;               ///< G
  double scale_ = 0;                       ///< max|q|
};

}  // namespace lcpbench
