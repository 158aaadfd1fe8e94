#include "core/settings.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/registry.h"

namespace lcpbench::settings_test {
namespace {

enum class Engine { kDense, kKernel };

struct Sample {
  double tolerance = 1e-12;
  std::int64_t limit = 0;
  bool polish = false;
  Engine engine = Engine::kDense;
  std::string inner = "lemke";

  void visit(auto&& field) {
    field("tolerance", tolerance, RealRange{.min = 0, .max = 1}, "help of tolerance");
    field("limit", limit, IntegerRange{.min = 0}, "help of limit");
    field("polish", polish, "help of polish");
    field("engine", engine, Choices<Engine>{{{"dense", Engine::kDense}, {"kernel", Engine::kKernel}}},
          "help of engine");
    field("inner", inner, "help of inner");
  }
};

Sample parse(const Options& options) { return parse_settings<Sample>("sample", options); }

std::string error_of(const Options& options) {
  try {
    parse(options);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(SettingsTest, EveryFieldReadsBackFromItsOwnText) {
  const Sample sample = parse({{"tolerance", "0.25"}, {"limit", "7"}, {"polish", "true"}, {"engine", "kernel"}});
  EXPECT_EQ(sample.tolerance, 0.25);
  EXPECT_EQ(sample.limit, 7);
  EXPECT_TRUE(sample.polish);
  EXPECT_EQ(sample.engine, Engine::kKernel);
  const Options written = all_settings(sample);
  ASSERT_EQ(written.size(), 5u);
  EXPECT_EQ(all_settings(parse(written)), written);
  EXPECT_TRUE(changed_settings(parse({{"engine", "dense"}, {"tolerance", "1e-12"}})).empty());
  const double real = 0x1.fffffffffffffp-40;
  EXPECT_EQ(parse(changed_settings(parse({{"tolerance", format_real(real)}}))).tolerance, real);
}

TEST(SettingsTest, ErrorsNameOwnerFieldValueAndRange) {
  EXPECT_EQ(error_of({{"tolerance", "-1"}}), "sample: tolerance = '-1': expected a number in [0, 1]");
  EXPECT_EQ(error_of({{"tolerance", "nan"}}), "sample: tolerance = 'nan': expected a number in [0, 1]");
  EXPECT_EQ(error_of({{"tolerance", "inf"}}), "sample: tolerance = 'inf': expected a number in [0, 1]");
  EXPECT_EQ(error_of({{"tolerance", "1e-3x"}}), "sample: tolerance = '1e-3x': expected a number in [0, 1]");
  EXPECT_EQ(error_of({{"limit", "1.5"}}), "sample: limit = '1.5': expected an integer in [0, 2^63)");
  EXPECT_EQ(error_of({{"limit", "9223372036854775808"}}),
            "sample: limit = '9223372036854775808': expected an integer in [0, 2^63)");
  EXPECT_EQ(error_of({{"engine", "fast"}}), "sample: engine = 'fast': expected dense|kernel");
  EXPECT_EQ(error_of({{"polish", "1"}}), "sample: polish = '1': expected true or false");
  EXPECT_EQ(error_of({{"speed", "1"}}),
            "sample: unknown option 'speed'; known: tolerance, limit, polish, engine, inner");
}

TEST(SettingsTest, ErrorsNameTheSolverWhereSeveralHaveTheSameStruct) {
  const SolverDefinition first = with_settings<Sample>({.name = "first"});
  const SolverDefinition second = with_settings<Sample>({.name = "second"});
  for (const SolverDefinition* solver : {&first, &second}) {
    try {
      solver->changed_settings({{"limit", "-1"}});
      FAIL() << solver->name;
    } catch (const InputError& error) {
      EXPECT_EQ(error.what(), solver->name + ": limit = '-1': expected an integer in [0, 2^63)");
    }
  }
}

TEST(SettingsTest, DescriptionCarriesTypeRangeAndHelp) {
  const auto infos = describe_settings<Sample>();
  ASSERT_EQ(infos.size(), 5u);
  EXPECT_EQ(infos[0].type, "real");
  EXPECT_EQ(infos[0].range, "[0, 1]");
  EXPECT_EQ(infos[3].range, "dense|kernel");
  EXPECT_EQ(infos[3].default_value, "dense");
  EXPECT_EQ(infos[4].help, "help of inner");
}

}  // namespace
}  // namespace lcpbench::settings_test
