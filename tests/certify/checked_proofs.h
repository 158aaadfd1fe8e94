#pragma once

#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "study/certificates/proof_document.h"
#include "study/certify/certificate.h"
#include "tests/support/program_run.h"
#include "tests/support/study_support.h"

namespace lcpbench::testing {

/// At the end of the program, all proofs that its tests made are checked by study/check_certificates.py, which reads
/// the problems' doubles as fractions and shares no code with the certifier.
class CheckedProofs final : public ::testing::Environment {
 public:
  void TearDown() override {
    if (documents_.empty()) return;
    const ScratchFolder folder;
    std::ofstream file(folder / "proofs.jsonl");
    for (const std::string& document : documents_) file << document << "\n";
    file.close();
    const std::string out = folder / "out";
    const std::string command = CHECK_CERTIFICATES " '" + (folder / "proofs.jsonl").string() + "' >'" + out + "' 2>&1";
    EXPECT_EQ(std::system(command.c_str()), 0) << read_file(out);
    EXPECT_NE(read_file(out).find(std::to_string(documents_.size()) + " accepted"), std::string::npos)
        << read_file(out);
  }
  void add(std::string document) { documents_.push_back(std::move(document)); }

 private:
  std::vector<std::string> documents_;
};

inline CheckedProofs& checked_proofs() {
  static auto* const proofs = new CheckedProofs;  // GoogleTest deletes it
  return *proofs;
}
inline const ::testing::Environment* const kCheckedProofs = ::testing::AddGlobalTestEnvironment(&checked_proofs());

/// Has the certificate's proof checked. One that is open claims nothing.
inline void expect_proof(const Problem& problem, const Certificate& certificate) {
  if (certificate.kind != CertificateKind::kOpen) checked_proofs().add(proof_document(problem, certificate));
}

}  // namespace lcpbench::testing
