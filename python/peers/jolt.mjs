// Jolt as an engine of `lcpbench capture` and `replay` (docs/reference/external.md): node --disable-wasm-trap-handler
// jolt.mjs MODULES, where npm's jolt-physics is in the folder MODULES. The handler reserves much memory. All settings
// are Jolt's, but for damping and sleep, of which there is none, and for thin boxes, whose convex radius is less than
// 5 cm. Impulses are not told: Jolt's friction acts on all points of two bodies together.
import fs from "node:fs";
import path from "node:path";
import readline from "node:readline";

const folder = path.resolve(process.argv[2], "jolt-physics");
const Jolt = await (await import(path.join(folder, "dist", "jolt-physics.wasm-compat.js"))).default();
const vector = (v) => new Jolt.Vec3(...v);
const numbers = (v) => [v.GetX(), v.GetY(), v.GetZ()];
const add = (a, b, scale = 1) => a.map((x, i) => x + scale * b[i]);
const cross = (a, b) => [0, 1, 2].map((i) => a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3]);
const turned = ([w, ...u], v) => add(v, add(cross(u, v).map((x) => w * x), cross(u, cross(u, v))), 2);

const settings = new Jolt.JoltSettings(); // one layer, in which all meet
const layers = new Jolt.ObjectLayerPairFilterTable(1);
layers.EnableCollision(0, 0);
const broad = new Jolt.BroadPhaseLayerInterfaceTable(1, 1);
broad.MapObjectToBroadPhaseLayer(0, new Jolt.BroadPhaseLayer(0));
settings.mObjectLayerPairFilter = layers;
settings.mBroadPhaseLayerInterface = broad;
settings.mObjectVsBroadPhaseLayerFilter = new Jolt.ObjectVsBroadPhaseLayerFilterTable(broad, 1, layers, 1);
const world = new Jolt.JoltInterface(settings);
const system = world.GetPhysicsSystem();
const bodies = system.GetBodyInterface();
system.SetGravity(vector([0, 0, 0])); // it comes with the forces

let step, ids, motions;

function compound(parts) {
  const all = new Jolt.StaticCompoundShapeSettings();
  for (const { sphere, box, offset } of parts) {
    const shape = sphere ? new Jolt.SphereShapeSettings(sphere)
      : new Jolt.BoxShapeSettings(vector(box), Math.min(0.05, 0.1 * Math.min(...box)));
    all.AddShapeShapeSettings(vector(offset), new Jolt.Quat(0, 0, 0, 1), shape, 0);
  }
  const shape = all.Create().Get();
  const shift = numbers(shape.GetCenterOfMass()).map((x) => -x);
  return new Jolt.OffsetCenterOfMassShape(shape, vector(shift)); // the origin is the centre of mass
}

function body_of({ mass, inertia, motion, parts }, scene) {
  const [x, y, z, qw, qx, qy, qz] = motion;
  const body = new Jolt.BodyCreationSettings(compound(parts), new Jolt.RVec3(x, y, z), new Jolt.Quat(qx, qy, qz, qw),
    mass > 0 ? Jolt.EMotionType_Dynamic : Jolt.EMotionType_Static, 0);
  [body.mFriction, body.mRestitution] = [scene.mu, scene.restitution];
  [body.mAllowSleeping, body.mLinearDamping, body.mAngularDamping] = [false, 0, 0];
  if (mass > 0) {
    body.mOverrideMassProperties = Jolt.EOverrideMassProperties_MassAndInertiaProvided;
    body.mMassPropertiesOverride.mMass = mass;
    inertia.forEach((moment, j) => body.mMassPropertiesOverride.mInertia.SetColumn4(j, new Jolt.Vec4(
      ...[0, 1, 2].map((i) => (i === j ? moment : 0)), 0)));
    body.mLinearVelocity = vector(motion.slice(7, 10));
    body.mAngularVelocity = vector(motion.slice(10));
  }
  return new Jolt.BodyID(bodies.CreateAndAddBody(body, Jolt.EActivation_Activate).GetIndexAndSequenceNumber());
}

// They stand in the cache of contacts, of which the interface for JavaScript has the saved bytes alone.
function contacts() {
  const bytes = [], found = [], recorder = new Jolt.StateRecorderJS();
  recorder.WriteBytes = (from, count) => bytes.push(...Jolt.HEAPU8.subarray(from, from + count));
  system.SaveState(recorder, Jolt.EStateRecorderState_Contacts);
  const view = new DataView(Uint8Array.from(bytes).buffer);
  const [integer, real] = [(at) => view.getUint32(at, true), (at) => view.getFloat32(at, true)];
  const three = (at) => [0, 4, 8].map((k) => real(at + k));
  const place = (k, local) => add(motions[k].slice(0, 3), turned(motions[k].slice(3, 7), local));
  const number = new Map(ids.map((id, k) => [id.GetIndexAndSequenceNumber() >>> 0, k]));
  let at = 5;
  for (let pairs = integer(1); pairs > 0; --pairs) {
    let manifolds = integer(at + 32); // after both bodies and their poses
    for (at += 36; manifolds > 0; --manifolds) {
      const [a, b, points] = [number.get(integer(at)), number.get(integer(at + 8)), view.getUint16(at + 16, true)];
      const normal = turned(motions[b].slice(3, 7), three(at + 18)); // from a into b
      for (let point = at + 42; point < at + 42 + 28 * points; point += 28) {
        const [on_a, on_b] = [place(a, three(point)), place(b, three(point + 12))];
        const gap = add(on_b, on_a, -1).reduce((sum, x, i) => sum + x * normal[i], 0);
        found.push({ bodies: [b, a], point: add(on_a, on_b).map((x) => x / 2), normal, gap });
      }
      at += 42 + 28 * points;
    }
  }
  return found;
}

const answers = {
  scene(scene) {
    [step, motions] = [scene.step, scene.bodies.map((body) => body.motion)];
    ids = scene.bodies.map((body) => body_of(body, scene));
    return { engine: "Jolt", version: JSON.parse(fs.readFileSync(path.join(folder, "package.json"))).version };
  },
  step({ forces }) {
    forces.forEach((force, k) => bodies.AddForce(ids[k], vector(force.slice(0, 3))));
    forces.forEach((force, k) => bodies.AddTorque(ids[k], vector(force.slice(3))));
    world.Step(step, 1);
    const found = contacts();
    motions = ids.map((id) => {
      const q = bodies.GetRotation(id), vectors = [bodies.GetLinearVelocity(id), bodies.GetAngularVelocity(id)];
      return [...numbers(bodies.GetPosition(id)), q.GetW(), q.GetX(), q.GetY(), q.GetZ(), ...vectors.flatMap(numbers)];
    });
    return { contacts: found, motions };
  },
  place(told) {
    ({ motions } = told);
    motions.forEach(([x, y, z, qw, qx, qy, qz, ...velocity], k) => {
      bodies.SetPositionAndRotation(ids[k], new Jolt.RVec3(x, y, z), new Jolt.Quat(qx, qy, qz, qw), 0);
      bodies.SetLinearAndAngularVelocity(ids[k], vector(velocity.slice(0, 3)), vector(velocity.slice(3)));
    });
    return {};
  },
};

for await (const line of readline.createInterface({ input: process.stdin })) {
  const question = JSON.parse(line);
  console.log(JSON.stringify(answers[question.verb](question)));
}
