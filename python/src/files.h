#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/io/problem_checks.h"
#include "core/io/problem_io.h"
#include "core/io/scenes_file.h"
#include "python/src/arrays.h"

// Problem files, scenes files and recorded states of MuJoCo, for lcpbench/_files.py and mujoco.py. These check what is
// not checked here: the index of `read`, `every`, and that a step has all keys of step_fields(). `add` releases
// the interpreter's lock while it writes: only one thread at a time may use a ScenesWriter.

namespace lcpbench::python {

/// All fields of a step but its number and problem; None for a field that is empty.
inline nb::dict step_fields(const SceneStep& step) {
  nb::dict fields;
  const auto add = [&](const char* name, const auto& values) {
    fields[name] = std::size(values) > 0 ? nb::cast(values) : nb::none();
  };
  fields["time"] = step.time;
  add("gap", step.gap);
  add("contact_ids", step.contact_ids);
  add("impulses", step.engine_impulses);
  add("velocity", step.engine_velocity);
  add("poses", step.poses);
  add("contact_frames", step.contact_frames);
  fields["notes"] = step.notes;
  return fields;
}

/// The inverse. @throws InputError for a bare LCP and wrong lengths, nb::type_error
inline SceneStep step_of(std::int64_t number, const Problem& problem, const nb::dict& fields) {
  SceneStep step;
  step.step = number;
  step.problem = problem;
  const auto given = [&](const char* name) { return !fields[name].is_none(); };
  const ContactProblem* contact = problem.contact();
  if (contact == nullptr) throw InputError("problem: is a bare LCP, expected one with contacts");
  if (!nb::try_cast(fields["time"], step.time)) throw nb::type_error("time: expected a number or None");
  if (given("gap")) {
    const Vector gap = vector(fields["gap"], "gap", contact->nc());
    step.gap.assign(gap.begin(), gap.end());
  }
  if (given("contact_ids")) {
    if (!nb::try_cast(fields["contact_ids"], step.contact_ids)) throw nb::type_error("contact_ids: expected texts");
    if (static_cast<Index>(step.contact_ids.size()) != contact->nc()) {
      throw InputError("contact_ids has " + std::to_string(step.contact_ids.size()) + " entries, expected " +
                       std::to_string(contact->nc()));
    }
    check_distinct(step.contact_ids, "contact_ids");
  }
  if (!nb::try_cast(fields["notes"], step.notes)) throw nb::type_error("notes: expected texts");
  if (given("impulses")) {
    step.engine_impulses = contact_impulses(*contact, fields["impulses"], fields["row_impulses"]);
  } else if (given("row_impulses")) {
    throw InputError("row_impulses: given without impulses");
  }
  if (given("velocity")) step.engine_velocity = vector(fields["velocity"], "velocity", contact->ngc());
  for (auto& [name, rows] : {std::pair{"poses", &step.poses}, std::pair{"contact_frames", &step.contact_frames}}) {
    if (given(name) && !nb::try_cast(fields[name], *rows)) {
      nb::raise_type_error("%s: expected lists of numbers", name);
    }
  }
  return step;
}

/// Copies of a MuJoCo simulation's state, one at the first of every `every` calls of before_step().
struct States {
  std::uintptr_t get, model, data;  ///< addresses of mj_getState, an mjModel and its mjData, which outlive this
  int which;                        ///< mj_getState's mask of state components
  Index size, every, seen = 0;      ///< size: mj_stateSize of that mask; every: at least 1; seen: calls so far
  std::vector<Vector> kept{};

  void before_step() {
    const auto function = reinterpret_cast<void (*)(void*, void*, double*, int)>(get);
    if (seen++ % every != 0) return;
    function(reinterpret_cast<void*>(model), reinterpret_cast<void*>(data), kept.emplace_back(size).data(), which);
  }
};

inline void define_files(nb::module_& module) {
  module.def("read_problem", [](const std::string& file) { return read_problem(file); });
  module.def("write_problem", [](const Problem& problem, const std::string& file) { write_problem(problem, file); });
  module.def("problem_json", &problem_json);
  module.def("parse_problem", [](const std::string& text) { return parse_problem_json(text, "text"); });
  module.def("problem_hash", &problem_hash);
  module.def("scenes_step", &scenes_step);
  module.def("is_scenes_file", [](const std::string& name) { return is_scenes_file(name); });
  nb::class_<ScenesFile>(module, "ScenesFile")
      .def(nb::init<const std::string&>())
      .def("__len__", &ScenesFile::count)
      .def_prop_ro("scene", [](const ScenesFile& f) { return f.header().scene; })
      .def_prop_ro("engine", [](const ScenesFile& f) { return f.header().engine; })
      .def_prop_ro("step_length", [](const ScenesFile& f) { return f.header().step_length; })
      .def("index_of", &ScenesFile::index_of)
      .def("read", [](const ScenesFile& f, std::size_t index) {
        const SceneStep step = f.read(index);
        return nb::make_tuple(step.step, step.problem, step_fields(step));
      });
  nb::class_<ScenesWriter>(module, "ScenesWriter")
      .def("__init__",
           [](ScenesWriter* self, const std::string& file, const std::string& scene, const std::string& engine,
              const std::string& version, std::optional<double> step_length, const std::vector<double>& gravity,
              const std::vector<std::tuple<int, std::string, std::vector<double>>>& shapes) {
             ScenesHeader header{.scene = scene, .engine = engine, .engine_version = version, .loop = "engine"};
             header.step_length = step_length;
             header.gravity = gravity;
             for (const auto& [body, type, size] : shapes) header.shapes.push_back({body, type, size});
             constexpr int kLevel = 1;  // of zstd: fast enough for a simulator's loop
             new (self) ScenesWriter(file, header, kLevel);
           })
      .def("add",
           [](ScenesWriter& writer, std::int64_t number, const Problem& problem, const nb::dict& fields) {
             const SceneStep step = step_of(number, problem, fields);
             const nb::gil_scoped_release released;
             writer.add(step);
           })
      .def("close", [](ScenesWriter& writer) { writer.close(); });
  nb::class_<States>(module, "States")
      .def(nb::init<std::uintptr_t, std::uintptr_t, std::uintptr_t, int, Index, Index>())
      .def("before_step", &States::before_step)
      .def("take", [](States& states) { return std::exchange(states.kept, {}); });
}

}  // namespace lcpbench::python
