// The program of one engine: lcpbench-capture-<engine> SCENE MODEL EVERY STEPS FILE LOOP TRACK SOFT MARKS COMMAND. It
// runs STEPS steps (0: as many as the scene has) and writes each EVERY-th that has contacts or bounded rows, and one
// that fails, into FILE. LOOP is `engine`, or the solver or stepper that takes the place of the engine's own solver.
// With TRACK, a file too, it is a replay: every step is measured (track.h), steps without contacts and the last one
// are written too, and TRACK says which failure ended it. With SOFT, contacts are the softened ones that the engine
// itself solves. MARKS names what of MODEL is measured, see read_marks(). COMMAND starts an engine that is a program
// of the user's. MODEL, TRACK, SOFT, MARKS and COMMAND may be empty.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "adapters/capture/engine.h"
#include "adapters/capture/step_loop.h"
#include "adapters/capture/track.h"
#include "core/error.h"
#include "examples/capture/capture.h"

#include <fmt/format.h>

namespace lcpbench::capture {
namespace {

/// Names that contacts keep from step to step: within a pair of bodies, each contact takes the name of the nearest
/// contact of the step before, measured in the frame of a body, when that is near enough to be the same.
class ContactNames {
 public:
  void name(std::vector<ContactState>& contacts) {
    std::unordered_map<std::string, std::vector<Known>> now;
    for (ContactState& contact : contacts) {
      if (!contact.id.empty()) continue;  // the engine names them
      Known* nearest = nullptr;
      double distance = kSamePlace;
      for (Known& known : before_[contact.pair]) {
        if (known.id.empty()) continue;
        const double d = (known.local - contact.local).norm();
        if (!(d < distance)) continue;
        nearest = &known;
        distance = d;
      }
      contact.id = nearest != nullptr ? std::exchange(nearest->id, {})
                                      : numbered(contact.pair, ++count_[contact.pair]);
      now[contact.pair].push_back({contact.local, contact.id});
    }
    before_ = std::move(now);
  }

 private:
  static constexpr double kSamePlace = 0.05;  // m
  struct Known {
    Eigen::Vector3d local;
    std::string id;  ///< empty: taken
  };
  std::unordered_map<std::string, std::vector<Known>> before_;  // by pair
  std::map<std::string, int> count_;
};

/// Sums up the notes of steps, and says them when the program ends: the last line of stderr, which the command prints.
class AllNotes {
 public:
  void add(const std::vector<std::string>& notes) {
    for (const std::string& note : notes) {
      const std::size_t colon = note.rfind(": ");
      counts_[note.substr(0, colon)] += colon == std::string::npos ? 1 : std::atol(note.c_str() + colon + 2);
    }
  }
  ~AllNotes() {
    std::string text;
    for (const auto& [what, count] : counts_) text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", what, count);
    if (!text.empty()) fmt::print(stderr, "the problems differ from its steps, counted over all steps: {}\n", text);
  }

 private:
  std::map<std::string, long> counts_;
};

struct Arguments {
  std::string scene;
  std::string model;
  long every = 1;
  long steps = 0;
  std::string file;
  std::string loop;
  std::string track;  ///< empty: no replay
  std::string soft;
  std::string marks;
  std::string command;
};

struct Close {
  void operator()(lcpbench_capture* file) const { lcpbench_capture_close(file); }
};

void write_bodies(lcpbench_capture* file, const Snapshot& snapshot) {
  for (const BodyState& body : snapshot.bodies) {
    lcpbench_capture_body(file, body.mass, body.inertia.data(), body.position.data(), body.linear_velocity.data(),
                          body.angular_velocity.data());
  }
  for (const BlockState& block : snapshot.blocks) {
    lcpbench_capture_block(file, static_cast<int>(block.velocity.size()), block.mass.data(), block.velocity.data());
  }
}

int write_contact(lcpbench_capture* file, const ContactState& contact) {
  if (!contact.rows) {
    return lcpbench_capture_contact(file, contact.body_a, contact.body_b, contact.point.data(), contact.normal.data(),
                                    contact.tangent.data(), contact.mu, contact.edges, contact.offset,
                                    contact.id.c_str());
  }
  const Rows& rows = *contact.rows;
  const bool friction = contact.edges > 0;
  return lcpbench_capture_rows(file, static_cast<int>(rows.coordinates.size()), rows.coordinates.data(),
                               rows.normal.data(), friction ? rows.tangent.data() : nullptr,
                               friction ? rows.second_tangent.data() : nullptr, contact.mu, contact.edges,
                               contact.offset, contact.id.c_str());
}

/// @param told_time  whether the time of the step's solve is one that the engine itself told
void write_step(lcpbench_capture* file, long step, double time, const Snapshot& snapshot, bool told_time) {
  lcpbench_capture_step(file, step, time);
  write_bodies(file, snapshot);
  for (const ContactState& contact : snapshot.contacts) {
    const int index = write_contact(file, contact);
    lcpbench_capture_soft(file, contact.compliance_n, contact.compliance_t, contact.offset_t(0), contact.offset_t(1));
    lcpbench_capture_gap(file, index, contact.gap);
    if (contact.rows && !contact.normal.isZero(0)) {
      lcpbench_capture_frame(file, index, contact.point.data(), contact.normal.data(), contact.tangent.data());
    }
    if (snapshot.has_impulses) {
      lcpbench_capture_impulse(file, index, contact.impulse(0), contact.impulse(1), contact.impulse(2));
    }
  }
  for (const RowState& row : snapshot.rows) {
    const int index = lcpbench_capture_row(file, static_cast<int>(row.coordinates.size()), row.coordinates.data(),
                                           row.direction.data(), row.lower, row.upper, row.offset, row.compliance,
                                           row.is_angle ? "rad" : "m", row.name.c_str());
    if (row.friction_of >= 0) lcpbench_capture_row_friction(file, row.friction_of, row.mu);
    if (snapshot.has_impulses) lcpbench_capture_row_impulse(file, index, row.impulse);
  }
  if (snapshot.velocity_after.size() > 0) {
    lcpbench_capture_velocity(file, static_cast<int>(snapshot.velocity_after.size()), snapshot.velocity_after.data());
  }
  if (told_time && snapshot.solve_s) lcpbench_capture_solve_time(file, *snapshot.solve_s);
  for (const std::string& note : snapshot.notes) lcpbench_capture_note(file, note.c_str());
  for (std::size_t i = 0; i < snapshot.poses.size(); ++i) {
    const Eigen::Quaterniond& q = snapshot.poses[i].rotation;
    const double rotation[] = {q.w(), q.x(), q.y(), q.z()};
    lcpbench_capture_pose(file, static_cast<int>(i), snapshot.poses[i].position.data(), rotation);
  }
  lcpbench_capture_end_step(file);
}

/// Sets what a replay of a model measures. @param text  a line for each: a name, or two with a tab between them
void read_marks(const std::string& text, Scene& scene) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const auto mark = static_cast<int>(scene.marks.size());
    const std::size_t tab = line.find('\t');
    scene.marks.push_back(line.substr(0, tab));
    if (tab == std::string::npos) {
      scene.stands.push_back(mark);
    } else {
      scene.marks.push_back(line.substr(tab + 1));
      scene.grips.push_back({mark, mark + 1});
    }
  }
}

Scene scene_of(const Arguments& arguments) {
  Scene scene;
  scene.name = arguments.scene;
  if (arguments.model.empty()) scene = find_scene(arguments.scene);
  read_marks(arguments.marks, scene);
  scene.soft = arguments.soft;
  if (scene.soft == "exact" && scene.sweeps > 0) {
    throw InputError("scene '" + scene.name + "': --soft exact sets the sweeps itself, to 1,000");
  }
  if (scene.soft == "exact") scene.sweeps = 1'000;
  scene.program = arguments.command;
  return scene;
}

using CaptureFile = std::unique_ptr<lcpbench_capture, Close>;

CaptureFile open_file(const Arguments& arguments, const Engine& engine) {
  CaptureFile file(lcpbench_capture_open(arguments.file.c_str(), arguments.scene.c_str(), engine.name().c_str(),
                                         engine.version().c_str(), engine.step_length()));
  if (!file) throw InputError("cannot write '" + arguments.file + "'");
  lcpbench_capture_loop(file.get(), arguments.loop.c_str());
  lcpbench_capture_gravity(file.get(), engine.gravity().data());
  const std::vector<Drawn> drawn = engine.drawn();
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    if (drawn[i].type.empty()) continue;
    lcpbench_capture_shape(file.get(), static_cast<int>(i), drawn[i].type.c_str(), drawn[i].size.data(),
                           static_cast<int>(drawn[i].size.size()));
  }
  return file;
}

int run(const Arguments& arguments) {
  const Scene scene = scene_of(arguments);
  const std::unique_ptr<Engine> engine = make_engine(scene, arguments.model);
  const bool mujoco = engine->name() == "MuJoCo";
  if (!mujoco && !arguments.soft.empty() && arguments.soft != "model" && arguments.soft != "exact") {
    throw InputError("--soft " + arguments.soft + ": a solver of MuJoCo's; " + engine->name() +
                     " takes model or exact");
  }
  if (mujoco && (scene.cfm >= 0 || scene.erp >= 0)) {
    throw InputError("scene '" + scene.name + "': MuJoCo has no cfm and erp");
  }
  if (!mujoco && scene.elliptic) throw InputError("scene '" + scene.name + "': elliptic cones are MuJoCo's alone");
  const double h = engine->step_length();
  CaptureFile file = open_file(arguments, *engine);
  const bool replay = !arguments.track.empty();
  ContactNames names;
  std::unique_ptr<StepLoop> stepper;
  VelocitySolver loop;
  Eigen::VectorXd velocity;  // by `loop`, after the step's contacts
  if (arguments.loop != "engine") {
    const auto use = replay ? StepLoop::Use::kReplay : StepLoop::Use::kSolved;
    stepper = std::make_unique<StepLoop>(arguments.loop, use, h);
    loop = [&](Snapshot& found) {
      names.name(found.contacts);
      return velocity = (*stepper)(found);
    };
  }
  std::unique_ptr<Track> track;
  if (replay) track = std::make_unique<Track>(arguments.track, *engine);
  Snapshot snapshot;
  AllNotes notes;
  constexpr long kModelSteps = 1000;  // a robot has to fall first: 40 of every tenth step have contacts
  const long steps = arguments.steps > 0 ? arguments.steps : arguments.model.empty() ? scene.steps : kModelSteps;
  for (long step = 0; step < steps; ++step) {
    engine->step(step, snapshot, loop);
    if (!loop) names.name(snapshot.contacts);
    notes.add(snapshot.notes);
    std::string failure = loop ? stepper->failure() : "";
    if (replay) {
      const std::string ended = loop ? track->add(step, snapshot, velocity, stepper->claim(), stepper->cpu_s())
                                     : track->add(step, snapshot, snapshot.velocity_after, "engine", snapshot.solve_s);
      if (failure.empty()) failure = ended;
    }
    const bool wanted = !failure.empty() || step % arguments.every == 0 || (replay && step == steps - 1);
    if (wanted && (replay || !snapshot.contacts.empty() || !snapshot.rows.empty())) {
      if (replay && !snapshot.velocity_after.allFinite()) {  // the simulation blew up; files hold finite numbers only
        snapshot.velocity_after.resize(0);
        snapshot.has_impulses = false;
      }
      write_step(file.get(), step, static_cast<double>(step) * h, snapshot, !arguments.command.empty());
    }
    if (failure.empty()) continue;
    if (!replay) throw std::runtime_error("step " + std::to_string(step) + ": " + failure);
    track->end(failure);
    break;
  }
  const int failed = lcpbench_capture_close(file.release());
  if (failed == 0 && track != nullptr) track->close();  // writes the last line, which marks it as complete
  return failed;
}

}  // namespace
}  // namespace lcpbench::capture

int main(int argc, char** argv) {
  if (argc != 11) {
    std::fprintf(stderr, "usage: %s SCENE MODEL EVERY STEPS FILE LOOP TRACK SOFT MARKS COMMAND\n", argv[0]);
    return 2;
  }
  try {
    return lcpbench::capture::run({argv[1], argv[2], std::max(1L, std::atol(argv[3])), std::atol(argv[4]), argv[5],
                                   argv[6], argv[7], argv[8], argv[9], argv[10]});
  } catch (const lcpbench::InputError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
