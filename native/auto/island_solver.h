#pragma once

#include <vector>

#include "native/auto/island_part.h"

namespace lcpbench {

/// Solves the contacts of one island. First it leaves out contacts that separate. If the answer makes one of them
/// approach, it solves the whole island.
///
/// If no contact approaches, none presses and nothing is solved. Nothing is solved either if no method finds an answer
/// and the approach is so slow that z = 0 is one. Contacts are left out in islands of bodies only, and only if they
/// separate faster than any other contact approaches. The bodies that only they touch are left out with them. The
/// answer is one of the whole island, because contacts left out need no impulse if they do not approach. If a slower
/// method would have to bring them back, contacts at bodies that kept contacts touch are kept. Nothing is left out of
/// islands that only a sparse method may solve: all contacts would have to be loaded as well, which costs what leaving
/// out saves.
class IslandSolver {
 public:
  IslandSolver(const AutoSettings& settings, SharedMethods& shared)
      : settings_(settings),
        all_(settings, shared, settings.islands ? Attempts::Scope::kIsland : Attempts::Scope::kParts),
        some_(settings, shared, Attempts::Scope::kParts) {}

  /// @param whole must outlive the next load()
  /// @param v velocity of the whole problem
  /// @param carries per contact of the whole, 0; kept at 1 for those whose lambda the answer of solve() includes
  /// @param to_hold see Attempts::load_to_hold
  /// @param is_one_of_several a small one then takes turns with the others, see Attempts::load
  void load(ProblemCutter& whole, Island island, const Vector& v, std::vector<char>& carries, bool is_one_of_several,
            bool to_hold);

  /// Whether it is so small that loading it again takes no more time than memory of its own.
  static bool may_take_turns(const Island& island);

  /// Another velocity. Loads something only where a contact approaches for the first time since load().
  void update(const Vector& v);

  /// Adds the island's impulses to z and its change of velocity to u, both of the whole problem. u arrives as v.
  /// Allocates only if a second method, one that is not dense, has to be loaded.
  /// @param start of the whole problem, or nullptr
  /// @returns kSolved, or why not; answer() then says more
  Claim solve(const Vector* start, const AutoLimits& limits, Vector& z, Vector& u, AutoReport& report);

  // Of the last solve, unless the island was at rest:

  /// The last solver's answer for the contacts in contacts().
  const Answer& answer() const { return now_->answer(); }
  const std::vector<Index>& contacts() const { return now_->contacts(); }
  /// Of the island, always.
  const std::vector<Index>& coordinates() const { return island_.coordinates; }
  /// It gave a velocity of the solver's own, which is in u.
  bool gave_velocity() const { return now_ == nullptr || now_->gave_velocity(); }

 private:
  void measure_approach(const Vector& v);
  bool may_press(std::size_t k) const { return !(approach_(static_cast<Index>(k)) > fastest_); }
  void load_parts(const Vector& v);
  bool find_what_may_press();
  bool keep_what_may_be_struck();
  bool leaves_enough_out() const;
  bool some_will_do() const;
  Index count_approaching(const Vector& u) const;
  bool rests(const Vector& u) const;
  Claim remain_at_rest(AutoReport& report);
  void tell_what_is_carried();

  const AutoSettings& settings_;
  ProblemCutter* cutter_ = nullptr;
  std::vector<char>* carries_ = nullptr;
  Island island_;
  Vector approach_;     ///< N'v + b by position in island_.contacts
  double fastest_ = 0;  ///< the largest of -(N'v + b); infinity for what overflows to NaN
  double scale_ = 0;    ///< max|N'v + b|

  IslandPart all_, some_;
  IslandPart* now_ = nullptr;      ///< what is to be solved; nullptr: the island is at rest
  IslandPart* carried_ = nullptr;  ///< what carries_ is told of
  bool takes_turns_ = false;
  bool to_hold_ = false;
  bool is_loaded_ = false;  ///< all_, and some_ where has_some_
  bool has_some_ = false;
  Island kept_;  ///< of some_

  // Positions in island_.contacts:
  std::vector<std::size_t> separating_;  ///< faster, at the load, than any approached
  std::vector<std::size_t> left_out_;    ///< of these, not in some_
};

}  // namespace lcpbench
