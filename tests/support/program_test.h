#pragma once

#include <algorithm>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/checks.h"
#include "tests/support/program_run.h"
#include "tests/support/study_support.h"

namespace lcpbench {

/// The program, run in a folder of the test's own.
class ProgramTest : public ::testing::Test {
 protected:
  ProgramRun run(const std::string& arguments) { return run_program(folder_ / "", arguments); }
  /// What a command prints that has to succeed.
  std::string done(const std::string& arguments) {
    const ProgramRun ended = run(arguments);
    EXPECT_EQ(ended.exit_code, 0) << arguments << ": " << ended.err;
    return ended.out;
  }
  nlohmann::json run_json(const std::string& arguments) {
    return nlohmann::json::parse(done(arguments + " --format json"));
  }
  std::string read(const std::string& file) const { return read_file(folder_ / file); }
  void write(const std::string& file, const std::string& text) const {
    std::ofstream(folder_ / file, std::ios::binary) << text;
  }
  /// Writes a problem file: `fields` behind its format, version and name.
  void write_problem_of(const std::string& file, const std::string& fields) const {
    write(file, R"({"format": "lcpbench-problem", "version": 1, "name": "made", )" + fields + "}");
  }
  /// Bad usage or input: exit code 2, nothing printed but one line that begins with the program's name.
  void expect_mistake(const std::string& arguments) {
    const ProgramRun ended = run(arguments);
    EXPECT_EQ(ended.exit_code, 2) << arguments;
    EXPECT_EQ(ended.out, "") << arguments;
    EXPECT_EQ(ended.err.rfind("lcpbench: ", 0), 0U) << arguments << ": " << ended.err;
    EXPECT_EQ(std::count(ended.err.begin(), ended.err.end(), '\n'), 1) << arguments << ": " << ended.err;
  }

  ScratchFolder folder_;
};

/// A bare LCP of one row, whose answer is 1.
inline constexpr const char* kOneRow = R"("kind": "lcp", "M": [[1]], "q": [-1])";

}  // namespace lcpbench
