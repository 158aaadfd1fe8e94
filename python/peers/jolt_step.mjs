// A step of Jolt for jolt_step.py: jolt_step.mjs PACKAGE. A line of standard input holds bodies, mu of contacts and
// the places of balls, and is answered with {}; or {"step": SECONDS, "iterations": N}, answered with impulses.
import readline from "node:readline";

const Jolt = await (await import(process.argv[2])).default();
const vector = (v) => new Jolt.Vec3(...v);
const turned = new Jolt.Quat(0, 0, 0, 1);
let added = [], balls, coefficients; // balls: the first one of a pair, by its body and its part of the shape

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
system.SetGravity(vector([0, 0, 0]));

// User data of a ball: twice its contact, counted from 1, plus its side. It meets the other of its contact.
const filter = new Jolt.SimShapeFilterJS();
const contact = (shape) => Jolt.wrapPointer(shape, Jolt.Shape).GetUserData() >> 1;
filter.ShouldCollide = (_1, a, _2, _3, b) => !contact(a) || !contact(b) || contact(a) === contact(b);
const listener = new Jolt.ContactListenerJS();
listener.OnContactValidate = () => Jolt.ValidateResult_AcceptAllContactsForThisBodyPair;
listener.OnContactPersisted = listener.OnContactRemoved = () => {};
listener.OnContactAdded = (first, _, manifold, chosen) => {
  const body = Jolt.wrapPointer(first, Jolt.Body), part = Jolt.wrapPointer(manifold, Jolt.ContactManifold).mSubShapeID1;
  const ball = body.GetShape().GetSubShapeUserData(part);
  balls.set([body.GetID().GetIndexAndSequenceNumber(), part.GetValue()].map((each) => each >>> 0).join(), ball);
  Jolt.wrapPointer(chosen, Jolt.ContactSettings).mCombinedFriction = coefficients[(ball >> 1) - 1];
};
system.SetSimShapeFilter(filter);
system.SetContactListener(listener);

function load(scene) {
  for (const id of added) {
    bodies.RemoveBody(id);
    bodies.DestroyBody(id);
  }
  [added, balls, coefficients] = [[], new Map(), scene.mu];
  for (const [k, body] of [...scene.bodies.entries(), [-1, { position: [0, 0, 0] }]]) {
    const compound = new Jolt.StaticCompoundShapeSettings();
    const own = scene.places.filter((place) => place.body === k);
    for (const place of own) {
      const sphere = new Jolt.SphereShapeSettings(place.radius);
      sphere.mUserData = place.ball;
      compound.AddShapeShapeSettings(vector(place.centre), turned, sphere, 0);
    }
    if (own.length === 0) continue; // nothing touches it
    const shape = compound.Create().Get();
    const centre = shape.GetCenterOfMass();
    const shifted = new Jolt.OffsetCenterOfMassShape(shape, vector([-centre.GetX(), -centre.GetY(), -centre.GetZ()]));
    const made = new Jolt.BodyCreationSettings(shifted, new Jolt.RVec3(...body.position), turned,
      k < 0 ? Jolt.EMotionType_Static : Jolt.EMotionType_Dynamic, 0);
    made.mUseManifoldReduction = false; // contacts stay apart
    if (k >= 0) {
      made.mOverrideMassProperties = Jolt.EOverrideMassProperties_MassAndInertiaProvided;
      made.mMassPropertiesOverride.mMass = body.mass;
      body.inertia.forEach((column, j) =>
        made.mMassPropertiesOverride.mInertia.SetColumn4(j, new Jolt.Vec4(...column, 0)));
      made.mLinearVelocity = vector(body.linear_velocity);
      made.mAngularVelocity = vector(body.angular_velocity);
      made.mLinearDamping = made.mAngularDamping = 0;
    }
    added.push(bodies.CreateBody(made).GetID());
    bodies.AddBody(added.at(-1), k < 0 ? Jolt.EActivation_DontActivate : Jolt.EActivation_Activate);
  }
}

// Of each contact the first ball, the normal, two friction impulses and the normal impulse. They stand in the cache of
// contacts, of which the interface for JavaScript has the saved bytes alone.
function solve({ step, iterations }) {
  const chosen = system.GetPhysicsSettings();
  chosen.mNumVelocitySteps = iterations;
  system.SetPhysicsSettings(chosen);
  world.Step(step, 1);
  const bytes = [], found = [];
  const recorder = new Jolt.StateRecorderJS();
  recorder.WriteBytes = (from, count) => bytes.push(...Jolt.HEAPU8.subarray(from, from + count));
  system.SaveState(recorder, Jolt.EStateRecorderState_Contacts);
  const view = new DataView(Uint8Array.from(bytes).buffer);
  const [integer, real] = [(at) => view.getUint32(at, true), (at) => view.getFloat32(at, true)];
  let at = 5;
  for (let pairs = integer(1); pairs > 0; --pairs) {
    let manifolds = integer(at + 32); // after both bodies and their poses
    for (at += 36; manifolds > 0; --manifolds, at += 70) { // two balls touch at one point
      const ball = balls.get([integer(at), integer(at + 4)].join());
      found.push([ball, ...[18, 22, 26, 30, 34, 66].map((k) => real(at + k))]);
    }
  }
  return found;
}

for await (const line of readline.createInterface({ input: process.stdin })) {
  const request = JSON.parse(line);
  console.log(JSON.stringify(request.step ? solve(request) : load(request) ?? {}));
}
