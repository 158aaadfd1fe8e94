// The native module of the Python package: a thin layer over core/, native/, study/evaluation and study/output. What
// users see, with its documentation, is in python/lcpbench.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/answer/cone_friction.h"
#include "core/io/problem_checks.h"
#include "core/registry.h"
#include "core/round_cone.h"
#include "core/timed_solve.h"
#include "native/lcpbench.h"
#include "native/lcpbench_checks.h"
#include "python/src/arrays.h"
#include "python/src/mujoco_step.h"
#include "study/evaluation/evaluation.h"
#include "study/evaluation/friction_model.h"
#include "study/output/explanation.h"
#if LCPBENCH_PYTHON_READERS
#include "python/src/files.h"
#endif

namespace lcpbench::python {
namespace {

/// The mean of the matrix and its transpose where they differ by at most 1e-9 of the largest entry. Else the matrix as
/// it is, so that the check, where it is asked for, names it.
Matrix symmetrized(const Matrix& matrix) {
  constexpr double kRounding = 1e-9;
  if (matrix.rows() != matrix.cols() || matrix.size() == 0) return matrix;
  const Matrix mirrored = matrix.transpose();
  if (!((matrix - mirrored).cwiseAbs().maxCoeff() <= kRounding * matrix.cwiseAbs().maxCoeff())) return matrix;
  return 0.5 * matrix + 0.5 * mirrored;
}

/// @param kind  "G", "G_blocks", "G_factors" or "Ginv": `value` is a matrix, a list of them, or (X, alpha)
Inertia inertia_of(const std::string& kind, const nb::object& value, Index ngc) {
  if (kind == "G") return DenseInertia{symmetrized(matrix(value, "G", ngc, ngc))};
  if (kind == "Ginv") return InverseInertia{symmetrized(matrix(value, "Ginv", ngc, ngc))};
  if (kind == "G_factors") {
    const Vector alpha = vector(value[1], "G_factors[1]");
    return FactoredInertia{matrix(value[0], "G_factors[0]", ngc, alpha.size()), alpha};
  }
  BlockInertia inertia;
  Index size = 0;
  for (const nb::handle each : value) {
    const std::string name = "G[" + std::to_string(inertia.blocks.size()) + "]";
    const Matrix block = matrix(each, name);
    inertia.blocks.push_back(symmetrized(matrix(each, name, block.rows(), block.rows())));
    size += block.rows();
  }
  if (size != ngc) {
    throw InputError("G: the blocks have " + std::to_string(size) + " rows together, expected " + std::to_string(ngc));
  }
  return inertia;
}

/// @param rows  as _bounded_rows() of _problem.py makes them
BoundedRows bounded_rows(const nb::dict& rows, Index ngc) {
  BoundedRows result;
  const Vector lower = vector(rows["lower"], "rows.lower");
  const auto each = [&](const char* field) {
    return vector(rows[field], std::string("rows.") + field, lower.size());
  };
  const auto optional = [&](const char* field) {
    Vector values = each(field);
    if (values.isZero(0)) values.resize(0);
    return values;
  };
  result.R = jacobian(rows["R"], "rows.R", ngc, lower.size());
  result.bounds = {lower, each("upper"), nb::cast<std::vector<int>>(rows["friction_of"]), each("mu")};
  result.bounds.drop_huge();
  result.b = optional("b");
  result.compliance = optional("compliance");
  for (const nb::handle is_angle : rows["unit"]) result.is_angle.push_back(nb::cast<bool>(is_angle) ? 1 : 0);
  result.names = nb::cast<std::vector<std::string>>(rows["names"]);
  return result;
}

Problem contacts(const nb::object& v, const nb::object& N, const nb::object& D, const std::vector<int>& edges,
                 const nb::object& mu, const nb::object& b, const nb::object& compliance_n,
                 const nb::object& compliance_t, const nb::object& offset_t, const nb::object& rows,
                 const std::string& kind,
                 const nb::object& inertia, const std::string& name, bool check) {
  ContactProblem problem;
  problem.v = vector(v, "v");
  const auto nc = static_cast<Index>(edges.size());
  Index friction = 0;
  for (const int each : edges) friction += each;
  problem.edges = edges;
  problem.N = jacobian(N, "N", problem.ngc(), nc);
  problem.D = D.is_none() ? Jacobian(Matrix(problem.ngc(), friction)) : jacobian(D, "D", problem.ngc(), friction);
  problem.mu = vector(mu, "mu", nc);
  const auto optional = [](const nb::object& value, const char* field, Index size) {
    Vector result = value.is_none() ? Vector() : vector(value, field, size);
    if (result.isZero(0)) result.resize(0);
    return result;
  };
  problem.b = optional(b, "b", nc);
  problem.compliance_n = optional(compliance_n, "compliance_n", nc);
  problem.compliance_t = optional(compliance_t, "compliance_t", nc);
  problem.offset_t = optional(offset_t, "offset_t", 2 * nc);
  problem.inertia = inertia_of(kind, inertia, problem.ngc());
  if (!rows.is_none()) problem.rows = bounded_rows(nb::borrow<nb::dict>(rows), problem.ngc());
  check ? check_contact(problem, "Problem") : check_usable(problem);
  return {name, std::move(problem)};
}

/// @param lower,upper,friction_of,mu  n entries each, or none
Problem bare(const nb::object& M, const nb::object& q, const nb::object& lower, const nb::object& upper,
             const std::vector<int>& friction_of, const nb::object& mu, const std::string& name) {
  Lcp lcp;
  lcp.q = vector(q, "q");
  lcp.M = matrix(M, "M", lcp.q.size(), lcp.q.size());
  lcp.bounds = {vector(lower, "lower"), vector(upper, "upper"), friction_of, vector(mu, "mu")};
  check_lcp(lcp, "Problem");
  lcp.dropped_bounds = lcp.bounds.drop_huge();
  if (lcp.is_mixed()) lcp.bounds.simplify();
  return {name, std::move(lcp)};
}

LcpBounds bounds_of(const Problem& problem) {
  if (problem.contact() != nullptr) throw InputError("problem: has contacts, expected an LCP");
  return problem.lcp().is_mixed() ? problem.lcp().bounds : LcpBounds::nonnegative(problem.size());
}

Problem scene(const nb::list& bodies, const nb::list& contacts, const std::string& name) {
  RigidScene result;
  nb::dict part;
  std::string at;
  const auto three = [&](const char* field) { return Eigen::Vector3d(vector(part[field], at + field, 3)); };
  for (const nb::handle item : bodies) {
    part = nb::borrow<nb::dict>(item);
    at = "bodies[" + std::to_string(result.bodies.size()) + "].";
    RigidBody body;
    body.mass = nb::cast<double>(part["mass"]);
    body.inertia = symmetrized(matrix(part["inertia"], at + "inertia", 3, 3));
    body.position = three("position");
    body.linear_velocity = three("linear_velocity");
    body.angular_velocity = three("angular_velocity");
    result.bodies.push_back(body);
  }
  for (const nb::handle item : contacts) {
    part = nb::borrow<nb::dict>(item);
    at = "contacts[" + std::to_string(result.contacts.size()) + "].";
    RigidContact contact;
    contact.body_a = nb::cast<int>(part["body_a"]);
    contact.body_b = nb::cast<int>(part["body_b"]);
    contact.point = three("point");
    contact.normal = three("normal");
    contact.tangent = three("tangent");
    contact.mu = nb::cast<double>(part["mu"]);
    contact.edges = nb::cast<int>(part["edges"]);
    contact.b = nb::cast<double>(part["b"]);
    contact.compliance_n = nb::cast<double>(part["compliance_n"]);
    contact.compliance_t = nb::cast<double>(part["compliance_t"]);
    contact.offset_t = vector(part["offset_t"], at + "offset_t", 2);
    result.contacts.push_back(contact);
  }
  check_scene(result, "Problem");
  return {name, std::move(result)};
}

const ContactProblem& contact_of(const Problem& problem) {
  if (problem.contact() == nullptr) throw InputError("problem: is a bare LCP, expected one with contacts");
  return *problem.contact();
}

/// An optional field, `each` numbers for a contact.
Vector or_zeros(const Problem& problem, Vector ContactProblem::* field, Index each) {
  const ContactProblem& contact = contact_of(problem);
  return (contact.*field).size() > 0 ? contact.*field : Vector(Vector::Zero(each * contact.nc()));
}

/// As Problem takes them.
nb::object row_fields(const BoundedRows& rows) {
  if (rows.size() == 0) return nb::none();
  const auto all = [&](const Vector& values) {
    return nb::cast(values.size() > 0 ? values : Vector(Vector::Zero(rows.size())));
  };
  nb::dict fields;
  fields["R"] = nb::cast(rows.R);
  fields["lower"] = nb::cast(rows.bounds.lower);
  fields["upper"] = nb::cast(rows.bounds.upper);
  fields["b"] = all(rows.b);
  fields["compliance"] = all(rows.compliance);
  fields["friction_of"] = nb::cast(rows.bounds.friction_of);
  fields["mu"] = nb::cast(rows.bounds.mu);
  nb::list units;
  for (const char is_angle : rows.is_angle) units.append(is_angle != 0 ? "rad" : "m");
  fields["unit"] = units;
  fields["names"] = rows.names.empty() ? nb::none() : nb::cast(rows.names);
  return fields;
}

/// The rows before those of contacts in MuJoCo's own convex problem, and their impulses.
nb::tuple mujoco_soft_rows(const Numbers& efc_J, const nb::tuple& rows_of, const nb::tuple& efc, const Vector& target,
                           double h, Index nv, const MujocoRowNames& names) {
  capture::MujocoBoundedRows found = capture::soft_rows(MujocoRows(efc_J, nv, rows_of, efc).all, names, target, h);
  return nb::make_tuple(row_fields(found.rows), array(found.impulses));
}

nb::object inertia_object(const Problem& problem) {
  const Inertia& inertia = contact_of(problem).inertia;
  if (const auto* blocks = std::get_if<BlockInertia>(&inertia)) return nb::cast(blocks->blocks);
  const Matrix G = dense_inertia(inertia);
  return G.size() > 0 || problem.contact()->ngc() == 0 ? nb::cast(G) : nb::none();
}

std::optional<Matrix> points(const Problem& problem) {
  if (problem.scene() == nullptr) return std::nullopt;
  Matrix result(problem.contact()->nc(), 3);
  for (Index i = 0; i < result.rows(); ++i) {
    result.row(i) = problem.scene()->contacts[static_cast<std::size_t>(i)].point.transpose();
  }
  return result;
}

nb::object or_none(const Vector& values) { return values.size() > 0 ? array(values) : nb::none(); }

/// What a solve gave, as Python takes it apart.
nb::tuple answer_tuple(const TimedAnswer& timed) {
  const Answer& answer = timed.answer;
  return nb::make_tuple(to_string(answer.claim), array(answer.z), or_none(answer.velocity), or_none(answer.farkas),
                        answer.counters.iterations, answer.counters.pivots, answer.counters.factorizations,
                        answer.detail, timed.times.setup_cpu_s, timed.times.solve_cpu_s, to_string(answer.impulses));
}

/// Ends solves when Python has a signal whose handler raises, Ctrl-C above all. To be made with Python's lock, which
/// those that ask do not have.
class Interrupt {
 public:
  bool raised() const { return raised_; }
  /// Asks Python, at most every 50 ms. By the thread that was called alone.
  bool ask() {
    const auto now = std::chrono::steady_clock::now();
    if (raised_ || now - asked_ < std::chrono::milliseconds(50)) return raised_;
    asked_ = now;
    const nb::gil_scoped_acquire held;
    if (PyErr_CheckSignals() == 0) return false;
    error_ = std::make_exception_ptr(nb::python_error());
    return raised_ = true;
  }
  /// With Python's lock again.
  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }
  /// With an infinite limit solvers do not read the clock.
  static double limit(double time_limit_s) { return std::min(time_limit_s, 1e9); }

 private:
  std::chrono::steady_clock::time_point asked_ = std::chrono::steady_clock::now();
  std::atomic<bool> raised_ = false;
  std::exception_ptr error_;
};

/// Threads take the next problem each; every problem has a solver of its own, so that the order leaves no trace.
nb::list solve(const std::vector<Problem>& problems, const std::string& solver, const std::vector<nb::object>& starts,
               double time_limit_s, int threads) {
  const Spec spec = parse_spec(solver);
  if (!find_solver(spec.name).native()) throw InputError("solver: '" + spec.name + "' is no native solver");
  make_solver(spec);  // refuses wrong settings
  std::vector<std::optional<Vector>> start_of(problems.size());
  for (std::size_t i = 0; i < problems.size(); ++i) {
    if (!starts[i].is_none()) start_of[i] = vector(starts[i], "start", problems[i].size());
  }
  std::vector<TimedAnswer> answers(problems.size());
  std::vector<std::exception_ptr> errors(problems.size());
  std::atomic<std::size_t> next{0};
  std::atomic<int> running{0};
  Interrupt interrupt;
  const auto work = [&](const std::function<bool()>& stop) {
    const StopCheck check(stop);
    for (std::size_t i = next++; i < problems.size() && !stop(); i = next++) {
      try {
        const TimedRequest request{.time_limit_s = Interrupt::limit(time_limit_s),
                                   .start = start_of[i] ? &*start_of[i] : nullptr};
        timed_solve(*make_solver(spec), problems[i], request, answers[i]);
      } catch (...) {
        errors[i] = std::current_exception();
      }
    }
  };
  {
    const nb::gil_scoped_release released;
    std::vector<std::jthread> pool;
    for (int k = 1; k < threads && static_cast<std::size_t>(k) < problems.size(); ++k) {
      ++running;
      pool.emplace_back([&] {
        work([&] { return interrupt.raised(); });
        --running;
      });
    }
    work([&] { return interrupt.ask(); });
    while (running > 0 && !interrupt.ask()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  interrupt.rethrow();
  nb::list result;
  for (std::size_t i = 0; i < problems.size(); ++i) {
    if (errors[i]) std::rethrow_exception(errors[i]);
    result.append(answer_tuple(answers[i]));
  }
  return result;
}

FrictionModel model_of(const std::string& name) {
  const FrictionModel model = friction_model_of(name);
  if (name == to_string(model)) return model;
  throw InputError("model is '" + name + "', expected 'pyramid', 'cone' or 'convex'");
}

/// Takes z, and what contact_impulses() takes.
/// @throws InputError also where the model of friction is not defined for the problem
Vector complete_answer(const Problem& problem, const nb::object& value, const std::string& model,
                       const nb::object& row_impulses) {
  const FrictionModel friction = friction_model(model_of(model), problem);
  const Array given = numbers(value, "impulses");
  const Index n = problem.size();
  if (problem.contact() == nullptr) return vector(value, "impulses", n);
  const ContactProblem& contact = *problem.contact();
  const std::string no_cone = friction == FrictionModel::kPyramid ? "" : why_no_cone(contact);
  if (!no_cone.empty()) throw InputError("model '" + model + "': " + no_cone);
  if (given.ndim() == 1 && length(given, 0) == n && row_impulses.is_none()) return vector(value, "impulses");
  const std::string more = "(" + std::to_string(n) + ",) for z, ";
  return complete_impulses(contact, contact_impulses(contact, value, row_impulses, more));
}

/// The fields of Python's Verdict. @param solved_at  the verdict's bound; 0: that of the problem's kind
nb::tuple judge(const Problem& problem, const std::string& claim, const Vector& z, const nb::object& velocity,
                const nb::object& farkas, const std::string& model, const std::string& detail,
                const std::vector<std::string>& contact_names, double solved_at) {
  Answer answer;
  answer.claim = parse_claim(claim);
  answer.z = z;
  answer.detail = detail;
  if (!velocity.is_none()) answer.velocity = vector(velocity, "velocity", contact_of(problem).ngc());
  if (!farkas.is_none()) answer.farkas = vector(farkas, "farkas");
  const FrictionModel friction = friction_model(model_of(model), problem);
  JudgedAnswer judged{.claim = answer.claim, .detail = detail, .contact_names = contact_names};
  Truth truth = Truth::kUnknown;
  {
    const nb::gil_scoped_release released;
    Evaluator evaluator(problem);
    Judgement judgement = evaluator.judge(answer);
    if (friction != FrictionModel::kPyramid) measure_friction(friction, problem, answer, judgement.errors);
    if (solved_at > 0) judgement.errors.decide(solved_at);
    if (friction == FrictionModel::kPyramid) {
      Findings findings;
      findings.add(judgement);
      if (evaluator.truth() == Truth::kSolvable) findings.add(Evidence::kTheory);
      truth = findings.truth();
    }
    judged.errors = judgement.errors;
  }
  judged.verdict = verdict(answer.claim, judged.errors, truth);
  judged.truth = truth;
  judged.model = friction;
  nb::dict errors;
  for (const Metric& metric : kMetrics) errors[metric.name] = judged.errors.*metric.value;
  std::string why;
#if LCPBENCH_PYTHON_READERS
  judged.unusable = why_without_errors(answer, problem.size());
  judged.truth_because = truth == Truth::kSolvable ? "by theory" : "its proof is valid";
  why = why_not_solved(problem, judged);
#else
  if (judged.verdict != Verdict::kSolved) why = "the worst row of z is " + std::to_string(judged.errors.worst.row);
#endif
  return nb::make_tuple(to_string(judged.verdict), judged.errors.measure(), why, judged.errors.worst.row,
                        to_string(friction), to_string(truth), errors);
}

std::vector<ContactId> ids_of(const nb::object& ids) {
  std::vector<ContactId> result;
  if (ids.is_none()) return result;
  if (!nb::isinstance<nb::iterable>(ids)) throw nb::type_error("ids: expected one for each contact");
  for (const nb::handle each : ids) {
    std::string text;
    if (nb::try_cast(each, text)) {
      result.push_back(contact_id(text));
    } else if (!nb::try_cast(each, result.emplace_back())) {
      nb::raise_type_error("ids[%zu]: expected a text or an integer from 0 to 2^64 - 1", result.size() - 1);
    }
  }
  check_distinct(result, "ids");
  return result;
}

/// A ContactSolver and what it solves now.
class StepSolver {
 public:
  explicit StepSolver(const std::string& spec) : solver_(spec) {}
  void take(const Problem& next, const nb::object& ids, bool follows) {
    const Use use(*this);
    const std::vector<ContactId> names = ids_of(ids);
    const ContactProblem& contact = contact_of(next);
    if (follows && names.empty() && contact.nc() > 0) {
      throw InputError("0 ids for " + std::to_string(contact.nc()) + " contacts");
    }
    const nb::gil_scoped_release released;
    if (next.scene() != nullptr) {
      follows ? solver_.update(*next.scene(), names) : solver_.load(*next.scene(), names);
    } else {
      follows ? solver_.update(contact, names) : solver_.load(contact, names);
    }
    problem_ = next;
    v_.resize(0);
  }
  void set_velocity(const nb::object& velocity) {
    const Use use(*this);
    Vector next = vector(velocity, "v");
    solver_.set_velocity(next);
    v_ = std::move(next);
  }
  const char* solve(double time_limit_s) {
    const Use use(*this);
    Interrupt interrupt;
    Claim claim = Claim::kNumericalFailure;
    {
      const nb::gil_scoped_release released;
      const StopCheck check([&] { return interrupt.ask(); });
      claim = solver_.solve(Interrupt::limit(time_limit_s));
    }
    interrupt.rethrow();
    return to_string(claim);
  }
  nb::object velocity() {
    const Use use(*this);
    return array(solver_.velocity());
  }
  const Answer& answer() {
    const Use use(*this);
    return solver_.answer();
  }
  Problem current() {
    const Use use(*this);
    if (problem_.contact() == nullptr) throw std::logic_error("ContactSolver: nothing was loaded");
    if (v_.size() == 0) return problem_;
    ContactProblem moving = *problem_.contact();
    moving.v = v_;
    return {problem_.name(), std::move(moving)};
  }

 private:
  /// Refuses a second thread, which would find the solver in the middle of its work. Python's lock is held.
  class Use {
   public:
    explicit Use(StepSolver& solver) : solver_(solver) {
      if (solver.in_use_)
        throw std::runtime_error("ContactSolver: another thread uses it now; give each thread its own");
      solver.in_use_ = true;
    }
    ~Use() { solver_.in_use_ = false; }
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;

   private:
    StepSolver& solver_;
  };

  ContactSolver solver_;
  Problem problem_{"", Lcp{}};
  Vector v_;  ///< empty: that of the problem
  bool in_use_ = false;
};

/// The fields of Python's Solver.
nb::list solver_list() {
  nb::list result;
  for (const RegisteredSolver& solver : registered_solvers()) {
    const SolverDefinition& definition = solver.definition;
    nb::dict settings;
    for (const SettingInfo& each : definition.settings()) settings[each.name.c_str()] = each.default_value;
    const Capabilities& can = definition.capabilities;
    result.append(nb::make_tuple(definition.name, definition.summary,
                                 !can.frictionless_only || *can.friction_setting != '\0', "native", "", settings));
  }
  return result;
}

}  // namespace

void define(nb::module_& module) {
  using namespace nb::literals;
  module.attr("__version__") = LCPBENCH_VERSION;
  nb::set_leak_warnings(false);  // Python drops what daemon threads hold when it ends: nanobind would blame this module
  nb::exception<InputError>(module, "InputError", PyExc_ValueError);
  nb::class_<Problem>(module, "Problem")
      .def_prop_ro("name", [](const Problem& p) { return p.name(); })
      .def_prop_ro("kind", [](const Problem& p) { return std::string(to_string(p.kind())); })
      .def_prop_ro("size", [](const Problem& p) { return p.size(); })
      .def_prop_ro("q", [](const Problem& p) { return p.lcp().q; })
      .def_prop_ro("M", [](const Problem& p) { return p.lcp().M; })
      .def_prop_ro("v", [](const Problem& p) { return contact_of(p).v; })
      .def_prop_ro("lower", [](const Problem& p) { return bounds_of(p).lower; })
      .def_prop_ro("upper", [](const Problem& p) { return bounds_of(p).upper; })
      .def_prop_ro("friction_of", [](const Problem& p) { return bounds_of(p).friction_of; })
      .def_prop_ro("mu", [](const Problem& p) { return p.contact() != nullptr ? p.contact()->mu : bounds_of(p).mu; })
      .def_prop_ro("b", [](const Problem& p) { return or_zeros(p, &ContactProblem::b, 1); })
      .def_prop_ro("compliance_n", [](const Problem& p) { return or_zeros(p, &ContactProblem::compliance_n, 1); })
      .def_prop_ro("compliance_t", [](const Problem& p) { return or_zeros(p, &ContactProblem::compliance_t, 1); })
      .def_prop_ro("offset_t", [](const Problem& p) { return or_zeros(p, &ContactProblem::offset_t, 2); })
      .def_prop_ro("edges", [](const Problem& p) { return contact_of(p).edges; })
      .def_prop_ro("N", [](const Problem& p) { return contact_of(p).N; })
      .def_prop_ro("D", [](const Problem& p) { return contact_of(p).D; })
      .def_prop_ro("rows", [](const Problem& p) { return row_fields(contact_of(p).rows); })
      .def_prop_ro("row_count", [](const Problem& p) { return contact_of(p).rows.size(); })
      .def_prop_ro("G", &inertia_object)
      .def_prop_ro("Ginv", [](const Problem& p) { return inverse_inertia(contact_of(p).inertia); })
      .def_prop_ro("points", &points)
      .def("velocity", [](const Problem& p, const Vector& z) { return post_impact_velocity(contact_of(p), z); });
  module.def("contacts", &contacts, "v"_a, "N"_a, "D"_a.none(), "edges"_a, "mu"_a, "b"_a.none(),
             "compliance_n"_a.none(), "compliance_t"_a.none(), "offset_t"_a.none(), "rows"_a.none(), "kind"_a,
             "inertia"_a, "name"_a, "check"_a);
  module.def("bare", &bare);
  module.def("scene", &scene);
  module.def("solve", &solve);
  nb::class_<MujocoRowNames>(module, "MujocoRowNames");
  module.def("mujoco_row_names", &mujoco_row_names, "names"_a, "model"_a);
  module.def("mujoco_step", &mujoco_step, "efc_J"_a, "rows"_a, "efc"_a, "contact"_a, "pyramidal"_a, "G"_a, "qvel"_a,
             "h"_a, "names"_a, "name"_a);
  module.def("mujoco_soft_rows", &mujoco_soft_rows, "efc_J"_a, "rows"_a, "efc"_a, "target"_a, "h"_a, "nv"_a, "names"_a);
  module.def("complete_answer", &complete_answer, "problem"_a, "impulses"_a.none(), "model"_a,
             "row_impulses"_a = nb::none());
  module.def("judge", &judge, "problem"_a, "claim"_a, "z"_a, "velocity"_a.none(), "farkas"_a.none(), "model"_a,
             "detail"_a, "contact_names"_a, "solved_at"_a);
  module.def("why_no_round_cone", [](const Problem& problem) {
    return problem.contact() != nullptr ? why_no_round_cone(*problem.contact()) : std::string();
  });
  module.def("solvers", &solver_list);
  module.def("friction_of", [](const std::string& solver) {
    const Spec spec = parse_spec(solver);
    return to_string(find_solver(spec.name).definition.friction(spec.options));
  });
  module.def("canonical", [](const std::string& solver) { return canonical_solver_spec(parse_spec(solver)).text(); });
  nb::class_<StepSolver>(module, "ContactSolver")
      .def(nb::init<const std::string&>())
      .def("_take", &StepSolver::take, "problem"_a, "ids"_a.none(), "follows"_a)
      .def("set_velocity", &StepSolver::set_velocity, "v"_a.none())
      .def("solve", &StepSolver::solve)
      .def("_current", &StepSolver::current)
      .def_prop_ro("claim", [](StepSolver& s) { return to_string(s.answer().claim); })
      .def_prop_ro("velocity", &StepSolver::velocity, nb::sig("def velocity(self) -> numpy.ndarray"))
      .def_prop_ro(
          "z", [](StepSolver& s) { return array(s.answer().z); }, nb::sig("def z(self) -> numpy.ndarray"))
      .def_prop_ro("_own_velocity", [](StepSolver& s) { return or_none(s.answer().velocity); })
      .def_prop_ro("_farkas", [](StepSolver& s) { return or_none(s.answer().farkas); })
      .def_prop_ro("which_impulses", [](StepSolver& s) { return to_string(s.answer().impulses); })
      .def_prop_ro("detail", [](StepSolver& s) { return s.answer().detail; });
  module.attr("has_readers") = LCPBENCH_PYTHON_READERS != 0;
#if LCPBENCH_PYTHON_READERS
  define_files(module);
#endif
}

}  // namespace lcpbench::python

NB_MODULE(_native, module) { lcpbench::python::define(module); }
