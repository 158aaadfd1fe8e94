// Draws solids, dots and arrows from a point of view. One WebGL context serves all pictures of a page, since browsers
// allow few.
import {
  AmbientLight, BoxGeometry, BufferGeometry, CapsuleGeometry, CircleGeometry, Color, ConeGeometry, CylinderGeometry,
  DirectionalLight, DoubleSide, EdgesGeometry, FrontSide, InstancedMesh, LineBasicMaterial, LineSegments, Matrix4, Mesh,
  MeshBasicMaterial, MeshLambertMaterial, PerspectiveCamera, Quaternion, Scene, Sphere, SphereGeometry, Vector3,
  WebGLRenderer,
} from "three";
import { ConvexGeometry } from "three/examples/jsm/geometries/ConvexGeometry.js";

const fieldOfView = 30;  // degrees
const axisZ = new Vector3(0, 0, 1);
export const vector = (numbers) => new Vector3(...numbers);

let shared;
/** The renderer; null where the browser has no WebGL 2. */
export function renderer() {
  if (shared !== undefined) return shared;
  const canvas = document.createElement("canvas");
  const context = canvas.getContext("webgl2", { alpha: true, antialias: true, preserveDrawingBuffer: true });
  if (!context) return (shared = null);
  shared = new WebGLRenderer({ canvas, context });
  shared.setClearColor(0, 0);
  return shared;
}

const makers = {
  box: ([a, b, c]) => new BoxGeometry(2 * a, 2 * b, 2 * c),
  sphere: ([r]) => new SphereGeometry(r, 24, 16),
  capsule: ([r, half]) => new CapsuleGeometry(r, 2 * half, 8, 20).rotateX(Math.PI / 2),
  cylinder: ([r, half]) => new CylinderGeometry(r, r, 2 * half, 32).rotateX(Math.PI / 2),
  plane: () => new CircleGeometry(1, 64),
  hull: (size) => {
    try {
      return new ConvexGeometry(cornersOf(size));
    } catch {  // all corners on a line
      return new BufferGeometry().setFromPoints(cornersOf(size));
    }
  },
};
const cornersOf = (size) => Array.from({ length: size.length / 3 }, (_, i) => vector(size.slice(3 * i, 3 * i + 3)));
const radii = {
  box: (size) => Math.hypot(...size), sphere: ([r]) => r, capsule: ([r, half]) => r + half,
  cylinder: ([r, half]) => Math.hypot(r, half), plane: () => Infinity,
  hull: (size) => Math.max(...cornersOf(size).map((corner) => corner.length())),
};

/** The shapes of a view as solids. The ground are planes, and what stands still and is much larger than the median of what
 *  moves. @param moving  bodies; none: not known, what is that large counts as still */
export function solidsOf(shapes, moving) {
  const radiusOf = ({ type, size }) => radii[type](size);
  const moves = ({ body }) => body >= 0 && (!moving.length || moving.includes(body));
  const sizes = shapes.filter(moves).map(radiusOf).filter(Number.isFinite).sort((a, b) => a - b);
  const usual = sizes[Math.floor((sizes.length - 1) / 2)] ?? 1;
  return shapes.map((shape) => {
    const geometry = makers[shape.type](shape.size);
    return { body: shape.body, plane: shape.type === "plane" && shape.size, geometry, edges: new EdgesGeometry(geometry, 45),
      still: !moves(shape), ground: !(radiusOf(shape) <= 4 * usual) && !(moving.length && moves(shape)) };
  });
}

/** The solids that stand somewhere: those of the world, and those of bodies with a pose. */
export const placedSolids = (solids, poses) => solids.filter(({ body }) => body < 0 || poses[body]);

/** The box around a solid that stands in a pose. */
export function boxOf(solid, pose) {
  solid.geometry.computeBoundingBox();
  return solid.geometry.boundingBox.clone().applyMatrix4(placed(pose));
}

/** The matrix of a pose [x, y, z, quaternion w, x, y, z]; of null, for shapes of the world, the world's own axes. */
function placed(pose) {
  const matrix = new Matrix4();
  if (!pose) return matrix;
  const [x, y, z, w, i, j, k] = pose;
  return matrix.compose(vector([x, y, z]), new Quaternion(i, j, k, w).normalize(), vector([1, 1, 1]));
}

/** The matrix of a plane's disc: it lies below the middle of the picture, and reaches far beyond the frame. */
function discOf([x, y, z, offset], pose, orbit) {
  const normal = vector([x, y, z]);
  const turn = new Quaternion().setFromUnitVectors(axisZ, normal.clone().normalize());
  const frame = placed(pose).multiply(new Matrix4().compose(normal.multiplyScalar(offset), turn, vector([1, 1, 1])));
  const middle = orbit.centre.clone().applyMatrix4(frame.clone().invert()).setZ(0);
  const reach = 12 * orbit.radius;
  return frame.multiply(new Matrix4().compose(middle, new Quaternion(), vector([reach, reach, 1])));
}

/** A point of view that circles around a box. */
export class Orbit {
  constructor(gravity, box) {
    this.up = gravity && vector(gravity).length() > 0 ? vector(gravity).normalize().negate() : axisZ.clone();
    this.surround(box);
    this.across = new Vector3(1, 0, 0).projectOnPlane(this.up);
    if (this.across.length() < 0.1) this.across = new Vector3(0, 1, 0).projectOnPlane(this.up);
    this.across.normalize();
    this.along = this.up.clone().cross(this.across);
    this.reset();
  }
  /** What the camera shows at zoom 1. */
  surround(box) {
    this.box = box;
    this.empty = box.isEmpty();
    const around = box.getBoundingSphere(new Sphere());
    this.centre = around.center;
    this.radius = this.empty ? 1 : Math.max(1e-6, around.radius);
    const half = box.getSize(new Vector3()).multiplyScalar(0.5);
    this.corners = this.empty ? [] : Array.from({ length: 8 }, (_, i) =>
      vector([i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1]).multiply(half));
  }
  reset() {
    Object.assign(this, { azimuth: -1.05, elevation: 0.3, zoom: 1 });
  }
  turn(azimuth, elevation) {
    this.azimuth += azimuth;
    this.elevation = Math.min(1.5, Math.max(-0.3, this.elevation + elevation));
  }
  scale(factor) {
    this.zoom = Math.min(50, Math.max(0.2, this.zoom * factor));
  }
  /** At zoom 1 as near as the whole box fits into the picture. */
  camera(aspect) {
    const away = this.across.clone().multiplyScalar(Math.cos(this.elevation) * Math.cos(this.azimuth))
      .addScaledVector(this.along, Math.cos(this.elevation) * Math.sin(this.azimuth))
      .addScaledVector(this.up, Math.sin(this.elevation));
    const right = this.up.clone().cross(away).normalize();
    const upwards = away.clone().cross(right);
    const slope = Math.tan((fieldOfView * Math.PI) / 360);
    const fits = this.corners.map((corner) => corner.dot(away) + Math.max(
      Math.abs(corner.dot(right)) / (slope * aspect), Math.abs(corner.dot(upwards)) / slope));
    const distance = Math.max(this.radius, 1.06 * Math.max(...fits)) / this.zoom;
    const camera = new PerspectiveCamera(fieldOfView, aspect, distance / 100, distance + 60 * this.radius);
    camera.up.copy(this.up);
    camera.position.copy(this.centre).addScaledVector(away, distance);
    camera.lookAt(this.centre);
    camera.updateMatrixWorld();
    return camera;
  }
}

/** Draws into a canvas of the page. drawing: {solids: [{solid, pose, color}], dots: [{at, size, color}], arrows: [{from,
    to, width, color}], theme}. @returns pixel(point), for finding what is pointed at */
export function paint(canvas, orbit, drawing) {
  const ratio = Math.min(2, window.devicePixelRatio || 1);
  const width = Math.max(1, Math.round(canvas.clientWidth * ratio));
  const height = Math.max(1, Math.round(canvas.clientHeight * ratio));
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  const camera = orbit.camera(width / height);
  const context = canvas.getContext("2d");
  context.clearRect(0, 0, width, height);
  const pixel = (point) => {
    const p = point.clone().project(camera);
    return { x: ((p.x + 1) / 2) * width, y: ((1 - p.y) / 2) * height, ratio };
  };
  if (!renderer()) return pixel;
  renderer().setSize(width, height, false);
  const scene = sceneOf(drawing, orbit, camera);
  renderer().render(scene, camera);
  context.drawImage(renderer().domElement, 0, 0);
  scene.traverse((object) => object.isInstancedMesh && object.dispose());
  return pixel;
}

const shaft = new CylinderGeometry(1, 1, 1, 10).rotateX(Math.PI / 2).translate(0, 0, 0.5);
const head = new ConeGeometry(1, 1, 14).rotateX(Math.PI / 2).translate(0, 0, 0.5);
const ball = new SphereGeometry(1, 14, 10);
const materials = new Map();
function material(Kind, options) {
  const key = Kind.name + JSON.stringify(options);
  if (!materials.has(key)) materials.set(key, new Kind(options));
  return materials.get(key);
}

function sceneOf({ solids, dots, arrows, theme }, orbit, camera) {
  const scene = new Scene();
  const sun = new DirectionalLight(0xffffff, 2.2);
  sun.position.copy(camera.position).addScaledVector(orbit.up, 2 * orbit.radius).sub(orbit.centre);
  scene.add(new AmbientLight(0xffffff, 1.4), sun);
  for (const { solid, pose, color } of solids) {
    const matrix = solid.plane ? discOf(solid.plane, pose, orbit) : placed(pose);
    // What stands still may hide what moves: one looks through it.
    const fill = solid.ground ? { color: theme.ground, opacity: 0.5 } : { color, opacity: solid.still ? 0.3 : 1 };
    const mesh = new Mesh(solid.geometry, material(MeshLambertMaterial, {
      ...fill, transparent: fill.opacity < 1, side: solid.plane ? DoubleSide : FrontSide, depthWrite: fill.opacity === 1,
      polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 }));
    const lines = new LineSegments(solid.edges, material(LineBasicMaterial, { color: theme.edge }));
    for (const object of solid.ground ? [mesh] : [mesh, lines]) {
      object.matrixAutoUpdate = false;
      object.matrix.copy(matrix);
      object.renderOrder = fill.opacity < 1 ? -1 : 0;
      scene.add(object);
    }
  }
  const many = (geometry, items, place) => {
    if (items.length === 0) return;
    const mesh = new InstancedMesh(geometry, material(MeshBasicMaterial, { depthTest: false, transparent: true }),
      items.length);
    items.forEach((item, i) => {
      mesh.setMatrixAt(i, place(item));
      mesh.setColorAt(i, new Color(item.color));
    });
    mesh.frustumCulled = false;
    mesh.renderOrder = 1;
    scene.add(mesh);
  };
  const directed = (from, to, thick, long) => new Matrix4().compose(from,
    new Quaternion().setFromUnitVectors(axisZ, to.clone().sub(from).normalize()), new Vector3(thick, thick, long));
  const tip = ({ from, to, width }) => from.clone().lerp(to, Math.max(0, 1 - (4 * width) / from.distanceTo(to)));
  many(shaft, arrows, (arrow) => directed(arrow.from, arrow.to, 0.7 * arrow.width, arrow.from.distanceTo(tip(arrow))));
  many(head, arrows, (arrow) => directed(tip(arrow), arrow.to, 2 * arrow.width, tip(arrow).distanceTo(arrow.to)));
  many(ball, dots, ({ at, size }) => new Matrix4().compose(at, new Quaternion(), new Vector3(size, size, size)));
  return scene;
}
