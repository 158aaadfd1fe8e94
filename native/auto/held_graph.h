#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/contact_problem.h"

namespace lcpbench {

/// Blocks of the inertia that follow each other and are touched by the same contacts.
struct HeldBody {
  int size = 0;
  int first = 0;           ///< coordinate in the problem
  std::size_t block = 0;   ///< of the inertia, its first
  std::size_t factor = 0;  ///< of its part of G, in the factors of the inertia

  bool operator==(const HeldBody&) const = default;
};

/// A body that a contact touches.
struct HeldPart {
  int body = 0;
  int row = 0;    ///< of its first coordinate in the contact's columns
  int first = 0;  ///< that coordinate in the problem
  int size = 0;
  int place = 0;  ///< that coordinate in the order of elimination
};

/// A contact's columns [N_c, first half of D_c], on the coordinates of the bodies that it touches.
struct HeldColumns {
  std::size_t parts = 0, end_parts = 0;  ///< in HeldGraph::parts()
  std::size_t entries = 0;               ///< of its columns, rows x columns
  std::size_t coordinates = 0;           ///< of the problem, of its rows, in HeldGraph
  std::size_t first = 0;                 ///< of its impulses among those of all contacts
  int rows = 0;
  int columns = 0;
};

/// The bodies of a contact problem, the columns by which its contacts act on them, and the bodies' response. Vectors of
/// coordinates are in an order of elimination, which its user gives. Columns of contacts with mu = 0 are their normals
/// alone.
///
/// Keeps its memory, and where the next problem has bodies and contacts of the same sizes only reads the numbers anew.
class HeldGraph {
 public:
  /// Takes the contacts in. O(nonzeros of N and D)
  /// @param contact with the inertia as blocks or as one matrix G; must outlive the next load
  /// @returns whether other bodies, or other pairs of them, are coupled than in the last problem: set_places() follows
  bool load(const ContactProblem& contact);
  /// @param places of each body, of its first coordinate in the order of elimination
  void set_places(std::vector<int> places);

  const std::vector<HeldBody>& bodies() const { return bodies_; }
  const std::vector<HeldColumns>& contacts() const { return contacts_; }
  const std::vector<HeldPart>& parts() const { return parts_; }
  /// Pairs of bodies that a contact touches, the first before the second, ascending.
  const std::vector<std::pair<int, int>>& coupled() const { return coupled_; }
  /// The contact's columns, by columns of `rows` entries.
  const double* columns(const HeldColumns& contact) const { return entries_.data() + contact.entries; }
  /// Columns of all contacts.
  std::size_t column_count() const;
  int most_columns() const;
  int place(std::size_t body) const { return places_[body]; }
  /// G of a body by blocks: visit(first coordinate in the body, block).
  template <class Visit>
  void for_each_block(const HeldBody& body, Visit&& visit) const;

  /// Whether G is positive definite in double.
  bool is_definite() const { return is_definite_; }
  /// What is put for 1 / (a'G*a) of a contact's normal a, as if G were diagonal; 0 where nothing moves.
  double strength(std::size_t contact) const { return strength_[contact]; }

  /// ordered := x, which is in the order of the problem
  void order(const Vector& x, Vector& ordered) const;
  /// x := ordered, in the order of the problem
  void restore(const Vector& ordered, Vector& x) const;
  /// products := columns' x
  void multiply(const HeldColumns& contact, const Vector& x, double* products) const;
  /// to += columns factors
  void add_columns(const HeldColumns& contact, const double* factors, Vector& to) const;
  /// to += G* impulse; impulse is used up.
  void add_response(Vector& impulse, Vector& to) const;

 private:
  bool has_last_sizes() const;
  void find();
  void find_bodies();
  void find_columns();
  void find_coupled();
  bool fill_columns();
  bool fill_column(const Jacobian& J, Index number, const HeldColumns& contact, double* column) const;
  void factor_inertia();
  void measure_strength();
  void multiply_three(const HeldColumns& contact, const Vector& x, double* products) const;

  const ContactProblem* contact_ = nullptr;
  std::vector<Index> block_sizes_;
  std::vector<int> body_of_;  ///< of each coordinate
  std::vector<HeldBody> bodies_, last_bodies_;
  std::vector<HeldColumns> contacts_;
  std::vector<HeldPart> parts_;
  std::vector<int> coordinates_;  ///< of the rows of each contact's columns
  std::vector<std::pair<int, int>> coupled_, last_coupled_;
  std::vector<int> places_;  ///< of each body
  std::vector<double> entries_, inertia_factors_;
  std::vector<double> inverse_diagonal_;   ///< of G, one by one, in the order of the problem
  std::vector<double> strength_;           ///< by contact
  std::vector<std::uint64_t> signatures_;  ///< by block: of the contacts that touch it
  std::vector<Index> last_touched_;        ///< by block
  bool is_definite_ = false;               ///< G
};

/// The block of G with this number; G itself where it is one matrix.
const Matrix& held_block(const ContactProblem& contact, std::size_t block);

template <class Visit>
void HeldGraph::for_each_block(const HeldBody& body, Visit&& visit) const {
  int first = 0;
  for (std::size_t k = body.block; first < body.size; ++k) {
    const Matrix& block = held_block(*contact_, k);
    visit(first, block);
    first += static_cast<int>(block.rows());
  }
}

}  // namespace lcpbench
