#include "study/certificates/proof_document.h"

#include <array>
#include <stdexcept>

#include <gmpxx.h>
#include <zlib.h>

#include "core/error.h"
#include "core/io/problem_io.h"
#include "study/output/json_output.h"

namespace lcpbench {
namespace {

std::string problem_text(const Problem& problem) {
  if (problem.kind() != ProblemKind::kScene) return problem_json_line(problem, true);
  return problem_json_line(Problem(problem.name(), *problem.contact()), true);
}

Json exact_json(const ExactVector& vector) {
  if (vector.numerators.empty()) return nullptr;
  return {{"denominator", vector.denominator}, {"numerators", vector.numerators}};
}

Json flag_json(const std::optional<bool>& flag) { return flag ? Json(*flag) : Json(nullptr); }

}  // namespace

std::string proof_document(const Problem& problem, const Certificate& certificate) {
  const Json proof{{"certificate", to_string(certificate.kind)},
                   {"proof", to_string(certificate.proof)},
                   {"z", json_vector(certificate.z)},
                   {"velocity", json_vector(certificate.velocity)},
                   {"velocity_unique", flag_json(certificate.velocity_unique)},
                   {"exact_z", exact_json(certificate.exact_z)},
                   {"exact_potential", exact_json(certificate.exact_potential)},
                   {"exact_velocity", exact_json(certificate.exact_velocity)},
                   {"exact_farkas", exact_json(certificate.exact_farkas)},
                   {"exact_other_z", exact_json(certificate.exact_other_z)},
                   {"exact_other_potential", exact_json(certificate.exact_other_potential)}};
  // The problem is inserted as text, so that its numbers keep the digits of the problem file.
  return R"({"format":"lcpbench-proof","version":1,"problem":)" + problem_text(problem) + "," + proof.dump().substr(1);
}

std::string deflate(std::string_view text) {
  uLongf size = compressBound(static_cast<uLong>(text.size()));
  std::string bytes(size, '\0');
  const int result =
      compress2(reinterpret_cast<Bytef*>(bytes.data()), &size, reinterpret_cast<const Bytef*>(text.data()),
                static_cast<uLong>(text.size()), Z_DEFAULT_COMPRESSION);
  if (result != Z_OK) throw std::runtime_error("deflate: zlib gives " + std::to_string(result));
  bytes.resize(size);
  return bytes;
}

std::string inflate(std::string_view bytes) {
  z_stream stream{};
  if (inflateInit(&stream) != Z_OK) throw std::runtime_error("inflate: zlib does not start");
  std::string input(bytes);  // zlib's interface wants it writable
  stream.next_in = reinterpret_cast<Bytef*>(input.data());
  stream.avail_in = static_cast<uInt>(input.size());
  std::string text;
  std::array<char, 1 << 16> buffer{};
  int result = Z_OK;
  while (result == Z_OK) {
    stream.next_out = reinterpret_cast<Bytef*>(buffer.data());
    stream.avail_out = static_cast<uInt>(buffer.size());
    result = ::inflate(&stream, Z_NO_FLUSH);
    text.append(buffer.data(), buffer.size() - stream.avail_out);
  }
  const bool whole = result == Z_STREAM_END && stream.avail_in == 0;
  inflateEnd(&stream);
  if (!whole) throw InputError("a proof is damaged: it does not inflate");
  return text;
}

std::vector<std::string> fractions(const ExactVector& vector) {
  std::vector<std::string> texts;
  if (vector.numerators.empty()) return texts;
  const mpz_class denominator(vector.denominator, 10);
  for (const std::string& numerator : vector.numerators) {
    mpq_class fraction(mpz_class(numerator, 10), denominator);
    fraction.canonicalize();
    texts.push_back(fraction.get_str());
  }
  return texts;
}

}  // namespace lcpbench
