#include "native/answer_room.h"

#include "core/answer_storage.h"

namespace lcpbench {

void AnswerRoom::write_text(std::string_view text, Answer& answer) {
  if (answer.detail.capacity() < text.size()) answer.detail.swap(text_);
  answer.detail.assign(text);
}

void AnswerRoom::write_velocity(const Vector& u, Answer& answer) {
  if (answer.velocity.size() == 0) answer.velocity.swap(cleared_vectors().velocity);
  if (answer.velocity.size() != u.size()) answer.velocity.swap(velocity_);
  answer.velocity = u;
}

}  // namespace lcpbench
