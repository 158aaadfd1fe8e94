#include "study/run/one_by_one.h"

#include <utility>

#include "core/swept_answers.h"

namespace lcpbench {
namespace {

constexpr Index kLargeProblem = 100;  // order of M

class OneByOne final : public SweptSolver {
 public:
  OneByOne(std::vector<OpenCell> cells, bool keep) : open_(std::move(cells)), keep_(keep), solvers_(open_.size()) {}

  void run(const Problem& problem, const TimedRequest& request, std::vector<SweptAnswer>& answers) override {
    SweptAnswers gathered(answers);
    TimedRequest once = request;
    once.repeat_until_s = 0;
    for (std::size_t cell = 0; cell < open_.size(); ++cell) {
      if (solvers_[cell] == nullptr) solvers_[cell] = open_[cell]();
      TimedAnswer timed;
      solvers_[cell]->run(problem, once, timed);
      if (!keep_ || problem.size() > kLargeProblem) solvers_[cell].reset();
      gathered.add({static_cast<std::uint32_t>(cell)}, std::move(timed));
    }
    gathered.finish();
  }

 private:
  std::vector<OpenCell> open_;
  bool keep_;
  std::vector<std::unique_ptr<TimedSolver>> solvers_;
};

}  // namespace

std::unique_ptr<SweptSolver> one_by_one(std::vector<OpenCell> cells, bool keep) {
  return std::make_unique<OneByOne>(std::move(cells), keep);
}

}  // namespace lcpbench
