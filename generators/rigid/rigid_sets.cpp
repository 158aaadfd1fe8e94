#include <utility>

#include "generators/rigid/rigid.h"

namespace lcpbench {
namespace {

template <RigidFeatures kFeatures>
struct RigidSettings {
  RigidReading reading;

  void visit(auto&& field) {
    if constexpr (kFeatures.redundant) {
      field("redundancy", reading.redundancy,
            Choices<Redundancy>{{{"multiple", Redundancy::kMultiple}, {"combination", Redundancy::kCombination}}},
            "a dependent contact repeats an independent one, or lies between two of the same bodies and normal");
    }
    field("normals", reading.normals,
          Choices<NormalReading>{{{"general", NormalReading::kGeneral}, {"axis", NormalReading::kAxis}}},
          "contact normals in any direction (of length 1 within 1e-12), or along the axes (of length 1 exactly)");
    if constexpr (kFeatures.frictional) {
      field("edges", reading.edges,
            Choices<PyramidEdges>{{{"4", PyramidEdges::k4}, {"8", PyramidEdges::k8}, {"16", PyramidEdges::k16}}},
            "of the friction pyramid: 4 is a scene; more is another model, which engines do not have");
    }
    field("bodies_max", reading.bodies_max, IntegerRange{1, 16}, "ceiling of the number of bodies");
    field("nc_max", reading.nc_max, IntegerRange{2, 200}, "ceiling of the number of contacts");
  }
};

template <RigidFeatures kFeatures>
RigidSet make_set(std::string name, std::string stream, std::string summary, double condition = 0) {
  using Settings = RigidSettings<kFeatures>;
  RigidSet set{std::move(name), std::move(stream), std::move(summary), kFeatures, condition};
  read_options_as<Settings>(set);
  return set;
}

// The random stream is that of the frictionless set: friction is added to the same scenes.
template <bool kFrictional>
void add_sets(const std::string& prefix, std::vector<RigidSet>& sets) {
  constexpr RigidFeatures kPlain{.frictional = kFrictional};
  constexpr RigidFeatures kRedundant{.frictional = kFrictional, .redundant = true};
  constexpr RigidFeatures kConditioned{.frictional = kFrictional, .redundant = true, .conditioned = true};
  sets.push_back(make_set<kPlain>(prefix + "exp1", "rigid/exp1", "rigid bodies, independent contacts"));
  sets.push_back(make_set<kRedundant>(prefix + "exp2", "rigid/exp2", "rigid bodies, redundant contacts"));
  for_each_conditioned_experiment(prefix, "rigid/", [&](auto&&... arguments) {
    sets.push_back(make_set<kConditioned>(std::forward<decltype(arguments)>(arguments)...));
  });
}

}  // namespace

const std::vector<RigidSet>& rigid_sets() {
  static const std::vector<RigidSet> sets = [] {
    std::vector<RigidSet> all;
    add_sets<false>("rigid/", all);
    add_sets<true>("rigid/frictional/", all);
    return all;
  }();
  return sets;
}

}  // namespace lcpbench
