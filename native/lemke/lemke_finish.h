#pragma once

#include <vector>

#include "core/problem.h"
#include "core/solver.h"
#include "native/answer_test/bare_lcp_test.h"
#include "native/contacts/contact_input.h"
#include "native/contact_lemke/contact_lemke.h"
#include "native/lemke/lemke_loaded.h"

namespace lcpbench {

/// What `lemke` does with an answer in the precisions `polished` and `quad`: it polishes the final basis. AnswerTest
/// follows.
class LemkeFinish {
 public:
  /// @param judge in whose arithmetic it polishes
  explicit LemkeFinish(const contact_lemke::Engine& judge) : judge_(judge) {}

  /// @param problem must stay as it is until the next load. O(ngc^3), in the judge's arithmetic
  void load(const Problem& problem);

  /// n zeros: where `engine` is to mark what is basic (Rules::basic).
  char* begin_basis();

  /// Polishes an answer that `engine` gave last, where that makes an answer that passes the bound on its residual; else
  /// only what is negative becomes zero. Allocates nothing. @pre claim solved
  void run(lemke::LoadedEngine& engine, Answer& answer);

 private:
  bool polish_matrix(lemke::LoadedEngine& engine, Answer& answer);
  bool polish_contacts(Answer& answer);
  void test_velocity(Answer& answer);

  LoadedContacts judge_;
  bool bare_ = true;
  BareLcpTest bare_test_;
  ContactInput contacts_;
  std::vector<char> basic_;  ///< n
  Vector plain_;             ///< n: the answer before it was polished
  Vector implied_velocity_;  ///< that of the impulses
};

}  // namespace lcpbench
