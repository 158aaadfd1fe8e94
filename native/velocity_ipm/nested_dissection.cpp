#include "native/velocity_ipm/nested_dissection.h"

#include <algorithm>
#include <cstddef>

namespace lcpbench {
namespace {

class Dissection {
 public:
  explicit Dissection(const SparseMatrix& lower)
      : neighbours_begin_(static_cast<std::size_t>(lower.rows()) + 1, 0),
        piece_(static_cast<std::size_t>(lower.rows()), 0),
        level_(static_cast<std::size_t>(lower.rows()), -1) {
    const auto for_each_edge = [&](auto&& visit) {
      for (Index j = 0; j < lower.outerSize(); ++j) {
        for (SparseMatrix::InnerIterator entry(lower, j); entry; ++entry) {
          if (entry.row() == j) continue;
          visit(static_cast<std::size_t>(entry.row()), static_cast<std::size_t>(j));
          visit(static_cast<std::size_t>(j), static_cast<std::size_t>(entry.row()));
        }
      }
    };
    for_each_edge([&](std::size_t from, std::size_t) { ++neighbours_begin_[from + 1]; });
    for (std::size_t v = 1; v < neighbours_begin_.size(); ++v) neighbours_begin_[v] += neighbours_begin_[v - 1];
    neighbours_.resize(neighbours_begin_.back());
    std::vector<std::size_t> next(neighbours_begin_.begin(), neighbours_begin_.end() - 1);
    for_each_edge([&](std::size_t from, std::size_t to) { neighbours_[next[from]++] = static_cast<int>(to); });
  }

  /// All vertices in order of elimination.
  std::vector<int> run() {
    std::vector<int> order(piece_.size());
    for (std::size_t v = 0; v < order.size(); ++v) order[v] = static_cast<int>(v);
    order_ = order.data();
    open_.push_back({0, order.size()});
    while (!open_.empty()) {
      const Piece piece = open_.back();
      open_.pop_back();
      split_into_components(piece);
    }
    return order;
  }

 private:
  static constexpr std::size_t kSmallest = 24;  // pieces from here on are not worth a separator

  struct Piece {
    std::size_t begin = 0;
    std::size_t end = 0;
  };

  int& level(int vertex) { return level_[static_cast<std::size_t>(vertex)]; }

  /// Breadth first within the present piece from `root`: vertices in order of their level into reached_.
  void search(int root) {
    for (const int vertex : reached_) level(vertex) = -1;
    reached_.assign(1, root);
    level(root) = 0;
    for (std::size_t next = 0; next < reached_.size(); ++next) {
      const auto v = static_cast<std::size_t>(reached_[next]);
      for (std::size_t e = neighbours_begin_[v]; e < neighbours_begin_[v + 1]; ++e) {
        const int to = neighbours_[e];
        if (piece_[static_cast<std::size_t>(to)] != present_ || level(to) >= 0) continue;
        level(to) = level_[v] + 1;
        reached_.push_back(to);
      }
    }
  }

  /// Makes the piece's connected components stand together, and separates each.
  void split_into_components(Piece piece) {
    ++present_;
    const std::vector<int> vertices(order_ + piece.begin, order_ + piece.end);
    for (const int vertex : vertices) piece_[static_cast<std::size_t>(vertex)] = present_;
    std::size_t begin = piece.begin;
    for (const int vertex : vertices) {
      if (piece_[static_cast<std::size_t>(vertex)] != present_) continue;  // in a component that was dealt with
      reached_.clear();
      search(vertex);
      if (reached_.size() > kSmallest) {
        for (int turn = 0; turn < 2; ++turn) search(reached_.back());  // towards a vertex far from all others
      }
      separate(begin);
      for (const int reached : reached_) {
        level(reached) = -1;
        piece_[static_cast<std::size_t>(reached)] = -1;
      }
      begin += reached_.size();
    }
  }

  /// Writes the component that was reached from `begin` on: [below, above, separator], the first two to be split again.
  void separate(std::size_t begin) {
    const int last = level(reached_.back());
    if (reached_.size() <= kSmallest || last < 2) {
      std::copy(reached_.begin(), reached_.end(), order_ + begin);
      return;
    }
    const int middle = thinnest_middle_level(last);
    std::vector<int> below, above, separator;
    for (const int vertex : reached_) {
      if (level(vertex) == middle && has_neighbour_in(vertex, middle + 1)) {
        separator.push_back(vertex);
      } else {
        (level(vertex) <= middle ? below : above).push_back(vertex);
      }
    }
    int* end = std::copy(below.begin(), below.end(), order_ + begin);
    end = std::copy(above.begin(), above.end(), end);
    std::copy(separator.begin(), separator.end(), end);
    open_.push_back({begin, begin + below.size()});
    open_.push_back({begin + below.size(), begin + below.size() + above.size()});
  }

  /// The level with the fewest vertices of those that leave each side at least two fifths.
  int thinnest_middle_level(int last) {
    std::vector<std::size_t> sizes(static_cast<std::size_t>(last) + 1, 0);
    for (const int vertex : reached_) ++sizes[static_cast<std::size_t>(level(vertex))];
    int best = 1;
    std::size_t before = sizes[0];
    double best_cost = 0;
    bool found = false;
    for (int l = 1; l < last; ++l) {
      const std::size_t size = sizes[static_cast<std::size_t>(l)];
      const double share =
          (static_cast<double>(before) + 0.5 * static_cast<double>(size)) / static_cast<double>(reached_.size());
      before += size;
      // Away from the middle, as if the level were larger.
      const double cost = static_cast<double>(size) * (1 + 4 * (share > 0.5 ? share - 0.5 : 0.5 - share));
      if (found && !(cost < best_cost)) continue;
      if ((share < 0.4 || share > 0.6) && l != last / 2) continue;
      found = true;
      best = l;
      best_cost = cost;
    }
    return best;
  }

  bool has_neighbour_in(int vertex, int wanted) {
    const auto v = static_cast<std::size_t>(vertex);
    for (std::size_t e = neighbours_begin_[v]; e < neighbours_begin_[v + 1]; ++e) {
      const int to = neighbours_[e];
      if (piece_[static_cast<std::size_t>(to)] == present_ && level(to) == wanted) return true;
    }
    return false;
  }

  std::vector<std::size_t> neighbours_begin_;
  std::vector<int> neighbours_;
  std::vector<int> piece_;  // number of the piece that the vertex was last in
  int present_ = 0;
  std::vector<int> level_;  // -1: not reached
  std::vector<int> reached_;
  int* order_ = nullptr;
  std::vector<Piece> open_;
};

}  // namespace

std::vector<int> nested_dissection(const SparseMatrix& lower) {
  if (lower.rows() == 0) return {};
  return Dissection(lower).run();
}

}  // namespace lcpbench
