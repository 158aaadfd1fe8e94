#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "study/evaluation/bounded_row_states.h"
#include "study/output/json_output.h"
#include "study/output/text_table.h"
#include "study/view/contact_numbers.h"
#include "study/view/shapes.h"
#include "study/view/view.h"

namespace lcpbench {
namespace {

using Eigen::Vector3d;

template <class Rows>
Json rows_json(const Rows& all) {
  Json array = Json::array();
  for (const auto& each : all) array.push_back(view_row(each));
  return array;
}

struct Picture {
  Json shapes = Json::array();
  Json poses = Json::array();      ///< of the bodies, by index; null where not known
  std::vector<std::string> notes;  ///< sentences for the reader on what is missing or derived
};

/// Adds the box of uniform density with the body's mass and inertia, as a body of its own.
void add_box_of(const RigidBody& body, Picture& picture) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(body.inertia);
  const Vector3d moments = axes.eigenvalues();
  const Vector3d half = (1.5 / body.mass * (Vector3d::Constant(moments.sum()) - 2 * moments)).cwiseMax(0).cwiseSqrt();
  Eigen::Matrix3d turn = axes.eigenvectors();
  if (turn.determinant() < 0) turn.col(2) *= -1;
  const Eigen::Quaterniond q(turn);
  const Vector3d& at = body.position;
  picture.shapes.push_back(
      {{"body", picture.poses.size()}, {"type", "box"}, {"size", view_row(half)}, {"from_inertia", true}});
  picture.poses.push_back(view_row(std::array{at.x(), at.y(), at.z(), q.w(), q.x(), q.y(), q.z()}));
}

Picture picture_of(const ScenesHeader& header, const SceneStep& step) {
  Picture picture;
  std::set<std::string> left_out;
  std::vector<Vector3d> drawn_at;
  for (const std::vector<double>& pose : step.poses) {
    picture.poses.push_back(pose.empty() ? Json() : view_row(pose));
  }
  for (const SceneShape& shape : header.shapes) {
    if (!is_drawn(shape)) left_out.insert(shape.type);
    const auto body = static_cast<std::size_t>(shape.body);
    const bool posed = shape.body < 0 || (body < step.poses.size() && step.poses[body].size() == 7);
    if (!is_drawn(shape) || !posed) continue;
    picture.shapes.push_back(shape_json(shape));
    if (shape.body >= 0) drawn_at.emplace_back(step.poses[body][0], step.poses[body][1], step.poses[body][2]);
  }
  for (const std::string& type : left_out) picture.notes.push_back("Shapes of type " + type + " are not drawn.");
  const RigidScene* scene = step.problem.scene();
  std::size_t without = 0;
  for (std::size_t i = 0; scene != nullptr && i < scene->bodies.size(); ++i) {
    const Vector3d& at = scene->bodies[i].position;
    const auto same = [&](const Vector3d& other) { return (other - at).norm() <= 1e-5 * (1 + at.norm()); };
    if (std::any_of(drawn_at.begin(), drawn_at.end(), same)) continue;
    add_box_of(scene->bodies[i], picture);
    ++without;
  }
  if (without > 0) {
    picture.notes.push_back(
        fmt::format("The file holds no shape of {}: drawn instead is the box of uniform density with the same mass and "
                    "moments of inertia.",
                    without == scene->bodies.size() ? "any body"
                    : without == 1                  ? "one body"
                                                    : fmt::format("{} bodies", without)));
  }
  return picture;
}

/// A contact's point, normal and tangents in the world; no numbers where the file does not tell. Of kind `contact` the
/// step has them, or not.
std::vector<std::vector<Vector3d>> contact_places(const SceneStep& step) {
  std::vector<std::vector<Vector3d>> places(static_cast<std::size_t>(step.problem.contact()->nc()));
  const auto set = [&](std::size_t c, const Vector3d& point, const Vector3d& normal, const Vector3d& tangent) {
    places[c] = {point, normal, tangent, normal.cross(tangent)};
  };
  const RigidScene* scene = step.problem.scene();
  for (std::size_t c = 0; scene != nullptr && c < places.size(); ++c) {
    set(c, scene->contacts[c].point, scene->contacts[c].normal, scene->contacts[c].tangent);
  }
  for (std::size_t c = 0; scene == nullptr && c < step.contact_frames.size(); ++c) {
    const auto three = [&](Index at) { return Vector3d(step.contact_frames[c].data() + at); };
    if (!step.contact_frames[c].empty()) set(c, three(0), three(3), three(6));
  }
  return places;
}

Json contacts_json(const SceneStep& step, std::vector<std::string>& notes) {
  const ContactProblem& problem = *step.problem.contact();
  const RigidScene* scene = step.problem.scene();
  Json points = Json::array();
  Json axes = Json::array();
  Json bodies = Json::array();
  const std::vector<std::vector<Vector3d>> places = contact_places(step);
  std::size_t found = 0;
  for (std::size_t c = 0; c < places.size(); ++c) {
    const auto& place = places[c];
    if (!place.empty()) ++found;
    points.push_back(place.empty() ? Json() : view_row(place[0]));
    axes.push_back(place.empty() ? Json() : rows_json(std::array{place[1], place[2], place[3]}));
    if (scene != nullptr) bodies.push_back({scene->contacts[c].body_a, scene->contacts[c].body_b});
  }
  if (scene == nullptr) {
    if (found < places.size()) {
      notes.push_back(fmt::format("{} only in the table: limits of joints, or contacts whose place the file does not tell.",
                                  counted_noun(places.size() - found, "contact")));
    }
    notes.emplace_back("Velocities of coordinates are not those of bodies: arrows show velocities of contacts.");
  }
  return {{"count", problem.nc()},
          {"ids", step.contact_ids},
          {"bodies", bodies},
          {"points", points},
          {"axes", axes},
          {"mu", view_row(problem.mu)},
          {"gaps", view_row(step.gap)},
          {"velocities_before", rows_json(contact_velocities(problem, problem.v))}};
}

/// Linear and angular velocity of each body; empty for problems of kind `contact`, whose coordinates may be others.
Json body_velocities(const SceneStep& step, const Vector& velocity) {
  Json array = Json::array();
  if (step.problem.scene() == nullptr) return array;
  for (Index i = 0; i + 6 <= velocity.size(); i += 6) array.push_back(view_row(Vector(velocity.segment(i, 6))));
  return array;
}

/// Name and unit of each bounded row.
Json bounded_rows_json(const BoundedRows& rows) {
  Json array = Json::array();
  for (Index row = 0; row < rows.size(); ++row) {
    array.push_back({{"name", rows.name_of(row)}, {"unit", velocity_unit(rows, row)}});
  }
  return array;
}

/// How an answer leaves each bounded row; no bound is null.
Json row_answers_json(const ContactProblem& problem, const Vector& z) {
  Json array = Json::array();
  if (!problem.has_rows()) return array;
  for (const BoundedRowState& state : BoundedRowStates(problem).of(z)) {
    array.push_back({{"lower", view_number(state.lower)},
                     {"upper", view_number(state.upper)},
                     {"impulse", view_number(state.impulse)},
                     {"velocity", view_number(state.velocity)},
                     {"state", to_string(state.at)}});
  }
  return array;
}

Json answer_json(const SceneStep& step, const ViewedAnswer& answer) {
  const Errors& errors = answer.errors;
  Json json = {{"solver", answer.solver},
               {"model", to_string(answer.model)},
               {"claim", to_string(answer.claim)},
               {"verdict", to_string(answer.verdict)},
               {"error_relative", json_number(errors.velocity_residual_relative)},
               {"error_m_per_s", json_number(errors.velocity_residual_m_per_s)},
               {"violation_m_per_s", json_number(errors.violation_m_per_s)},
               {"time_s", json_number(answer.time_s)},
               {"impulses", Json::array()},
               {"velocities", Json::array()},
               {"residuals", Json::array()},
               {"body_velocities", Json::array()},
               {"rows", Json::array()}};
  const ContactProblem& problem = *step.problem.contact();
  if (answer.z.size() != lcp_size(problem) || !answer.z.allFinite()) return json;
  const Vector velocity = post_impact_velocity(problem, answer.z);
  json["impulses"] = rows_json(contact_impulses(problem, answer.z));
  json["velocities"] = rows_json(contact_velocities(problem, velocity));
  json["residuals"] = view_row(contact_residuals(problem, answer.z, answer.model));
  json["body_velocities"] = body_velocities(step, velocity);
  json["rows"] = row_answers_json(problem, answer.z);
  return json;
}

}  // namespace

Json step_view(const ScenesHeader& header, const SceneStep& step, const std::string& source,
               const std::vector<ViewedAnswer>& answers) {
  const ContactProblem& problem = *step.problem.contact();
  Picture picture = picture_of(header, step);
  Json contacts = contacts_json(step, picture.notes);
  if (!step.notes.empty()) {
    picture.notes.push_back(
        fmt::format("The problem differs from the step that the engine took: {}.", fmt::join(step.notes, "; ")));
  }
  Json positions = Json::array();
  if (const RigidScene* scene = step.problem.scene()) {
    for (const RigidBody& body : scene->bodies) positions.push_back(view_row(body.position));
  }
  Json answered = Json::array();
  for (const ViewedAnswer& answer : answers) answered.push_back(answer_json(step, answer));
  const std::string of_engine = header.engine.empty() ? "" : " of " + header.engine;
  return {{"kind", "step"},
          {"title", header.scene.empty() ? step.problem.name()
                                         : fmt::format("{}, step {}{}", header.scene, step.step, of_engine)},
          {"source", source},
          {"time_s", step.time ? json_number(*step.time) : Json()},
          {"gravity", header.gravity.size() == 3 ? view_row(header.gravity) : Json()},
          {"notes", picture.notes},
          {"shapes", picture.shapes},
          {"poses", picture.poses},
          {"bodies", {{"positions", positions}, {"velocities_before", body_velocities(step, problem.v)}}},
          {"contacts", contacts},
          {"rows", bounded_rows_json(problem.rows)},
          {"answers", answered}};
}

}  // namespace lcpbench
