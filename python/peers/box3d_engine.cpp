// Box3D as an engine of `lcpbench capture` and `replay` (docs/reference/external.md). With Box3D's sources in the
// folder BOX3D:
//
//   cmake -S BOX3D -B box3d -DCMAKE_BUILD_TYPE=Release -DBOX3D_VALIDATE=OFF -DBOX3D_SAMPLES=OFF -DBOX3D_UNIT_TESTS=OFF
//   cmake --build box3d --target box3d
//   c++ -std=c++20 -O2 python/peers/box3d_engine.cpp -I BOX3D/include box3d/src/libbox3d.a -lpthread -o box3d_engine
//
// box3d_engine [SUBSTEPS]: 4 unless it is told. All settings are Box3D's, but for sleep, of which there is none. Box3D
// has gyroscopic torques of its own, so that those of the step's forces are left out. Impulses are not told: friction
// acts once for all points of two shapes. The solver's time is processor time of Box3D's whole step, also for finding
// contacts.
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include <box3d/box3d.h>
#include <box3d/collision.h>
#include <nlohmann/json.hpp>

using Json = nlohmann::json;

namespace {

b3Vec3 vector(const Json& numbers, std::size_t first = 0) {
  return {numbers[first].get<float>(), numbers[first + 1].get<float>(), numbers[first + 2].get<float>()};
}

Json list(const b3Vec3& v) { return {v.x, v.y, v.z}; }

b3Quat rotation(const Json& motion) { return {vector(motion, 4), motion[3].get<float>()}; }

double processor_time_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

class Engine {
 public:
  Engine(const Json& scene, int substeps) : step_(scene["step"].get<float>()), substeps_(substeps) {
    b3WorldDef world = b3DefaultWorldDef();
    world.gravity = {0, 0, 0};  // it comes with the forces
    world.enableSleep = false;
    world_ = b3CreateWorld(&world);
    b3ShapeDef shape = b3DefaultShapeDef();
    shape.updateBodyMass = false;
    shape.baseMaterial.friction = scene["mu"].get<float>();
    shape.baseMaterial.restitution = scene["restitution"].get<float>();
    for (const Json& each : scene["bodies"]) {
      const Json& motion = each["motion"];
      const bool moves = each["mass"] > 0;
      b3BodyDef definition = b3DefaultBodyDef();
      definition.type = moves ? b3_dynamicBody : b3_staticBody;
      definition.position = b3ToPos(vector(motion));
      definition.rotation = rotation(motion);
      definition.userData = reinterpret_cast<void*>(bodies_.size());
      const b3BodyId body = b3CreateBody(world_, &definition);
      for (const Json& part : each["parts"]) {
        if (part.contains("box")) {
          const b3Vec3 half = vector(part["box"]);
          const b3BoxHull box = b3MakeOffsetBoxHull(half.x, half.y, half.z, vector(part["offset"]));
          b3CreateHullShape(body, &shape, &box.base);
        } else {
          const b3Sphere sphere{vector(part["offset"]), part["sphere"].get<float>()};
          b3CreateSphereShape(body, &shape, &sphere);
        }
      }
      if (moves) {
        const b3Vec3 moments = vector(each["inertia"]);
        b3MassData mass{each["mass"].get<float>(), {0, 0, 0}, {}};
        mass.inertia.cx.x = moments.x, mass.inertia.cy.y = moments.y, mass.inertia.cz.z = moments.z;
        b3Body_SetMassData(body, mass);
        set_velocity(body, motion);
      }
      bodies_.push_back(body);
    }
  }

  Json step(const Json& forces) {
    std::vector<b3Pos> centres;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      centres.push_back(b3Body_GetPosition(bodies_[i]));
      b3Body_ApplyForceToCenter(bodies_[i], vector(forces[i]), true);
    }
    const double begin = processor_time_s();
    b3World_Step(world_, step_, substeps_);
    const double end = processor_time_s();
    Json motions = Json::array(), found = Json::array();
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const b3Quat q = b3Body_GetRotation(bodies_[i]);
      const b3Vec3 p = b3ToVec3(b3Body_GetPosition(bodies_[i])), v = b3Body_GetLinearVelocity(bodies_[i]),
                   w = b3Body_GetAngularVelocity(bodies_[i]);
      motions.push_back({p.x, p.y, p.z, q.s, q.v.x, q.v.y, q.v.z, v.x, v.y, v.z, w.x, w.y, w.z});
      add_contacts(i, centres[i], found);
    }
    return {{"contacts", found}, {"motions", motions}, {"solve_s", end - begin}};
  }

  Json place(const Json& motions) {
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      if (b3Body_GetType(bodies_[i]) != b3_dynamicBody) continue;
      b3Body_SetTransform(bodies_[i], b3ToPos(vector(motions[i])), rotation(motions[i]));
      set_velocity(bodies_[i], motions[i]);
    }
    return Json::object();
  }

 private:
  static void set_velocity(b3BodyId body, const Json& motion) {
    b3Body_SetLinearVelocity(body, vector(motion, 7));
    b3Body_SetAngularVelocity(body, vector(motion, 10));
  }

  /// Those whose first shape is of this body. @param centre  where it was as the step began
  void add_contacts(std::size_t body, const b3Pos& centre, Json& found) {
    contacts_.resize(static_cast<std::size_t>(b3Body_GetContactCapacity(bodies_[body])));
    const int count = b3Body_GetContactData(bodies_[body], contacts_.data(), static_cast<int>(contacts_.size()));
    for (int i = 0; i < count; ++i) {
      const b3ContactData& contact = contacts_[static_cast<std::size_t>(i)];
      const auto index = [](b3ShapeId shape) {
        return reinterpret_cast<std::size_t>(b3Body_GetUserData(b3Shape_GetBody(shape)));
      };
      if (index(contact.shapeIdA) != body) continue;
      for (int k = 0; k < contact.manifoldCount; ++k) {
        const b3Manifold& manifold = contact.manifolds[k];
        for (int n = 0; n < manifold.pointCount; ++n) {
          const b3ManifoldPoint& point = manifold.points[n];
          found.push_back({{"bodies", {index(contact.shapeIdB), body}},
                           {"point", list(b3ToVec3(b3OffsetPos(centre, point.anchorA)))},
                           {"normal", list(manifold.normal)},
                           {"gap", point.separation}});
        }
      }
    }
  }

  float step_;
  int substeps_;
  b3WorldId world_{};
  std::vector<b3BodyId> bodies_;
  std::vector<b3ContactData> contacts_;
};

}  // namespace

int main(int count, char** words) {
  std::unique_ptr<Engine> engine;
  for (std::string line; std::getline(std::cin, line);) {
    const Json question = Json::parse(line);
    Json answer;
    if (question["verb"] == "scene") {
      engine = std::make_unique<Engine>(question, count > 1 ? std::atoi(words[1]) : 4);
      const b3Version version = b3GetVersion();
      answer = {{"engine", "Box3D"},
                {"version", std::to_string(version.major) + "." + std::to_string(version.minor) + "." +
                                std::to_string(version.revision)}};
    } else {
      answer = question["verb"] == "step" ? engine->step(question["forces"]) : engine->place(question["motions"]);
    }
    std::cout << answer << std::endl;
  }
}
