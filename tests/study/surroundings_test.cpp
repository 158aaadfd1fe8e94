// What the surroundings of the program must not bring about: names that command a terminal or a spreadsheet, ends
// without a word, half-made files.

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/io/whole_file.h"
#include "study/run/interrupt.h"
#include "tests/support/program_run.h"
#include "tests/support/study_support.h"

namespace lcpbench::surroundings_test {
namespace {

class SurroundingsTest : public ::testing::Test {
 protected:
  ProgramRun run(const std::string& arguments) { return run_program(folder_ / "", arguments); }
  /// Runs a script in the folder; the program's outputs go to its files `out` and `err`.
  ProgramRun shell(const std::string& script) {
    const int status = std::system(("cd '" + (folder_ / "").string() + "' || exit 99; " + script).c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_file(folder_ / "out"), read_file(folder_ / "err")};
  }
  /// Runs the program in the background of a shell and sends it a signal half a second after its first output.
  ProgramRun run_and_send(const std::string& signal, const std::string& arguments) {
    return shell("rm -f out err; '" LCPBENCH_PROGRAM "' " + arguments +
                 " >out 2>err & while [ ! -s err ] && [ ! -s out ] && kill -0 $!; do sleep 0.1; done 2>/dev/null; "
                 "sleep 0.5; kill -" +
                 signal + " $!; wait $!");
  }
  ScratchFolder folder_;
};

constexpr const char* kOneProblem =
    R"({"format": "lcpbench-problem", "version": 1, "name": "one", "kind": "lcp", "M": [[1]], "q": [-1]})";

TEST_F(SurroundingsTest, ArgumentsThatAreNoUtf8AreRefusedBeforeAnythingIsMade) {
  std::filesystem::create_directory(folder_ / "d\xff");
  std::ofstream(folder_ / "d\xff/one.json") << kOneProblem;
  for (const char* arguments :
       {"run --set 'file:d\xff' --solver lemke --trials 1 --store s.db",
        "run --set planted/definite --solver lemke --trials 1 --store 's\xff.db'", "solve 'd\xff/one.json'"}) {
    const ProgramRun output = run(arguments);
    EXPECT_EQ(output.exit_code, 2) << arguments;
    EXPECT_EQ(std::count(output.err.begin(), output.err.end(), '\n'), 1) << output.err;
    EXPECT_EQ(output.err.rfind("lcpbench: argument ", 0), 0U) << output.err;
    EXPECT_NE(output.err.find("?"), std::string::npos) << output.err;
    EXPECT_NE(output.err.find("is not UTF-8"), std::string::npos) << output.err;
  }
  std::size_t entries = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder_ / "")) ++entries;
  EXPECT_EQ(entries, 3U) << "out, err and the folder";
}

/// Clears a terminal and rings its bell, in both spellings of the escape.
TEST_F(SurroundingsTest, NamesCommandNoTerminalAndNoSpreadsheet) {
  const std::string name = "=d\x1b[2J\u009b2J\a";
  std::filesystem::create_directory(folder_ / name);
  std::ofstream(folder_ / (name + "/one.json")) << kOneProblem;
  const std::string set = "'file:" + name + "'";
  for (const std::string& arguments :
       {"run --set " + set + " --solver lemke --trials 1 --store s.db", "sets " + set, "sets " + set + " --format json",
        "inspect '" + name + "/one.json'", "solve '" + name + "/one.json' --solver lemke",
        "bench --set " + set + " --solver lemke --problems 1", "solve '" + name + "/none.json'",
        std::string("report s.db --out report")}) {
    const ProgramRun output = run(arguments);
    for (const char* raw : {"\x1b", "\u009b", "\a"}) {
      EXPECT_EQ((output.out + output.err).find(raw), std::string::npos) << arguments;
    }
  }
  EXPECT_NE(read_file(folder_ / "report/tables/cells.csv").find("file:=d?[2J?2J?,"), std::string::npos);
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / "report/tables")) {
    EXPECT_EQ(read_file(entry.path()).find('\x1b'), std::string::npos) << entry.path();
  }
}

/// A line end in a name is no line of the output.
TEST_F(SurroundingsTest, ANameWithALineEndStaysInItsLine) {
  for (const char* arguments :
       {"generate planted/definite --seed 1 --count 1 --out 'two\nlines'",
        "run --set planted/definite --solver lemke --trials 1 --store 'two\n.db'", "merge 'out\n.db' 'two\n.db'",
        "report 'two\n.db' --out 'report\nlines'", "sets 'file:two\nlines'",
        "bench --set 'file:two\nlines' --solver lemke --problems 1"}) {
    const ProgramRun output = run(arguments);
    ASSERT_EQ(output.exit_code, 0) << output.err;
    const std::string printed = output.out + output.err;
    EXPECT_EQ(printed.find("\nlines"), std::string::npos) << printed;
    EXPECT_EQ(printed.find("\n.db"), std::string::npos) << printed;
  }
  EXPECT_EQ(run("inspect 'two\nlines/000000.json'").out.rfind("two?lines/000000.json\n", 0), 0U);
}

/// Reading looks at no flag: it is given a second.
TEST_F(SurroundingsTest, AnInterruptEndsWhatLooksAtNoFlag) {
  const auto read_for_ever = [] {
    catch_interrupts(3);
    const AbandonedAfterInterrupt abandoned;
    raise(SIGTERM);
    for (;;) usleep(100'000);
  };
  EXPECT_EXIT(read_for_ever(), ::testing::ExitedWithCode(3), "interrupted; .*\nlcpbench: interrupted\n");
  const auto finish_first = [] {
    const volatile std::sig_atomic_t* stop = catch_interrupts(3);
    { const AbandonedAfterInterrupt abandoned; }
    raise(SIGTERM);
    for (int i = 0; i < 25; ++i) usleep(100'000);
    std::_Exit(*stop != 0 ? 7 : 8);
  };
  EXPECT_EXIT(finish_first(), ::testing::ExitedWithCode(7), "the command keeps what is done and ends");
}

/// Nobody reads: neither the output nor the file ever takes what is written.
TEST_F(SurroundingsTest, AnInterruptEndsWhatWaitsForAReader) {
  const auto print = [] {
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0 || dup2(ends[1], STDOUT_FILENO) < 0) std::_Exit(9);
    catch_interrupts(3);
    raise(SIGTERM);
    for (const std::string text(1 << 16, '.');;) {
      if (write(STDOUT_FILENO, text.data(), text.size()) < 0) std::_Exit(9);
    }
  };
  EXPECT_EXIT(print(), ::testing::ExitedWithCode(3), "interrupted; .*\nlcpbench: interrupted\n");
  ASSERT_EQ(mkfifo((folder_ / "fifo").c_str(), 0600), 0);
  const auto write_page = [&] {
    catch_interrupts(3);
    raise(SIGTERM);
    write_file(folder_ / "fifo", "page");
    std::_Exit(9);
  };
  EXPECT_EXIT(write_page(), ::testing::ExitedWithCode(3), "interrupted; .*\nlcpbench: interrupted\n");
}

#ifndef __SANITIZE_ADDRESS__
/// RELRO with all functions bound at the start: no table of addresses can be written over.
TEST_F(SurroundingsTest, TheProgramBindsItsFunctionsAtTheStart) {
  const std::string dynamic = shell("readelf -ld '" LCPBENCH_PROGRAM "' >out 2>err").out;
  EXPECT_NE(dynamic.find("GNU_RELRO"), std::string::npos) << dynamic;
  EXPECT_NE(dynamic.find("BIND_NOW"), std::string::npos) << dynamic;
}
#endif

TEST_F(SurroundingsTest, WhatIsMissingAroundTheProgramIsNamed) {
  EXPECT_NE(
      shell("TMPDIR=/nowhere '" LCPBENCH_PROGRAM "' validate >out 2>err").err.find("TMPDIR '/nowhere' is no folder"),
      std::string::npos);
  ASSERT_EQ(run("run --set planted/definite --solver lemke --trials 1 --store s.db").exit_code, 0);
  const ProgramRun merged = run("merge s.db ./s.db");
  EXPECT_EQ(merged.exit_code, 2);
  EXPECT_EQ(merged.err, "lcpbench: s.db: a store is not merged with itself; name it once\n");
}

// Root has no such limit: another user starts the program, if the folder of the build lets him.
TEST_F(SurroundingsTest, TheLimitOnProcessesIsNamed) {
  const std::string as_another = "chmod 777 .; setpriv --reuid 54321 --clear-groups bash -c ";
  if (shell(as_another + "\"'" LCPBENCH_PROGRAM "' --version\" >out 2>err").exit_code != 0) {
    GTEST_SKIP() << "no other user can start the program here";
  }
  const ProgramRun crowded =
      shell(as_another + "\"ulimit -u 1; exec '" LCPBENCH_PROGRAM
            "' run --set planted/definite --solver lemke --trials 1 --jobs 2 --store u.db\" >out 2>err");
  EXPECT_EQ(crowded.exit_code, 2);
  EXPECT_NE(crowded.err.find("(ulimit -u)\n"), std::string::npos) << crowded.err;
}

TEST_F(SurroundingsTest, InterruptedGeneratingLeavesWholeFilesAlone) {
  const ProgramRun output =
      shell("'" LCPBENCH_PROGRAM "' generate planted/definite --seed 1 --count 10000000 --out made >out 2>err & "
            "until [ -e made/000100.json ]; do sleep 0.02; done; kill -TERM $!; wait $!");
  EXPECT_EQ(output.exit_code, 3);
  std::int64_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / "made")) {
    EXPECT_EQ(entry.path().extension(), ".json");
    ++files;
  }
  EXPECT_EQ(output.out.rfind(std::to_string(files) + " problems of ", 0), 0U) << output.out;
}

/// One line at once, what is done is printed, exit code 3.
TEST_F(SurroundingsTest, InterruptedCommandsPrintWhatIsDone) {
  ASSERT_EQ(run("generate paper/copositive/exp1 --seed 1 --count 1 --out p").exit_code, 0);
  const std::string many = "$(yes p/000000.json | head -20000)";
  const std::string endless = " --set paper/monotone/exp1 --solver lemke";
  for (const auto& [arguments, words] : std::vector<std::pair<std::string, std::string>>{
           {"bench --problems 10000000" + endless, "geometric mean"},
           {"stability --trials 1000000" + endless, " of 1 set: "},
           {"solve " + many + " --solver lemke", "solved by 1 of 1 solver"}}) {
    for (const char* signal : {"HUP", "TERM"}) {
      const ProgramRun output = run_and_send(signal, arguments);
      EXPECT_EQ(output.exit_code, 3) << arguments.substr(0, 20) << signal;
      EXPECT_NE(output.err.find("lcpbench: interrupted; "), std::string::npos) << output.err;
      EXPECT_NE(output.out.find(words), std::string::npos) << arguments.substr(0, 20) << output.out.substr(0, 2000);
    }
  }
}

TEST_F(SurroundingsTest, InterruptedCommandsEndTheirJson) {
  const std::string problems = " --set paper/monotone/exp1 --solver lemke --format json";
  for (const std::string command : {"bench --problems 10000000", "stability --trials 1000000"}) {
    const ProgramRun output = run_and_send("TERM", command + problems);
    EXPECT_EQ(output.exit_code, 3) << command;
    EXPECT_NE(output.out.find("\"cells\": ["), std::string::npos) << output.out.substr(0, 2000);
    EXPECT_TRUE(output.out.ends_with("}\n")) << command;
  }
}

/// A shell without job control ignores SIGINT for what runs in its background; `nohup` does so with SIGHUP.
TEST_F(SurroundingsTest, SignalsThatTheParentIgnoresStayIgnored) {
  const ProgramRun output =
      run_and_send("INT", "run --set paper/monotone/exp1 --solver lemke --trials 10000000 --budget 1.5 --store s.db");
  EXPECT_EQ(output.exit_code, 0) << output.err;
  EXPECT_NE(output.out.find("time budget of 1.5 s is used up"), std::string::npos) << output.out;
}

TEST_F(SurroundingsTest, AFileThatOutgrowsItsLimitIsAnErrorWithWords) {
  const ProgramRun output = shell("ulimit -f 400; '" LCPBENCH_PROGRAM
                                  "' run --set paper/monotone/exp1 --solver lemke "
                                  "--trials 100000 --store s.db >out 2>err");
  EXPECT_EQ(output.exit_code, 2);
  EXPECT_NE(output.err.find("lcpbench: s.db: "), std::string::npos) << output.err;
}

}  // namespace
}  // namespace lcpbench::surroundings_test
