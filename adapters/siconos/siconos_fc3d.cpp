// Siconos's solvers of contacts with the round friction cone, fc3d_driver: the reference for the error of the pyramid.
#include "adapters/round_cone.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include <cstdio>

extern "C" {
#include <FrictionContactProblem.h>
#include <Friction_cst.h>
#include <GlobalFrictionContactProblem.h>
}

#include "adapters/siconos/siconos_common.h"
#endif

namespace lcpbench {
namespace {

enum class Fc3dMethod { kNsgs, kNsnAc, kAdmm, kIpm };

struct SiconosFc3dSettings {
  static constexpr Capabilities capabilities{
      .frictionless_only = true,
      .friction_setting = "cone=true",
      .guarantees = "none; without friction, the method nsgs converges for symmetric positive definite M",
      .warm_start = true};

  bool cone = false;
  Fc3dMethod method = Fc3dMethod::kNsgs;
  double tolerance = 1e-10;
  std::int64_t max_iterations = 10000;

  void visit(auto&& field) {
    field("cone", cone, kConeHelp);
    field("method", method,
          Choices<Fc3dMethod>{{{"nsgs", Fc3dMethod::kNsgs},
                               {"nsn_ac", Fc3dMethod::kNsnAc},
                               {"admm", Fc3dMethod::kAdmm},
                               {"ipm", Fc3dMethod::kIpm}}},
          "nonsmooth Gauss-Seidel, the nonsmooth Newton method on Alart and Curnier's function, ADMM, or the interior "
          "point of global problems, which solves the convex relaxation and is judged by it");
    field("tolerance", tolerance, RealRange{.min = 0.0, .max = 1.0},
          "on Siconos's error, relative to |q|; Siconos's defaults: 1e-4 for nsgs, 1e-3 for nsn_ac, 1e-6 for admm, "
          "1e-10 for ipm");
    field("max_iterations", max_iterations, IntegerRange{.min = 1, .max = 1000000000},
          "sweeps or steps at most; Siconos's defaults: 1000, 200, 20000 and 1000");
  }
  FrictionModel friction_model() const {
    if (!cone) return FrictionModel::kPyramid;
    return method == Fc3dMethod::kIpm ? FrictionModel::kConvex : FrictionModel::kCone;
  }
};

class SiconosFc3d;

#ifndef LCPBENCH_DESCRIBE_ONLY

class SiconosFc3d final : public RoundConeAdapter<SiconosFc3dSettings> {
 public:
  using RoundConeAdapter::RoundConeAdapter;

 private:
  std::string take(const Problem& problem) override {
    std::string refusal = cones_.load(problem, RoundCones::Frictionless::kThreeRows);
    if (!refusal.empty()) return refusal;
    if (settings_.method == Fc3dMethod::kIpm) return take_global(problem);
    return settings_.method == Fc3dMethod::kNsgs ? why_not_nsgs() : "";
  }

  /// M v = H r + f, u = H'v + w, sparse. A contact without friction has tangents that move nothing.
  std::string take_global(const Problem& problem) {
    const ContactProblem* contact = problem.contact();
    if (contact == nullptr || std::holds_alternative<InverseInertia>(contact->inertia)) {
      return "method=ipm needs contacts with the inertia itself, not its inverse";
    }
    const Index coordinates = contact->ngc(), rows = cones_.q().size();
    M_.reset(siconos_sparse(coordinates, coordinates));
    H_.reset(siconos_sparse(coordinates, rows));
    f_.setZero(coordinates);
    w_.setZero(rows);
    const auto add_block = [&](const Matrix& block, Index first) {
      f_.segment(first, block.rows()) = block * contact->v.segment(first, block.rows());
      add_entries(block, first, first, *M_);
    };
    if (std::holds_alternative<BlockInertia>(contact->inertia)) {
      for_each_matrix(contact->inertia, add_block);
    } else {
      add_block(dense_inertia(contact->inertia), 0);
    }
    const Matrix N = to_dense(contact->N), D = to_dense(contact->D);
    const ContactLayout layout = contact_layout(*contact);
    for (Index i = 0; i < layout.nc; ++i) {
      const Index row = cones_.normal_row(i);
      add_entries(N.col(i), 0, row, *H_);
      w_(row) = contact->offset(i);
      if (!cones_.has_tangents(i)) continue;
      const auto at = static_cast<std::size_t>(i);
      for (int k = 0; k < 2; ++k) {
        add_entries(D.col(layout.friction_begin[at] + k * contact->edges[at] / 4), 0, row + 1 + k, *H_);
        w_(row + 1 + k) = contact->tangential_offset(i, k);
      }
    }
    return {};
  }

  static void add_entries(const Matrix& block, Index first_row, Index first_column, NumericsMatrix& to) {
    for (Index j = 0; j < block.cols(); ++j) {
      for (Index i = 0; i < block.rows(); ++i) {
        if (block(i, j) == 0) continue;
        NM_entry(&to, static_cast<int>(first_row + i), static_cast<int>(first_column + j), block(i, j));
      }
    }
  }

  /// An assertion of Siconos ends the process at such a contact. @returns "" where there is none
  std::string why_not_nsgs() const {
    for (Index i = 0; i < cones_.contacts(); ++i) {
      const Index row = cones_.normal_row(i);
      if (cones_.W()(row, row) > 0) continue;
      return "contact " + std::to_string(i) +
             ": its normal impulse does not raise its normal velocity (W_NN <= 0), by which nsgs divides; "
             "method=nsn_ac takes it";
    }
    return {};
  }

  void call(const SolveRequest& request, Answer& answer) override {
    // The interface takes pointers to data that may change.
    Matrix W = cones_.W();
    Vector q = cones_.q();
    Vector mu(cones_.contacts());
    const bool global = settings_.method == Fc3dMethod::kIpm;  // which divides by mu
    for (Index i = 0; i < mu.size(); ++i) mu(i) = global && !cones_.has_tangents(i) ? 1 : cones_.mu(i);
    Vector r = request.start != nullptr ? cones_.read(*request.start) : Vector::Zero(q.size());
    Vector u = Vector::Zero(q.size());
    const auto view = siconos_view(W);
    FrictionContactProblem problem{3, static_cast<int>(cones_.contacts()), view.get(), q.data(), mu.data()};
    const int method = global                                   ? SICONOS_GLOBAL_FRICTION_3D_IPM
                       : settings_.method == Fc3dMethod::kNsgs  ? SICONOS_FRICTION_3D_NSGS
                       : settings_.method == Fc3dMethod::kNsnAc ? SICONOS_FRICTION_3D_NSN_AC
                                                                : SICONOS_FRICTION_3D_ADMM;
    const auto options = siconos_options(method, settings_.tolerance, settings_.max_iterations);
    GlobalFrictionContactProblem whole{
        3,      problem.numberOfContacts, M_.get(), H_.get(), f_.data(), f_.norm(), w_.data(), w_.norm(), mu.data(),
        nullptr};
    Vector v = Vector::Zero(f_.size());
    const int info = global ? gfc3d_driver(&whole, r.data(), u.data(), v.data(), options.get())
                            : fc3d_driver(&problem, r.data(), u.data(), options.get());
    answer.counters.iterations = options->iparam[SICONOS_IPARAM_ITER_DONE];
    answer.claim = siconos_claim(info, answer.counters.iterations, settings_.max_iterations);
    cones_.write(r, answer.z);
    answer.detail = detail(info, options->dparam[SICONOS_DPARAM_RESIDU]);
  }

  std::string detail(int info, double error) const {
    char text[160];
    std::snprintf(text, sizeof text, "%sSiconos info %d, error %.1e",
                  cones_.frictional() ? "another problem: the round friction cone; " : "", info, error);
    return text;
  }

  std::unique_ptr<NumericsMatrix, FreeMatrix> M_, H_;  // of the global problem
  Vector f_, w_;
};

#endif

}  // namespace

SolverDefinition lcpbench_solver_siconos_fc3d() {
  return define_adapter<SiconosFc3d, SiconosFc3dSettings>(
      {.name = "siconos_fc3d",
       .summary = "Siconos's contact solvers (fc3d_driver), with the round friction cone if cone=true",
       .source =
           "Siconos, numerics/src/FrictionContact; Acary, Bremond, Huber 2018, Advanced Topics in Nonsmooth Dynamics"});
}

}  // namespace lcpbench
