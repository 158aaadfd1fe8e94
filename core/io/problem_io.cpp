#include "core/io/problem_io.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include "core/io/problem_checks.h"
#include "core/io/scenes_file.h"
#include "core/io/whole_file.h"

namespace lcpbench {
namespace {

namespace fs = std::filesystem;

/// The regular file's size, after every reason not to read it.
std::uintmax_t checked_size(const fs::path& file) {
  const std::string origin = file.string();
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (status.type() == fs::file_type::not_found) throw input_error(origin, "no such file");
  if (error) throw input_error(origin, error.message());
  if (status.type() == fs::file_type::directory) throw input_error(origin, "is a folder, expected a problem file");
  if (status.type() != fs::file_type::regular) throw input_error(origin, "is not a regular file");
  const std::uintmax_t size = fs::file_size(file, error);
  if (error) throw input_error(origin, error.message());
  if (size > kMaxFileBytes) {
    throw input_error(origin, std::to_string(size) + " bytes, at most " + std::to_string(kMaxFileBytes) + " are read");
  }
  return size;
}

/// Refuses binary files, holes of zeros first of all, before the whole is read.
void check_text(std::string_view beginning, const std::string& origin) {
  if (beginning.empty()) throw input_error(origin, "empty file");
  if (beginning.find('\0') != std::string_view::npos) throw input_error(origin, "has NUL bytes: not a text file");
}

std::string read_text(const fs::path& file) {
  const std::string origin = file.string();
  const std::uintmax_t size = checked_size(file);
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw input_error(origin, std::string("cannot be opened: ") + std::strerror(errno));
  constexpr std::uintmax_t kBeginning = 4096;
  std::string text(static_cast<std::size_t>(std::min(size, kBeginning)), '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  check_text(std::string_view(text).substr(0, static_cast<std::size_t>(stream.gcount())), origin);
  const std::size_t begun = text.size();
  text.resize(static_cast<std::size_t>(size));
  stream.read(text.data() + begun, static_cast<std::streamsize>(text.size() - begun));
  if (stream.bad() || static_cast<std::size_t>(stream.gcount()) != text.size() - begun) {
    throw input_error(origin, "cannot be read to its end");
  }
  return text;
}

bool ends_with(const fs::path& file, std::string_view suffix) { return file.string().ends_with(suffix); }

Problem read_matrix_market_pair(const fs::path& file) {
  constexpr std::string_view kM = ".M.mtx";
  constexpr std::string_view kQ = ".q.mtx";
  if (!ends_with(file, kM) && !ends_with(file, kQ)) {
    throw input_error(file.string(), "a Matrix Market problem is a pair of files, NAME.M.mtx and NAME.q.mtx");
  }
  const std::string name = file.string().substr(0, file.string().size() - kM.size());
  const std::string M_file = name + std::string(kM);
  return parse_matrix_market(read_text(M_file), read_text(name + std::string(kQ)), M_file);
}

enum class Format { kJson, kSiconos };

/// By the extension .json, else by the first character that is not white space (a byte-order mark may stand before
/// '{').
Format text_format(const fs::path& file, std::string_view text) {
  if (file.extension() == ".json") return Format::kJson;
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  const auto first = text.find_first_not_of(" \t\r\n\v\f");
  const char c = first == std::string_view::npos ? '\0' : text[first];
  if (c == '{') return Format::kJson;
  if (c >= '0' && c <= '9') return Format::kSiconos;
  throw input_error(file.string(), "neither a problem in JSON ('{' first) nor a Siconos LCP text (a number first)");
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
  const std::string text = read_text(file);
  if (text_format(file, text) == Format::kJson) return parse_problem_json(text, file.string());
  return parse_siconos_lcp(text, file.string());
}

void write_problem(const Problem& problem, const std::filesystem::path& file) {
  write_file(file, problem_json(problem));
}

}  // namespace lcpbench
