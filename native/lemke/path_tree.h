#pragma once

#include <memory>

#include "native/lemke/kernel_basis.h"
#include "native/lemke/lemke_engine.h"
#include "native/lemke/path.h"
#include "native/lemke/ratio_test.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// What a PathTree works in; kept between walks, so that they allocate nothing once it is large enough.
template <class Basis>
struct TreeRoom {
  Buffer<Count> cells;     ///< numbers of the cells; those whose paths are the same so far stand side by side
  Buffer<Count> decision;  ///< of each cell: the variable that leaves next, or how its path ends
  std::unique_ptr<typename Basis::State[]> states;  ///< where the present path has parted from others, outermost first
  Count state_count = 0;
  KernelMark mark;  ///< a basis of the present path

  void reserve(Count count) {
    cells.resize(count);
    decision.resize(count);
    if (state_count >= count) return;
    states.reset(new typename Basis::State[static_cast<std::size_t>(count)]);
    state_count = count;
  }
};

/// Lemke's paths for many pairs of tolerances. They enter into the test for z = 0 and into the ratio test alone, so
/// that all pairs share one path until the ratio test tells them apart; there the basis is saved and each path is
/// followed to its end, depth first.
template <bool kResolve, class Basis>
class PathTree {
 public:
  PathTree(Basis& basis, TreeRoom<Basis>& room, const Cell* cells, const WalkRules& rules, double* z)
      : basis_(basis), room_(room), cells_(cells), rules_(rules), z_(z), n_(basis.problem().n()) {}

  /// Returns the number of pivots done.
  Count walk(Count count) {
    room_.reserve(count);
    for (Count i = 0; i < count; ++i) room_.cells[i] = i;
    const Count trivial = split({0, count}, [this](const Cell& cell) {
      return basis_.problem().zero_solves(cell.zero_tolerance);
    });
    if (trivial > 0) {
      clear_solution();
      report({0, trivial}, {}, Ending::kSolved);
    }
    if (trivial < count) {
      start_clocks();
      const Count row = basis_.problem().most_negative_row();
      basis_.start(row);
      Path root;
      root.wall_s = rules_.idle_wall_s;
      root.cpu_s = rules_.idle_cpu_s;
      follow(bounded({trivial, count}), root, row);
    }
    return pivots_;
  }

 private:
  /// A range of room_.cells.
  struct Range {
    Count first = 0, last = 0;
  };

  struct Group {
    Range range;
    ToleranceBox box;
    double time_limit_s = 0;  ///< the least of its cells
  };

  /// A path up to the last reading of the clocks.
  struct Path {
    Outcome outcome;
    double wall_s = 0, cpu_s = 0;
  };

  /// A point of a path to which it may come back.
  struct Mark {
    Count leaving = kNone;
    Count pivots = 0;  ///< of the path when it was there
    Count patience = kFirstPatience;
    double wall_s = 0, cpu_s = 0;
  };
  static constexpr Count kNone = -1;
  static constexpr Count kFirstPatience = 16;
  /// Laps of two pivots are common; a reading of the clocks is to be small against what it times.
  static constexpr Count kFewestTimed = 32;

  // Decisions that are no variable's number.
  static constexpr Count kRay = -1;
  static constexpr Count kBreakdown = -2;
  static constexpr Count kSeveral = -3;

  const Cell& cell(Count place) const { return cells_[room_.cells[place]]; }
  Count& decision(Count place) { return room_.decision[room_.cells[place]]; }

  void swap_cells(Count a, Count b) {
    const Count number = room_.cells[a];
    room_.cells[a] = room_.cells[b];
    room_.cells[b] = number;
  }

  /// Brings the cells for which `belongs` holds to the front; returns the place behind them.
  template <class Predicate>
  Count split(Range range, Predicate belongs) {
    Count end = range.first;
    for (Count i = range.first; i < range.last; ++i) {
      if (belongs(cell(i))) swap_cells(i, end++);
    }
    return end;
  }

  Group bounded(Range range) const {
    const Cell& first = cell(range.first);
    Group group{range,
                {first.pivot_tolerance, first.pivot_tolerance, first.zero_tolerance, first.zero_tolerance},
                first.time_limit_s};
    ToleranceBox& box = group.box;
    for (Count i = range.first + 1; i < range.last; ++i) {
      const Cell& next = cell(i);
      if (next.pivot_tolerance < box.pivot_low) box.pivot_low = next.pivot_tolerance;
      if (next.pivot_tolerance > box.pivot_high) box.pivot_high = next.pivot_tolerance;
      if (next.zero_tolerance < box.zero_low) box.zero_low = next.zero_tolerance;
      if (next.zero_tolerance > box.zero_high) box.zero_high = next.zero_tolerance;
      if (next.time_limit_s < group.time_limit_s) group.time_limit_s = next.time_limit_s;
    }
    return group;
  }

  /// The middle of a grid of powers: a number from `low` on that is less than `high`. @pre low < high
  static double middle(double low, double high) {
    const double mean = __builtin_sqrt(low) * __builtin_sqrt(high);
    return mean >= low && mean < high ? mean : low;
  }

  /// From a basis whose last exchange let `leaving` go to the ends of all paths from there.
  void follow(Group group, Path path, Count leaving) {
    const Count artificial = basis_.problem().artificial();
    Mark mark;
    mark.pivots = path.outcome.pivots;
    while (leaving != artificial) {
      if (path.outcome.pivots >= rules_.max_pivots) return end(group.range, path, Ending::kPivotLimit);
      if (path.outcome.pivots % kPivotsPerClockReading == 0 && !go_on(group, path)) return;
      if constexpr (kResolve) {
        if (goes_round(group, path, leaving, mark)) return report(group.range, path, Ending::kPivotLimit);
      }
      const Count entering = complement(leaving, n_);
      if (!find_direction<kResolve>(basis_, entering, path.outcome)) return end(group.range, path, Ending::kBreakdown);
      leaving = decide(group);
      if (leaving == kSeveral) return part(group.range, path, entering);
      if (leaving < 0) return end(group.range, path, ending_of(leaving));
      exchange(entering, leaving, path);
    }
    clear_solution();
    const Ending ending = finish<kResolve>(basis_, path.outcome, z_);
    end(group.range, path, ending);
  }

  void exchange(Count entering, Count leaving, Path& path) {
    pivot<kResolve>(basis_, entering, leaving, path.outcome);
    ++pivots_;
  }

  /// What leaves for all cells of the group, or kSeveral: each cell's own stands in room_.decision then.
  Count decide(const Group& group) {
    const Count artificial = basis_.problem().artificial();
    const BoxBlocking common = ratio_test(basis_.slots(), group.box, artificial, basis_.slot_of(artificial));
    if (common.consent == Consent::kAlike) return decision_of(common.blocking);
    const bool by_pivot = common.consent == Consent::kHalvePivot;
    const ToleranceBox& box = group.box;
    const double most = by_pivot ? middle(box.pivot_low, box.pivot_high) : middle(box.zero_low, box.zero_high);
    const Count border = split(group.range, [by_pivot, most](const Cell& cell) {
      return (by_pivot ? cell.pivot_tolerance : cell.zero_tolerance) <= most;
    });
    const Count low = decide_half({group.range.first, border});
    const Count high = decide_half({border, group.range.last});
    return low == high ? low : kSeveral;
  }

  Count decide_half(Range range) {
    const Count common = decide(bounded(range));
    if (common == kSeveral) return kSeveral;
    for (Count i = range.first; i < range.last; ++i) decision(i) = common;
    return common;
  }

  static Count decision_of(const Blocking& blocking) {
    if (blocking.kind == Block::kRay) return kRay;
    return blocking.kind == Block::kFound ? blocking.leaving : kBreakdown;
  }

  static Ending ending_of(Count decision) { return decision == kRay ? Ending::kRay : Ending::kBreakdown; }

  /// The cells have decided differently: each decision becomes a path of its own.
  void part(Range range, Path path, Count entering) {
    stop_clocks(path);
    const Count continuing = gather(range);
    typename Basis::State& state = room_.states[static_cast<std::size_t>(depth_)];
    if (continuing > (Basis::kRulesOf2012 ? 0 : 1)) basis_.template save<kResolve>(state);
    ++depth_;
    bool as_saved = true;
    while (range.first < range.last) {
      const Range same = alike(range);
      const Count chosen = decision(same.first);
      const bool needs_basis = chosen >= 0 || Basis::kRulesOf2012;
      if (needs_basis && !as_saved) basis_.template restore<kResolve>(state);
      as_saved = as_saved || needs_basis;
      if (chosen < 0) {
        report(same, path, ending_of(chosen));
      } else {
        as_saved = false;
        Path branch = path;
        start_clocks();
        exchange(entering, chosen, branch);
        follow(bounded(same), branch, chosen);
      }
      range.first = same.last;
    }
    --depth_;
  }

  /// Brings cells of the same decision together; returns the number of decisions with which a path goes on.
  Count gather(Range range) {
    Count continuing = 0;
    while (range.first < range.last) {
      const Count chosen = decision(range.first);
      continuing += chosen >= 0 ? 1 : 0;
      for (Count i = range.first; i < range.last; ++i) {
        if (decision(i) == chosen) swap_cells(i, range.first++);
      }
    }
    return continuing;
  }

  /// The cells at the front of a gathered range that have the same decision.
  Range alike(Range range) {
    Count last = range.first;
    while (last < range.last && decision(last) == decision(range.first)) ++last;
    return {range.first, last};
  }

  /// Ends the path of the cells whose time is over; false when none is left.
  bool go_on(Group& group, Path& path) {
    if (!(group.time_limit_s < kInfinity<double>)) return true;
    const double wall_s = path.wall_s + rules_.wall_s() - wall_begin_s_;
    if (wall_s < group.time_limit_s) return true;
    const Count border = split(group.range, [wall_s](const Cell& cell) { return !(wall_s < cell.time_limit_s); });
    stop_clocks(path);
    report({group.range.first, border}, path, Ending::kTimeLimit);
    if (border == group.range.last) return false;
    group = bounded({border, group.range.last});
    start_clocks();
    return true;
  }

  /// Whether the path has come back to where it was. With values that are resolved from the basis at each pivot nothing
  /// tells the two visits apart, so that it goes round up to the limit on pivots. It is then put there, and its time is
  /// what the pivots since the first visit have taken, times the number of them that are left. A path that would run
  /// out of time on the way is followed.
  bool goes_round(const Group& group, Path& path, Count leaving, Mark& mark) {
    const Count gone = path.outcome.pivots - mark.pivots;
    if (leaving != mark.leaving || !basis_.is_at(room_.mark)) {
      if (gone >= mark.patience) set(mark, path, leaving);
      return false;
    }
    if (gone < kFewestTimed) return false;
    stop_clocks(path);
    const Count left = rules_.max_pivots - path.outcome.pivots;
    const double times = static_cast<double>(left) / static_cast<double>(gone);
    const double wall_s = path.wall_s + times * (path.wall_s - mark.wall_s);
    if (!(wall_s < group.time_limit_s)) {
      start_clocks();
      return false;
    }
    path.wall_s = wall_s;
    path.cpu_s += times * (path.cpu_s - mark.cpu_s);
    path.outcome.pivots += left;
    path.outcome.factorizations += left;
    return true;
  }

  /// Marks the present basis, and waits for it twice as long as for the one before: any lap is found in the end.
  void set(Mark& mark, Path& path, Count leaving) {
    stop_clocks(path);
    mark = {leaving, path.outcome.pivots, 2 * mark.patience, path.wall_s, path.cpu_s};
    basis_.mark(room_.mark);
    start_clocks();
  }

  void end(Range range, Path& path, Ending ending) {
    stop_clocks(path);
    report(range, path, ending);
  }

  void report(Range range, const Path& path, Ending ending) {
    Leaf leaf{room_.cells.data() + range.first, range.last - range.first, path.outcome, path.wall_s, path.cpu_s};
    leaf.outcome.ending = ending;
    if (ending != Ending::kSolved) clear_solution();
    if constexpr (Basis::kRulesOf2012) write_any_solution(basis_, ending, z_);
    rules_.on_leaf(rules_.context, leaf);
  }

  void clear_solution() {
    for (Count i = 0; i < n_; ++i) z_[i] = 0;
  }

  void start_clocks() {
    wall_begin_s_ = rules_.wall_s();
    cpu_begin_s_ = rules_.cpu_s();
  }

  void stop_clocks(Path& path) const {
    const double cpu_s = rules_.cpu_s() - cpu_begin_s_ - rules_.idle_cpu_s;
    const double wall_s = rules_.wall_s() - wall_begin_s_ - rules_.idle_wall_s;
    path.cpu_s += cpu_s > 0 ? cpu_s : 0;
    path.wall_s += wall_s > 0 ? wall_s : 0;
  }

  Basis& basis_;
  TreeRoom<Basis>& room_;
  const Cell* cells_;
  const WalkRules& rules_;
  double* z_;
  Count n_;
  Count pivots_ = 0;
  Count depth_ = 0;
  double wall_begin_s_ = 0, cpu_begin_s_ = 0;
};

/// An engine over one representation of the basis.
template <class Basis>
class BasisEngine : public Engine {
 public:
  void load(const Input& input) override { basis_.load(input); }

  Outcome solve(const Rules& rules, double* z) override {
    if (basis_.problem().zero_solves(rules.zero_tolerance)) return {.ending = Ending::kSolved};
    if constexpr (!Basis::kRulesOf2012) {
      if (rules.resolve) return follow_path<true>(basis_, rules, z);
    }
    return follow_path<false>(basis_, rules, z);
  }

  Count walk(const Cell*, Count, const WalkRules&, double*) override { return 0; }

 protected:
  Basis basis_;
};

/// An engine with the room in which a sweep's paths part.
template <class Basis>
class SweepingEngine final : public BasisEngine<Basis> {
 public:
  Count walk(const Cell* cells, Count count, const WalkRules& rules, double* z) override {
    if constexpr (!Basis::kRulesOf2012) {
      if (rules.resolve) return PathTree<true, Basis>(this->basis_, room_, cells, rules, z).walk(count);
    }
    return PathTree<false, Basis>(this->basis_, room_, cells, rules, z).walk(count);
  }

 private:
  TreeRoom<Basis> room_;
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
