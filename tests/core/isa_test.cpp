#include "core/isa.h"

#include <sstream>

#include <gtest/gtest.h>

namespace lcpbench::isa_test {
namespace {

std::string name_in(const std::string& cpuinfo) {
  std::istringstream text(cpuinfo);
  return processor_name(text);
}

TEST(ProcessorNameTest, IsFoundInEachProcessorsWayOfTellingIt) {
  EXPECT_EQ(name_in("processor\t: 0\nvendor_id\t: GenuineIntel\nmodel\t\t: 143\nmodel name\t: A Processor 9000\n"),
            "A Processor 9000");
  EXPECT_EQ(name_in("processor\t: 0\ncpu\t\t: POWER9, altivec supported\nclock\t\t: 3.8GHz\n"),
            "POWER9, altivec supported");
  EXPECT_EQ(name_in("processor\t: 0\nhart\t\t: 1\nisa\t\t: rv64imafdc\nuarch\t\t: sifive,u74-mc\n"), "sifive,u74-mc");
  EXPECT_EQ(
      name_in("processor\t: 0\nBogoMIPS\t: 50.00\nCPU implementer\t: 0x41\nCPU architecture: 8\nCPU part\t: 0xd0c\n"),
      "CPU implementer 0x41 part 0xd0c");
}

TEST(ProcessorNameTest, IsUnknownWhereNothingTellsIt) {
  EXPECT_EQ(name_in(""), "unknown");
  EXPECT_EQ(name_in(": \nmodel name\n\nprocessor\t: 0\n"), "unknown");
}

TEST(IsaLevelTest, LevelsAboveTheBaselineAreThoseOfX86) {
#ifndef __x86_64__
  EXPECT_EQ(best_isa_level(), IsaLevel::kBaseline);
#endif
  EXPECT_LE(isa_level(), best_isa_level());
}

}  // namespace
}  // namespace lcpbench::isa_test
