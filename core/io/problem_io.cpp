#include "core/io/problem_io.h"

#include <string>
#include <string_view>

#include "core/io/problem_checks.h"
#include "core/io/scenes_file.h"
#include "core/io/whole_file.h"

namespace lcpbench {
namespace {

namespace fs = std::filesystem;

bool ends_with(const fs::path& file, std::string_view suffix) { return file.string().ends_with(suffix); }

Problem read_matrix_market_pair(const fs::path& file) {
  constexpr std::string_view kM = ".M.mtx";
  constexpr std::string_view kQ = ".q.mtx";
  if (!ends_with(file, kM) && !ends_with(file, kQ)) {
    throw input_error(file.string(), "a Matrix Market problem is a pair of files, NAME.M.mtx and NAME.q.mtx");
  }
  const std::string name = file.string().substr(0, file.string().size() - kM.size());
  const std::string M_file = name + std::string(kM);
  const std::string M = read_text(M_file, "problem file");
  return parse_matrix_market(M, read_text(name + std::string(kQ), "problem file"), M_file);
}

InputError no_format(const fs::path& file) {
  return input_error(file.string(),
                     "no format that is read: a problem in JSON ('{' first), Siconos' text of an LCP or MLCP (a number "
                     "first), NAME.M.mtx with NAME.q.mtx, NAME.scenes#STEP; numpy's .npz and .mat are read by "
                     "lcpbench.load in Python");
}

/// Whether the text is JSON, else it is Siconos' text: by the extension .json, else by the first character that is not
/// white space (a byte-order mark may stand before '{').
bool is_json(const fs::path& file, std::string_view text) {
  if (file.extension() == ".json") return true;
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  const auto first = text.find_first_not_of(" \t\r\n\v\f");
  const char c = first == std::string_view::npos ? '\0' : text[first];
  if (c == '{') return true;
  if (c >= '0' && c <= '9') return false;
  throw no_format(file);
}

}  // namespace

Problem read_problem(const std::filesystem::path& file) {
  if (ends_with(file, ".mtx")) return read_matrix_market_pair(file);
  if (const auto step = scenes_step(file.string())) {
    const ScenesFile scenes(step->first);
    return scenes.read(scenes.index_of(step->second)).problem;
  }
  if (is_scenes_file(file.string())) {
    throw input_error(file.string(), "holds steps: name one problem as " + file.filename().string() + "#STEP");
  }
  if (ends_with(file, ".npz") || ends_with(file, ".mat")) throw no_format(file);
  const std::string text = read_text(file, "problem file");
  if (is_json(file, text)) return parse_problem_json(text, file.string());
  return parse_siconos_lcp(text, file.string());
}

void write_problem(const Problem& problem, const std::filesystem::path& file) {
  write_file(file, problem_json(problem));
}

}  // namespace lcpbench
