#include "adapters/external/model_engine.h"

#include <filesystem>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "adapters/external/asked_engine.h"
#include "core/error.h"
#include "core/io/json_document.h"
#include "core/io/problem_io.h"

namespace lcpbench::capture {
namespace {

std::vector<double> numbers(const Eigen::VectorXd& v) { return {v.begin(), v.end()}; }

Eigen::VectorXd column(const Jacobian& J, Index i) {
  return std::visit([&](const auto& matrix) { return Eigen::VectorXd(matrix.col(i)); }, J);
}

std::vector<int> all_coordinates(Index count) {
  std::vector<int> result(static_cast<std::size_t>(count));
  std::iota(result.begin(), result.end(), 0);
  return result;
}

/// The columns of N and D of a contact.
Rows rows_of(const ContactProblem& problem, Index contact, Index direction) {
  Rows rows;
  rows.normal = column(problem.N, contact);
  rows.coordinates = all_coordinates(rows.normal.size());
  if (problem.edges[static_cast<std::size_t>(contact)] == 0) return rows;
  rows.tangent = column(problem.D, direction);
  rows.second_tangent = column(problem.D, direction + 1);
  return rows;
}

class ModelEngine final : public AskedEngine {
 public:
  ModelEngine(const Scene& scene, const std::string& model)
      : AskedEngine(scene, "model") {
    try {
      const Json answer = ask({{"verb", "model"},
                               {"file", std::filesystem::absolute(model).string()},
                               {"soft", scene_.soft},
                               {"marks", scene_.marks}});
      const JsonObject told(answer, origin());
      told.only({"engine", "version", "step_length", "gravity", "shapes", "free"});
      name_ = told.text("engine");
      version_ = told.text("version");
      step_length_ = told.number("step_length");
      gravity_ = told.vector("gravity", 3);
      for (const JsonObject& shape : told.objects("shapes")) {
        const Vector size = shape.vector("size");
        drawn_.push_back({shape.text("type"), {size.begin(), size.end()}});
      }
      const int free = told.integer("free");
      for (int i = 0; i < free && scene_.marks.empty(); ++i) scene_.stands.push_back(i);
    } catch (const std::runtime_error& error) {
      throw InputError("model '" + model + "': " + error.what());
    }
  }

  double step_length() const override { return step_length_; }
  Eigen::Vector3d gravity() const override { return gravity_; }
  std::vector<Drawn> drawn() const override { return drawn_; }

 private:
  void take(long index, Snapshot& snapshot, const VelocitySolver& loop) override {
    const Json answer = ask({{"verb", "step"}, {"loop", static_cast<bool>(loop)}});
    const JsonObject told(answer, origin());
    told.only({"problem", "gap", "ids", "poses", "marks", "impulses", "row_impulses", "velocity", "solve_s", "frames",
               "notes"});
    const Problem problem = problem_of_json(told.value("problem"), origin());
    if (problem.contact() == nullptr || problem.kind() != ProblemKind::kContact) {
      told.fail("problem", ": expected one of kind contact");
    }
    add_blocks(*problem.contact(), told, snapshot);
    add_contacts(*problem.contact(), told, snapshot);
    add_rows(problem.contact()->rows, told, snapshot);
    for (const Vector& pose : told.rows("poses")) {
      if (pose.size() != 7) told.fail("poses", ": expected 7 numbers each");
      snapshot.poses.push_back({pose.head<3>(), Eigen::Quaterniond(pose(3), pose(4), pose(5), pose(6))});
    }
    const std::vector<Vector> marks = told.rows("marks");
    const std::size_t expected = scene_.marks.empty() ? scene_.stands.size() : scene_.marks.size();
    if (snapshot.poses.size() != drawn_.size()) told.fail("poses", ": expected one for each shape");
    if (marks.size() != expected) told.fail("marks", ": expected one for each name");
    for (const Vector& place : marks) {
      if (place.size() != 3) told.fail("marks", ": expected 3 numbers each");
      snapshot.marks.emplace_back(place);
    }
    if (told.given("notes")) snapshot.notes = told.texts("notes");
    take_solve_time(told, snapshot);
    if (!loop) {
      snapshot.velocity_after = told.vector("velocity", problem.contact()->ngc());
      return;
    }
    const Eigen::VectorXd velocity = loop(snapshot);
    const Json placed = ask({{"verb", "place"},
                             {"velocity", numbers(velocity)},
                             {"moving", numbers(moving_velocity(velocity, snapshot, step_length_))}});
    JsonObject(placed, origin()).only({});
  }

  static void add_blocks(const ContactProblem& problem, const JsonObject& told, Snapshot& snapshot) {
    const auto* blocks = std::get_if<BlockInertia>(&problem.inertia);
    const auto* one = std::get_if<DenseInertia>(&problem.inertia);
    if (one != nullptr) snapshot.blocks.push_back({one->G, problem.v});
    if (one != nullptr) return;
    if (blocks == nullptr) told.fail("problem", ": expected G or G_blocks");
    Index at = 0;
    for (const Matrix& block : blocks->blocks) {
      snapshot.blocks.push_back({block, problem.v.segment(at, block.rows())});
      at += block.rows();
    }
  }

  static void add_contacts(const ContactProblem& problem, const JsonObject& told, Snapshot& snapshot) {
    const auto value = [](const Vector& values, Index i) { return values.size() > 0 ? values(i) : 0.0; };
    const ContactLayout layout = contact_layout(problem);
    const Vector gap = told.vector("gap", problem.nc());
    const std::vector<std::string> ids = told.texts("ids");
    const std::vector<Vector> impulses = told.given("impulses") ? told.rows("impulses") : std::vector<Vector>();
    const auto count = static_cast<std::size_t>(problem.nc());
    const std::vector<Vector> frames = told.given("frames") ? told.rows("frames") : std::vector<Vector>(count);
    snapshot.has_impulses = told.given("impulses");
    if (ids.size() != count) told.fail("ids", ": expected one for each contact");
    if (frames.size() != count) told.fail("frames", ": expected one for each contact");
    if (snapshot.has_impulses && impulses.size() != count) told.fail("impulses", ": expected one for each contact");
    for (Index i = 0; i < problem.nc(); ++i) {
      const auto at = static_cast<std::size_t>(i);
      ContactState contact;
      contact.edges = problem.edges[at];
      if (contact.edges != 0 && contact.edges != 4) told.fail("problem", ".edges: expected 0 or 4 of each contact");
      contact.rows = rows_of(problem, i, layout.friction_begin[at]);
      if (frames[at].size() == 9) {
        contact.point = frames[at].head<3>();
        contact.normal = frames[at].segment<3>(3);
        contact.tangent = frames[at].tail<3>();
      } else if (frames[at].size() != 0) {
        told.fail("frames", ": expected 9 numbers each, or none");
      }
      contact.mu = problem.mu(i);
      contact.gap = gap(i);
      contact.offset = value(problem.b, i);
      contact.compliance_n = value(problem.compliance_n, i);
      contact.compliance_t = value(problem.compliance_t, i);
      contact.offset_t = {value(problem.offset_t, 2 * i), value(problem.offset_t, 2 * i + 1)};
      contact.id = ids[at];
      if (snapshot.has_impulses) {
        if (impulses[at].size() != 3) told.fail("impulses", ": expected 3 numbers each");
        contact.impulse = impulses[at];
      }
      snapshot.contacts.push_back(std::move(contact));
    }
  }

  static void add_rows(const BoundedRows& rows, const JsonObject& told, Snapshot& snapshot) {
    Vector impulses = Vector::Zero(rows.size());
    if (snapshot.has_impulses && rows.size() > 0) impulses = told.vector("row_impulses", rows.size());
    for (Index i = 0; i < rows.size(); ++i) {
      const auto at = static_cast<std::size_t>(i);
      RowState row;
      row.direction = column(rows.R, i);
      row.coordinates = all_coordinates(row.direction.size());
      row.lower = rows.bounds.lower(i);
      row.upper = rows.bounds.upper(i);
      row.offset = rows.offset(i);
      row.compliance = rows.yields(i);
      row.friction_of = rows.bounds.friction_of[at];
      row.mu = rows.bounds.mu(i);
      row.is_angle = rows.is_angle[at] != 0;
      if (!rows.names.empty()) row.name = rows.names[at];
      row.impulse = impulses(i);
      snapshot.rows.push_back(std::move(row));
    }
  }

  double step_length_ = 0;
  Eigen::Vector3d gravity_ = Eigen::Vector3d::Zero();
  std::vector<Drawn> drawn_;
};

}  // namespace

std::unique_ptr<Engine> make_model_engine(const Scene& scene, const std::string& model) {
  return std::make_unique<ModelEngine>(scene, model);
}

}  // namespace lcpbench::capture
