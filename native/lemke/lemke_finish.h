#pragma once

#include <vector>

#include "core/problem.h"
#include "core/solver.h"
#include "native/answer_test/bare_lcp_test.h"
#include "native/contacts/contact_input.h"
#include "native/contact_lemke/contact_lemke.h"
#include "native/lemke/lemke_loaded.h"

namespace lcpbench {

/// What `lemke` does with an answer in every precision but double, which has none of it: polish it, and test it from
/// the raw data, so that what is claimed holds.
class LemkeFinish {
 public:
  /// @param polishes polish the answer in the arithmetic of `judge`
  LemkeFinish(const contact_lemke::Engine& judge, bool polishes);

  /// @param problem must stay as it is until the next load. O(ngc^3), in the judge's arithmetic
  void load(const Problem& problem);

  /// n zeros: where `engine` is to mark what is basic (Rules::basic).
  char* begin_basis();

  /// Turns a claim of solved that does not pass the test, and a ray, into kNumericalFailure. `answer` is what `engine`
  /// gave last. Allocates nothing.
  void run(lemke::LoadedEngine& engine, Answer& answer);

 private:
  double finish_contacts(Answer& answer);
  double finish_matrix(lemke::LoadedEngine& engine, Answer& answer);
  bool polish_contacts(Answer& answer);
  void test_velocity(Answer& answer);

  LoadedContacts judge_;
  bool polishes_;
  bool bare_ = true;
  BareLcpTest bare_test_;
  ContactInput contacts_;
  std::vector<char> basic_;  ///< n
  Vector plain_;             ///< n: the answer before it was polished
  Vector implied_velocity_;  ///< that of the impulses
};

}  // namespace lcpbench
