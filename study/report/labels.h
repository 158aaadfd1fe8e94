#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace lcpbench::report {

/// A rectangle in pixels; y grows downward.
struct Box {
  double left = 0;
  double top = 0;
  double right = 0;
  double bottom = 0;

  bool contains(const Box& other) const;
  /// Shared area; 0 when they only touch.
  double overlap(const Box& other) const;
};

/// A point that wants a label of a given width beside it.
struct LabelledPoint {
  double x = 0;
  double y = 0;
  double width = 0;  ///< of the text
};

struct PlacedLabel {
  Box box;
  bool leader = false;  ///< too far from its point to be read as its label without a line
};

/// Places one label per point inside `area`, near its point and free of other labels, points and obstacles as far as
/// there is room: each label in turn takes its cheapest candidate position, until none moves. Deterministic;
/// O(points^2).
/// @param height of one line of text
std::vector<PlacedLabel> place_labels(std::span<const LabelledPoint> points, std::span<const Box> obstacles,
                                      const Box& area, double height);

/// The labels that overlap another one, or whose leader crosses a label or another leader: where there is no room for
/// all, these are too long. Ascending. O(points^2)
std::vector<std::size_t> crowded_labels(std::span<const LabelledPoint> points, std::span<const PlacedLabel> placed);

/// Heights for labels of one line each in a column, every one as near to what it wishes as order and room allow: where
/// they crowd they are pushed down, then up again from the bottom, until no two overlap. @returns in the order given.
std::vector<double> stack_labels(std::span<const double> wishes, double top, double bottom, double height);

}  // namespace lcpbench::report
