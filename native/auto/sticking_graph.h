#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/contact_problem.h"
#include "native/velocity_ipm/cholesky_engine.h"

namespace lcpbench {

/// Blocks of the inertia that follow each other and are touched by the same contacts.
struct StickingBody {
  int size = 0;
  int first = 0;           ///< coordinate in the problem
  std::size_t block = 0;   ///< of the inertia, its first
  std::size_t factor = 0;  ///< of its part of G, in the factors of the inertia

  bool operator==(const StickingBody&) const = default;
};

/// A body that a contact touches.
struct StickingPart {
  int body = 0;
  int row = 0;    ///< of its first coordinate in the contact's columns
  int first = 0;  ///< that coordinate in the problem
  int size = 0;
  int place = 0;  ///< that coordinate in the order of elimination
};

/// A contact's columns [N_c, first half of D_c], on the coordinates of the bodies that it touches.
struct StickingColumns {
  std::size_t parts = 0, end_parts = 0;  ///< in StickingGraph::parts()
  std::size_t entries = 0;               ///< of its columns, one each `stride`
  std::size_t coordinates = 0;           ///< of the problem, of its rows, in StickingGraph
  std::size_t first = 0;                 ///< of its impulses among those of all contacts
  int rows = 0;
  int stride = 0;  ///< of one body that is all: rows and cholesky::kMargin zeros; else rows
  int columns = 0;
};

/// The bodies of a contact problem, and the columns by which its contacts act on them. Vectors of
/// coordinates are in an order of elimination, which its user gives. Columns of contacts with mu = 0 are their normals
/// alone. Where one body is all, such as a robot, the columns of all contacts are one dense matrix.
///
/// Keeps its memory, and where the next problem has bodies and contacts of the same sizes only reads the numbers anew.
class StickingGraph {
 public:
  StickingGraph();

  /// Takes the contacts in. O(nonzeros of N and D)
  /// @param contact with the inertia as blocks or as one matrix G; must outlive the next load
  /// @returns whether other bodies, or other pairs of them, are coupled than in the last problem: set_places() follows
  bool load(const ContactProblem& contact);
  /// @param places of each body, of its first coordinate in the order of elimination
  void set_places(std::vector<int> places);

  const std::vector<StickingBody>& bodies() const { return bodies_; }
  const std::vector<StickingColumns>& contacts() const { return contacts_; }
  const std::vector<StickingPart>& parts() const { return parts_; }
  /// Pairs of bodies that a contact touches, the first before the second, ascending.
  const std::vector<std::pair<int, int>>& coupled() const { return coupled_; }
  /// Whether all coordinates are those of one body, which all contacts touch.
  bool is_one() const { return bodies_.size() == 1; }
  /// Entries of vectors in the order of elimination: behind the coordinates stand zeros.
  Index padded_size() const { return contact_->ngc() + cholesky::kMargin; }
  /// The contact's columns, by columns of `stride` entries.
  const double* columns(const StickingColumns& contact) const { return entries_.data() + contact.entries; }
  /// Columns of all contacts.
  std::size_t column_count() const;
  int place(std::size_t body) const { return places_[body]; }
  /// G of a body by blocks: visit(first coordinate in the body, block).
  template <class Visit>
  void for_each_block(const StickingBody& body, Visit&& visit) const;

  /// What is put for 1 / (a'G*a) of a contact's normal a, as if G were diagonal; 0 where nothing moves.
  double strength(std::size_t contact) const { return strength_[contact]; }

  /// ordered := x, which is in the order of the problem
  void order(const Vector& x, Vector& ordered) const;
  /// x := ordered, in the order of the problem
  void restore(const Vector& ordered, Vector& x) const;
  /// products := A'x, of all columns
  void multiply(const Vector& x, double* products) const;
  /// to += A factors, of all columns
  void add_columns(const double* factors, Vector& to) const;
  /// The lower triangle of the body's G, in columns of its size and cholesky::kMargin, as the kernels take it.
  void copy_inertia(const StickingBody& body, double* to) const;
  /// to += G* impulse; impulse is used up. Factors G, once after each load.
  void add_response(Vector& impulse, Vector& to);
  /// from -= G x
  void subtract_inertia(const Vector& x, Vector& from) const;
  /// x := D^-1 x, D the diagonal of G: about the velocity that an impulse x gives
  void respond_by_diagonal(Vector& x) const;

 private:
  bool has_last_sizes() const;
  void find();
  void find_bodies();
  void find_columns();
  void find_coupled();
  void take_room();
  bool fill_columns();
  bool fill_column(const Jacobian& J, Index number, const StickingColumns& contact, double* column) const;
  void invert_diagonal();
  void factor_inertia();
  void factor_inertia(const StickingBody& body, double* L);
  void measure_strength();
  void multiply_contact(const StickingColumns& contact, const Vector& x, double* products) const;
  void add_contact(const StickingColumns& contact, const double* factors, Vector& to) const;

  const cholesky::Engine& kernels_;
  const ContactProblem* contact_ = nullptr;
  std::vector<Index> block_sizes_;
  std::vector<int> body_of_;  ///< of each coordinate
  std::vector<StickingBody> bodies_, last_bodies_;
  std::vector<StickingColumns> contacts_;
  std::vector<StickingPart> parts_;
  std::vector<int> coordinates_;  ///< of the rows of each contact's columns
  std::vector<std::pair<int, int>> coupled_, last_coupled_;
  std::vector<int> places_;  ///< of each body
  std::vector<double> entries_, inertia_factors_;
  bool has_factors_ = false;               ///< inertia_factors_ are those of the problem
  std::vector<double> dense_, work_;       ///< to factor the inertia of a body
  std::vector<double> inverse_diagonal_;   ///< of G, one by one, in the order of the problem
  std::vector<double> strength_;           ///< by contact
  std::vector<std::uint64_t> signatures_;  ///< by block: of the contacts that touch it
  std::vector<Index> last_touched_;        ///< by block
};

/// The block of G with this number; G itself where it is one matrix.
const Matrix& sticking_block(const ContactProblem& contact, std::size_t block);

template <class Visit>
void StickingGraph::for_each_block(const StickingBody& body, Visit&& visit) const {
  int first = 0;
  for (std::size_t k = body.block; first < body.size; ++k) {
    const Matrix& block = sticking_block(*contact_, k);
    visit(first, block);
    first += static_cast<int>(block.rows());
  }
}

}  // namespace lcpbench
