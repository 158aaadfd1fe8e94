#pragma once

#include <string>
#include <string_view>

#include "core/solver.h"

namespace lcpbench {

/// Memory for what answers may come without: it is given to the first one that lacks it, and later solves find it
/// there.
class AnswerRoom {
 public:
  /// Room for a text of kLongestText characters and for a velocity of so many coordinates. Allocates.
  void reserve(Index coordinates) {
    text_.reserve(kLongestText);
    velocity_.resize(coordinates);
  }

  /// answer.detail = text.
  void write_text(std::string_view text, Answer& answer);

  /// answer.velocity = u, in the memory of the last velocity where the answer had one.
  void write_velocity(const Vector& u, Answer& answer);

 private:
  static constexpr std::size_t kLongestText = 80;

  std::string text_;
  Vector velocity_;
};

}  // namespace lcpbench
