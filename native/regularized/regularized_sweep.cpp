#include <exception>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/swept_answers.h"
#include "core/timed_solve.h"
#include "native/lemke/lemke_sweep.h"
#include "native/regularized/regularized.h"

namespace lcpbench {
namespace {

struct Seconds {
  double wall = 0;
  double cpu = 0;
  Seconds& operator+=(const Seconds& other) {
    wall += other.wall;
    cpu += other.cpu;
    return *this;
  }
};

template <class Work>
Seconds timed(Work&& work) {
  const double wall_s = wall_clock_s();
  const double cpu_s = thread_cpu_clock_s();
  work();
  const double used_s = thread_cpu_clock_s() - cpu_s;
  return {wall_clock_s() - wall_s, used_s};
}

/// `regularized{solver=lemke}` at many pairs of tolerances: M, and each M + eps I as long as cells are left, is one
/// sweep of Lemke's method.
class SweptRegularized final : public SweptSolver {
 public:
  SweptRegularized(const RegularizedSettings& common, std::span<const LemkeSettings> cells)
      : capabilities_(regularized_capabilities("lemke", lemke_capabilities(cells.front()))),
        regularization_(common),
        plain_(cells),
        shifted_(cells),
        track_of_(cells.size()) {}

  void run(const Problem& problem, const TimedRequest& request, std::vector<SweptAnswer>& answers) override {
    try {
      SweptAnswers gathered(answers);
      solve(problem, request, gathered);
      gathered.finish();
    } catch (const std::exception& error) {
      answer_all_with_failure(track_of_.size(), error.what(), answers);
    }
  }

 private:
  /// Cells whose tries have all gone the same way so far.
  struct Track {
    std::vector<std::uint32_t> cells;
    std::shared_ptr<const Answer> first;  ///< of M itself; null before it was tried
    Counters total{.iterations = 0, .pivots = 0, .factorizations = 0};
    Seconds spent;
  };

  struct Try {
    LemkeSweep& sweep;
    double eps = 0;
    int number = 1;
  };

  void solve(const Problem& problem, const TimedRequest& request, SweptAnswers& gathered) {
    std::string refusal;
    setup_ = timed([&] {
      refusal = why_not(capabilities_, problem);
      if (!refusal.empty()) return;
      given_ = problem;
      rigid_ = without_compliance(problem);
      regularization_.load(rigid_);
      plain_.load(regularization_.tried(0));
    });
    time_limit_s_ = request.time_limit_s;
    tracks_.assign(1, Track{});
    for (std::uint32_t cell = 0; cell < track_of_.size(); ++cell) tracks_.front().cells.push_back(cell);
    if (!refusal.empty()) {
      Answer refused;
      refused.claim = Claim::kUnsupported;
      refused.detail = refusal;
      refused.counters = tracks_.front().total = Counters{};
      return add(tracks_.front(), std::move(refused), gathered);
    }

    attempt({plain_}, request.time_limit_s, gathered);
    int number = 1;
    for (auto eps = regularization_.next(0); eps && !tracks_.empty(); eps = regularization_.next(*eps)) {
      const Seconds load = timed([&] { shifted_.load(regularization_.tried(*eps)); });
      for (Track& track : tracks_) track.spent += load;
      attempt({shifted_, *eps, ++number}, request.time_limit_s, gathered);
    }
    for (const Track& track : tracks_) fail(track, TryOutcome::kFailed, gathered);
  }

  /// Solves for the cells of all tracks and keeps those that are to be tried again.
  void attempt(const Try& present, double time_limit_s, SweptAnswers& gathered) {
    const std::vector<Track> before = std::exchange(tracks_, {});
    tries_.clear();
    for (std::size_t t = 0; t < before.size(); ++t) {
      const double left_s = time_limit_s - before[t].spent.wall;
      if (!(left_s > 0)) {
        fail(before[t], TryOutcome::kOutOfTime, gathered);
        continue;
      }
      for (const std::uint32_t cell : before[t].cells) {
        track_of_[cell] = t;
        tries_.push_back({cell, left_s});
      }
    }
    present.sweep.walk(tries_, leaves_);
    for (LemkeLeaf& leaf : leaves_) {
      TryOutcome outcome{};
      const double deadline_s = wall_clock_s() + time_limit_s;  // tracks that meet here may have less time left
      Seconds spent = timed([&] { outcome = regularization_.judge(leaf.answer, present.eps, deadline_s); });
      spent += {leaf.wall_s, leaf.cpu_s};
      for (Track& track : continued(before, leaf, spent))
        settle(std::move(track), leaf.answer, outcome, present, gathered);
    }
  }

  /// The tracks that lead to a leaf, each with its cells there.
  std::vector<Track> continued(const std::vector<Track>& before, const LemkeLeaf& leaf, const Seconds& spent) const {
    std::vector<Track> tracks;
    constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
    std::vector<std::size_t> place(before.size(), kNone);
    for (const std::uint32_t cell : leaf.cells) {
      const std::size_t from = track_of_[cell];
      if (place[from] == kNone) {
        place[from] = tracks.size();
        Track& track = tracks.emplace_back();
        track.first = before[from].first != nullptr ? before[from].first : std::make_shared<const Answer>(leaf.answer);
        track.total = before[from].total;
        add_counters(track.total, leaf.answer.counters);
        track.spent = before[from].spent;
        track.spent += spent;
      }
      tracks[place[from]].cells.push_back(cell);
    }
    return tracks;
  }

  void settle(Track track, const Answer& last, TryOutcome outcome, const Try& present, SweptAnswers& gathered) {
    if (outcome == TryOutcome::kPassed) {
      Answer answer = last;
      Regularization::report_pass(present.eps, present.number, answer);
      add(track, std::move(answer), gathered);
    } else if (outcome == TryOutcome::kOutOfTime || track.first->claim == Claim::kUnsupported) {
      fail(track, outcome, gathered);
    } else {
      tracks_.push_back(std::move(track));
    }
  }

  void fail(const Track& track, TryOutcome last, SweptAnswers& gathered) {
    Answer answer;
    answer.z.setZero(regularization_.size());
    if (track.first != nullptr) answer = *track.first;
    regularization_.report_failure(last, answer, wall_clock_s() + time_limit_s_ - track.spent.wall);
    add(track, std::move(answer), gathered);
  }

  void add(const Track& track, Answer answer, SweptAnswers& gathered) const {
    answer.counters = track.total;
    return_to_given(given_, rigid_, answer);
    SolveTimes times;
    times.setup_wall_s = setup_.wall;
    times.setup_cpu_s = setup_.cpu;
    times.solve_wall_s = track.spent.wall;
    times.solve_cpu_s = track.spent.cpu;
    gathered.add(track.cells, {std::move(answer), times});
  }

  Capabilities capabilities_;
  Regularization regularization_;
  LemkeSweep plain_;    // holds M
  LemkeSweep shifted_;  // holds M + eps I, loaded anew for each eps
  Problem given_, rigid_;
  Seconds setup_;
  double time_limit_s_ = 0;
  std::vector<Track> tracks_;
  std::vector<std::size_t> track_of_;  // of each cell, among the tracks before the present try
  std::vector<LemkeTry> tries_;
  std::vector<LemkeLeaf> leaves_;
};

/// All settings but the inner solver.
Options others(RegularizedSettings settings) {
  settings.solver.clear();
  return all_settings(settings);
}

}  // namespace

std::unique_ptr<SweptSolver> make_swept_regularized(const std::vector<Options>& cells) {
  std::vector<RegularizedSettings> settings;
  std::vector<Options> inner;
  for (const Options& cell : cells) {
    settings.push_back(parse_settings<RegularizedSettings>("regularized", cell));
    Spec spec = parse_spec(settings.back().solver);
    regularized_inner(spec);
    if (spec.name != "lemke" || others(settings.back()) != others(settings.front())) return nullptr;
    inner.push_back(std::move(spec.options));
  }
  const auto tolerances = LemkeSweep::readable(inner);
  return tolerances ? std::make_unique<SweptRegularized>(settings.front(), *tolerances) : nullptr;
}

}  // namespace lcpbench
