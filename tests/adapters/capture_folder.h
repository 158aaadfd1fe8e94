#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "core/io/problem_io.h"
#include "core/io/scenes_file.h"
#include "tests/support/program_run.h"

namespace lcpbench {

namespace fs = std::filesystem;

/// The command `capture` in a folder of its own, with the engines' programs or with a stand-in for one.
class Capture : public ::testing::Test {
 protected:
  Capture() : folder_(fs::temp_directory_path() / ("lcpbench-capture-" + std::to_string(getpid()))) {
    fs::create_directories(folder_);
  }
  ~Capture() override { fs::remove_all(folder_); }

  static bool installed(const std::string& engine) {
    return fs::exists(fs::path(LCPBENCH_PROGRAM).parent_path() / ("lcpbench-capture-" + engine));
  }

  ProgramRun capture(const std::string& arguments) const { return run_program(folder_, "capture " + arguments); }

  ScenesFile captured(const std::string& scene, const std::string& engine, const std::string& options) const {
    const std::string file = (folder_ / (scene + ".scenes")).string();
    const ProgramRun run = capture(scene + " --engine " + engine + " --out '" + file + "' " + options);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return ScenesFile(file);
  }

  /// A stand-in for ODE's program: writes step 3, begins step 4, and goes on with the given shell commands.
  void stand_in(const std::string& commands) const {
    const std::string problem =
        R"({"format":"lcpbench-problem","version":1,"name":"stack step 3","kind":"scene","bodies":[{"mass":1,)"
        R"("inertia":[[1,0,0],[0,1,0],[0,0,1]],"position":[0,0,1],"linear_velocity":[0,0,-1],"angular_velocity":[0,0,0]}],)"
        R"("contacts":[{"body_a":0,"body_b":-1,"point":[0,0,0],"normal":[0,0,1]}]})";
    const fs::path program = folder_ / "lcpbench-capture-ode";
    std::ofstream(program) << "#!/bin/sh\ncat > \"$5\" <<'END'\n"
                           << R"({"format":"lcpbench-scenes","version":1,"scene":"stack","engine":"stand-in"})"
                           << "\n"
                           << R"({"step":3,"problem":)" << problem << "}\nEND\n"
                           << R"(printf '{"step":4,"prob' >> "$5")"
                           << "\n"
                           << commands << "\n";
    fs::permissions(program, fs::perms::owner_all);
  }

  /// Captures from the stand-in, by the shell. @returns the exit code
  int capture_stand_in(const std::string& out, const std::string& before = "", const std::string& after = "") const {
    const std::string command = "cd '" + folder_.string() + "' && export LCPBENCH_WORKER_DIR='" + folder_.string() +
                                "'; " + before + " '" LCPBENCH_PROGRAM "' capture stack --out " + out + " >out 2>err " +
                                after;
    return WEXITSTATUS(std::system(command.c_str()));
  }

  void expect_step_three(const std::string& name) const {
    const ScenesFile file((folder_ / name).string());
    ASSERT_EQ(file.count(), 1U);
    EXPECT_EQ(file.step_number(0), 3);
    expect_no_other_file(name);
  }

  /// Nothing is left in the folder but the stand-in and what it was captured into.
  void expect_no_other_file(const std::string& name) const {
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
      const std::string found = entry.path().filename().string();
      const bool known = found == name || found == "out" || found == "err" || found == "ready" || found == "second" ||
                         found == "lcpbench-capture-ode";
      EXPECT_TRUE(known) << found;
    }
  }

  fs::path folder_;
};

}  // namespace lcpbench
