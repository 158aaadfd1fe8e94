#include "generators/made/made.h"

#include "core/error.h"
#include "generators/made/scene.h"

namespace lcpbench {

namespace made {  // the functions that make a class's scene: masonry.cpp, rows_and_nets.cpp, piles.cpp, machines.cpp
using Build = void(Scene&);
Build build_arch, build_bridge, build_cards, build_dome, build_drystone, build_tower;
Build build_cradle, build_islands, build_net, build_patch, build_pipe, build_sticks;
Build build_packing, build_robot_pile;
Build build_gears, build_hand, build_ragdolls, build_robot, build_tracks;
}  // namespace made

namespace {

template <int kContacts, int kMassRatio>
struct MadeSettings {
  MadeReading reading{.nc_max = kContacts, .mass_ratio = kMassRatio};

  void visit(auto&& field) {
    field("nc_min", reading.nc_min, IntegerRange{1, 20'000}, "the fewest contacts that are aimed at, nc_max if less");
    field("nc_max", reading.nc_max, IntegerRange{1, 20'000}, "the most contacts that are aimed at");
    field("mu_min", reading.mu_min, RealRange{0, 5}, "least friction coefficient");
    field("mu_max", reading.mu_max, RealRange{0, 5}, "largest friction coefficient");
    field("edges", reading.edges,
          Choices<MadeEdges>{{{"drawn", MadeEdges::kDrawn},
                              {"0", MadeEdges::k0},
                              {"2", MadeEdges::k2},
                              {"4", MadeEdges::k4},
                              {"6", MadeEdges::k6},
                              {"8", MadeEdges::k8},
                              {"12", MadeEdges::k12},
                              {"16", MadeEdges::k16}}},
          "of the friction pyramid; 0: no friction");
    field("offsets", reading.offsets, RealRange{0, 1}, "largest share of contacts with an offset");
    field("mass_ratio", reading.mass_ratio, RealRange{1, 1e6}, "largest ratio of the masses of equal bodies");
    field("motion", reading.motion,
          Choices<MadeMotion>{{{"drawn", MadeMotion::kDrawn},
                               {"rest", MadeMotion::kRest},
                               {"slide", MadeMotion::kSlide},
                               {"impact", MadeMotion::kImpact}}},
          "velocities beside one step of gravity: none, slow ones, fast ones");
  }
};

enum class Use { kFit, kHeldOut };

template <int kContacts, int kMassRatio>
MadeSet made_set(const std::string& name, Use use, void (*build)(made::Scene&), const std::string& summary) {
  const std::string full = std::string("made/") + name;
  MadeSet set{full, full, summary, {build, kContacts, use == Use::kHeldOut}};
  using Settings = MadeSettings<kContacts, kMassRatio>;
  read_options_as<Settings>(set);
  set.parse = [](std::string_view owner, const Options& options) {
    const MadeReading reading = parse_settings<Settings>(owner, options).reading;
    if (reading.mu_min > reading.mu_max) throw InputError(std::string(owner) + ": mu_min is above mu_max");
    return reading;
  };
  return set;
}

}  // namespace

const std::vector<MadeSet>& made_sets() {
  using namespace made;
  static const std::vector<MadeSet> sets{
      made_set<1'000, 10>("arch", Use::kFit, build_arch, "voussoirs of an arch"),
      made_set<3'000, 1'000>("bridge", Use::kFit, build_bridge, "planks on girders, with loads"),
      made_set<1'000, 1>("cards", Use::kFit, build_cards, "a house of cards"),
      made_set<5'000, 1'000'000>("cradle", Use::kHeldOut, build_cradle, "a row of balls, run into by the first ones"),
      made_set<8'000, 10>("dome", Use::kHeldOut, build_dome, "rings of blocks"),
      made_set<5'000, 10>("drystone", Use::kHeldOut, build_drystone, "a wall of rough stones, each contact has its mu"),
      made_set<2'000, 100>("gears", Use::kFit, build_gears, "a train of gears on pins"),
      made_set<300, 1'000>("hand", Use::kFit, build_hand,
                       "fingers around a ball, the hand one block of up to 66 coordinates and condition 1e6"),
      made_set<20'000, 1'000'000>("islands", Use::kFit, build_islands, "many small groups"),
      made_set<3'000, 100>("net", Use::kHeldOut, build_net, "a hanging net of coupled balls"),
      made_set<20'000, 1'000>("packing", Use::kFit, build_packing, "balls and cubes in a box, most under a heavy lid"),
      made_set<5'000, 1>("patch", Use::kHeldOut, build_patch, "one body on many contacts"),
      made_set<10'000, 1'000>("pipe", Use::kFit, build_pipe, "a chain of balls in a pipe"),
      made_set<1'000, 100>("ragdolls", Use::kHeldOut, build_ragdolls, "a heap of robots"),
      made_set<1'000, 10>("robot", Use::kFit, build_robot,
                         "a robot on uneven ground, one block of up to 200 coordinates and condition 1e6"),
      made_set<2'000, 10>("robot-pile", Use::kHeldOut, build_robot_pile, "a robot on a heap of balls"),
      made_set<3'000, 10>("sticks", Use::kHeldOut, build_sticks, "layers of rods, crosswise"),
      made_set<1'000, 1'000'000>("tower", Use::kFit, build_tower, "boxes on one another"),
      made_set<2'000, 100>("tracks", Use::kHeldOut, build_tracks, "a vehicle on two chains of shoes"),
  };
  return sets;
}

MadeSample draw_made(const MadeSet& set, const MadeReading& reading, std::uint64_t seed, std::uint64_t trial) {
  made::Scene scene(reading, {stream_id(set.stream), seed, trial});
  set.features.build(scene);
  return scene.finish();
}

}  // namespace lcpbench
