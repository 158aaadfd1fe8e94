#include "core/problem.h"

#include <array>
#include <mutex>
#include <optional>
#include <utility>

namespace lcpbench {

struct Problem::Data {
  std::string name;
  ProblemKind kind = ProblemKind::kLcp;
  std::optional<RigidScene> scene;
  std::shared_ptr<const ContactProblem> contact;
  MatrixFormation formation;
  Index size = 0;
  mutable std::once_flag formed;
  mutable std::optional<Lcp> lcp;
};

namespace {

/// from = empty, of the same kind. Moving a sparse matrix copies it, swapping does not.
void take(Jacobian& from, Jacobian& to) {
  if (auto* sparse = std::get_if<SparseMatrix>(&from)) {
    to.emplace<SparseMatrix>().swap(*sparse);
  } else {
    to = std::move(from);
  }
}

std::shared_ptr<const ContactProblem> shared(ContactProblem&& from) {
  Jacobian N, D;
  take(from.N, N);
  take(from.D, D);
  const auto to = std::make_shared<ContactProblem>(std::move(from));
  take(N, to->N);
  take(D, to->D);
  return to;
}

}  // namespace

const char* to_string(ProblemKind kind) {
  constexpr std::array kNames{"lcp", "contact", "scene"};
  return kNames[static_cast<std::size_t>(kind)];
}

Problem::Problem(std::string name, Lcp lcp) {
  auto data = std::make_shared<Data>();
  data->name = std::move(name);
  data->size = lcp.size();
  data->lcp = std::move(lcp);
  data_ = std::move(data);
}

Problem::Problem(std::string name, ContactProblem contact, const MatrixFormation& formation)
    : Problem(std::move(name), shared(std::move(contact)), formation) {}

Problem::Problem(std::string name, std::shared_ptr<const ContactProblem> contact, const MatrixFormation& formation) {
  auto data = std::make_shared<Data>();
  data->name = std::move(name);
  data->kind = ProblemKind::kContact;
  data->size = lcp_size(*contact);
  data->formation = formation;
  data->contact = std::move(contact);
  data_ = std::move(data);
}

Problem::Problem(std::string name, RigidScene scene) {
  auto data = std::make_shared<Data>();
  data->name = std::move(name);
  data->kind = ProblemKind::kScene;
  data->contact = shared(contact_problem(scene));
  data->size = lcp_size(*data->contact);
  data->scene = std::move(scene);
  data_ = std::move(data);
}

const std::string& Problem::name() const {
  static const std::string none;
  return data_ ? data_->name : none;
}

ProblemKind Problem::kind() const { return data_ ? data_->kind : ProblemKind::kLcp; }
Index Problem::size() const { return data_->size; }

const Lcp& Problem::lcp() const {
  std::call_once(data_->formed, [this] {
    if (!data_->lcp) data_->lcp = form_lcp(*data_->contact, data_->formation);
  });
  return *data_->lcp;
}

const ContactProblem* Problem::contact() const { return data_->contact.get(); }
const MatrixFormation& Problem::formation() const { return data_->formation; }
const RigidScene* Problem::scene() const { return data_->scene ? &*data_->scene : nullptr; }

Problem Problem::with_engine_answer(EngineAnswer answer) const {
  Problem result = *this;
  result.engine_ = std::make_shared<const EngineAnswer>(std::move(answer));
  return result;
}

}  // namespace lcpbench
