// What is drawn: bodies, arms, paths, domain and flow as objects of three.js, and the camera that turns around them.

const FIELD_OF_VIEW = (35 * Math.PI) / 180;
const MOST_PATH_LINES = 6000; // of all bodies: more stutter without a graphics card

/** Turns around a target with `up` upwards on the screen; the longest axis of what is shown lies to the right. */
class Orbit {
  constructor(extent, up) {
    const size = plus(extent.high, extent.low, -1);
    const longest = size.indexOf(Math.max(...size));
    this.up = Math.hypot(...up) > 0 ? normalised(up) : unitVector(longest === 2 ? 0 : 2);
    const level = (axis) => plus(unitVector(axis), this.up, -dot(unitVector(axis), this.up));
    const along = Math.hypot(...level(longest)) > 0.1 ? longest : (longest + 1) % 3;
    this.right = normalised(level(along));
    this.front = cross(this.right, this.up);
    this.frame(extent, 1);
  }

  /** Looks at the whole of an extent; `aspect`: width of the picture divided by its height. */
  frame({ low, high }, aspect) {
    this.target = scaled(plus(low, high), 0.5);
    this.radius = Math.hypot(...plus(high, low, -1)) / 2 || 1;
    this.azimuth = 0.5;
    this.elevation = 0.35;
    const slope = Math.tan(FIELD_OF_VIEW / 2);
    const { right, up } = this.screen;
    const distances = [0, 1, 2, 3, 4, 5, 6, 7].map((corner) => {
      const point = plus([0, 1, 2].map((k) => ((corner >> k) & 1 ? high : low)[k]), this.target, -1);
      const beside = Math.max(Math.abs(dot(point, right)) / aspect, Math.abs(dot(point, up)));
      return dot(point, this.outwards) + beside / slope;
    });
    this.distance = 1.14 * Math.max(...distances);
  }

  /** Towards the eye. */
  get outwards() {
    const level = plus(scaled(this.front, Math.cos(this.azimuth)), this.right, Math.sin(this.azimuth));
    return plus(scaled(level, Math.cos(this.elevation)), this.up, Math.sin(this.elevation));
  }

  get eye() {
    return plus(this.target, this.outwards, this.distance);
  }

  /** Right and upwards on the screen. */
  get screen() {
    const right = normalised(cross(this.up, this.outwards));
    return { right, up: cross(this.outwards, right) };
  }

  /** Turns what is shown, by angles in radians. */
  turn(right, down) {
    this.azimuth -= right;
    this.elevation = Math.max(-1.55, Math.min(1.55, this.elevation + down));
  }

  /** Moves what is shown by shares of the picture's height. */
  pan(right, up) {
    const height = 2 * this.distance * Math.tan(FIELD_OF_VIEW / 2);
    this.target = plus(plus(this.target, this.screen.right, -right * height), this.screen.up, -up * height);
  }

  zoom(factor) {
    this.distance = Math.max(0.01 * this.radius, Math.min(30 * this.radius, this.distance * factor));
  }
}

const unitVector = (axis) => [0, 1, 2].map((k) => (k === axis ? 1 : 0));

/** Corners of the rectangle between two extents along the axes u and v, in order; elsewhere it is at `base`. */
function rectangle(base, u, v, { low, high }) {
  return [[0, 0], [1, 0], [1, 1], [0, 1]].map(([a, b]) => {
    const point = [...base];
    point[u] = (a ? high : low)[u];
    point[v] = (b ? high : low)[v];
    return point;
  });
}

/** The sets of mirror planes whose image of a body is another body: lists of axes, the empty one first. */
function imagesOf(points, box) {
  const axes = box ? box.symmetry.map((name) => "xyz".indexOf(name)) : [];
  const beside = (axis) => points.some((point) => Math.abs(2 * point[axis] - box.size[axis]) > 1e-3 * box.size[axis]);
  return axes.reduce((sets, axis) => (beside(axis) ? [...sets, ...sets.map((set) => [...set, axis])] : sets), [[]]);
}

const mirrored = (point, axes, box) => point.map((value, k) => (axes.includes(k) ? box.size[k] - value : value));

/** Orientation of the image behind planes with these normals: each reverses the two other components of (x, y, z). */
function mirroredTurn([w, ...vector], axes) {
  return [w, ...vector.map((value, k) => (axes.filter((axis) => axis !== k).length % 2 ? -value : value))];
}

const SMOOTH = Math.cos(0.7); // of the angle between triangles; sharper edges are seen

/** The closed surface of a body, in its frame. */
class Surface {
  constructor({ radius, points, triangles }) {
    this.radius = radius;
    const numbers = new Float32Array(bytesOf(points).buffer);
    this.points = Array.from({ length: numbers.length / 3 }, (_, k) => Array.from(numbers.subarray(3 * k, 3 * k + 3)));
    this.triangles = new Uint32Array(bytesOf(triangles).buffer);
    this.reach = Math.max(...this.points.map((point) => Math.hypot(...point)));
  }

  /** `image`: axes along which it is mirrored; `marked`: with two darker quarters around its z axis. */
  geometry(THREE, image, marked) {
    const points = this.points.map((point) => point.map((value, k) => (image.includes(k) ? -value : value)));
    const meeting = points.map(() => []);
    const faces = [];
    for (let at = 0; at < this.triangles.length; at += 3) {
      const corners = [...this.triangles.subarray(at, at + 3)];
      if (image.length % 2) corners.reverse();
      const [a, b, c] = corners.map((corner) => points[corner]);
      const area = cross(plus(b, a, -1), plus(c, a, -1));
      const middle = plus(plus(a, b), c);
      faces.push({ corners, area, normal: normalised(area), shade: marked && middle[0] * middle[1] > 0 ? 0.77 : 1 });
      corners.forEach((corner) => meeting[corner].push(faces[faces.length - 1]));
    }
    const attributes = { position: [], normal: [], color: [] };
    for (const { corners, normal, shade } of faces) {
      for (const corner of corners) {
        const alike = meeting[corner].filter((face) => dot(face.normal, normal) > SMOOTH);
        attributes.position.push(...points[corner]);
        attributes.normal.push(...normalised(alike.reduce((sum, face) => plus(sum, face.area), [0, 0, 0])));
        attributes.color.push(shade, shade, shade);
      }
    }
    const geometry = new THREE.BufferGeometry();
    for (const [name, values] of Object.entries(attributes))
      geometry.setAttribute(name, new THREE.Float32BufferAttribute(values, 3));
    return geometry;
  }
}

class Stage {
  constructor(THREE, canvas, scene, motion) {
    Object.assign(this, { THREE, scene, motion });
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
    this.camera = new THREE.PerspectiveCamera((FIELD_OF_VIEW * 180) / Math.PI, 1, 0.1, 10);
    this.world = new THREE.Scene();
    this.light = new THREE.DirectionalLight(0xffffff, 0.5);
    this.world.add(new THREE.HemisphereLight(0xffffff, 0x8090a0, 0.62), this.light);
    this.colours = { lines: [], faces: [], mirrors: [], obstacles: [] };
    this.pathLooks = [0, 1, 2].map(() => new THREE.LineBasicMaterial({ transparent: true, opacity: 0.6 }));
    this.surfaces = scene.surfaces.map((surface) => new Surface(surface));
    this.shapes = scene.bodies.map((body) => this.surfaces[body.surface]);
    this.extent = motion.extent(this.shapes);
    this.addBodies();
    this.addDomain();
    this.addPaths();
    this.addFlow();
  }

  close() {
    this.renderer.dispose();
    this.renderer.forceContextLoss();
  }

  /** Other samples of the same bodies. */
  replaceMotion(motion) {
    this.motion = motion;
    this.extent = motion.extent(this.shapes);
    this.addPaths();
  }

  /** Instances of a geometry with an entry each in `entries`. */
  instances(geometry, entries, look = {}) {
    const material = new this.THREE.MeshLambertMaterial(look);
    const mesh = new this.THREE.InstancedMesh(geometry, material, entries.length);
    mesh.frustumCulled = false;
    mesh.userData = entries;
    this.world.add(mesh);
    return mesh;
  }

  addBodies() {
    const { THREE, scene, motion } = this;
    const least = 0.004 * Math.hypot(...plus(this.extent.high, this.extent.low, -1));
    this.entries = scene.bodies.flatMap(({ surface, colour }, body) =>
      imagesOf([motion.sampled(0, body)], scene.box).map((image) => {
        return { body, image, colour, surface, scale: Math.max(1, least / this.surfaces[surface].reach) };
      })
    );
    const alike = new Map();
    for (const entry of this.entries) {
      const key = [entry.surface, entry.colour, ...entry.image].join();
      alike.set(key, [...(alike.get(key) || []), entry]);
    }
    const marked = motion.turns.size > 0; // so that one sees how they turn
    this.beads = [...alike.values()].map((entries) => {
      const geometry = this.surfaces[entries[0].surface].geometry(THREE, entries[0].image, marked);
      return this.instances(geometry, entries, { vertexColors: THREE.VertexColors });
    });
    const rods = scene.arms.flatMap(([from, to]) =>
      imagesOf([motion.sampled(0, from), motion.sampled(0, to)], scene.box).map((image) => ({ from, to, image }))
    );
    this.rods = this.instances(new THREE.CylinderBufferGeometry(1, 1, 1, 24, 1, true).rotateX(Math.PI / 2), rods);
    this.rods.userData.radius = 0.16 * Math.max(least, Math.min(...this.shapes.map((shape) => shape.radius)));
    for (const { surface, position, orientation_wxyz: [w, x, y, z] } of scene.obstacles) {
      const look = new THREE.MeshLambertMaterial({ transparent: true, opacity: 0.7 });
      const mesh = new THREE.Mesh(this.surfaces[surface].geometry(THREE, [], false), look);
      mesh.position.fromArray(position);
      mesh.quaternion.set(x, y, z, w);
      this.world.add(mesh);
      this.colours.obstacles.push(mesh);
    }
  }

  /** All bodies and arms as they are at a frame, with its fraction. */
  show(at) {
    const { THREE, scene, motion } = this;
    this.states = scene.bodies.map((_, body) => motion.state(at, body));
    const [matrix, turn, scale, place] = [
      new THREE.Matrix4(),
      new THREE.Quaternion(),
      new THREE.Vector3(),
      new THREE.Vector3(),
    ];
    const put = (mesh, number, position, [w, x, y, z], size) => {
      matrix.compose(place.fromArray(position), turn.set(x, y, z, w), scale.fromArray(size));
      mesh.setMatrixAt(number, matrix);
      mesh.instanceMatrix.needsUpdate = true;
    };
    this.beads.forEach((mesh) =>
      mesh.userData.forEach((entry, number) => {
        const { position, orientation } = this.placed(entry);
        put(mesh, number, position, orientation, [entry.scale, entry.scale, entry.scale]);
      })
    );
    const { radius } = this.rods.userData;
    this.rods.userData.forEach(({ from, to, image }, number) => {
      const ends = [from, to].map((body) => mirrored(this.states[body].position, image, scene.box));
      const arm = plus(ends[1], ends[0], -1);
      const [x, y, z] = normalised(arm);
      const axis = z < -0.999999 ? [0, 1, 0, 0] : normalised([1 + z, -y, x, 0]);
      put(this.rods, number, scaled(plus(...ends), 0.5), axis, [radius, radius, Math.hypot(...arm)]);
    });
  }

  /** Position and orientation of a body or image in the frame that is shown. */
  placed({ body, image }) {
    const { position, orientation } = this.states[body];
    if (!image.length) return { position, orientation };
    return { position: mirrored(position, image, this.scene.box), orientation: mirroredTurn(orientation, image) };
  }

  addPaths() {
    const { scene, motion } = this;
    if (this.paths) this.paths.forEach((lines) => (this.world.remove(lines), lines.geometry.dispose()));
    const every = Math.ceil((motion.last * scene.bodies.length) / MOST_PATH_LINES) || 1;
    this.paths = this.pathLooks.map((look, colour) => {
      const points = [];
      scene.bodies.forEach((body, number) => {
        if (body.colour !== colour) return;
        for (let frame = 0; frame < motion.last; frame += every) {
          const next = Math.min(frame + every, motion.last);
          points.push(...motion.sampled(frame, number), ...motion.sampled(next, number));
        }
      });
      return this.segments(points, look);
    });
  }

  segments(points, material) {
    const geometry = new this.THREE.BufferGeometry();
    geometry.setAttribute("position", new this.THREE.Float32BufferAttribute(points, 3));
    const lines = new this.THREE.LineSegments(geometry, material);
    lines.frustumCulled = false;
    this.world.add(lines);
    return lines;
  }

  /** A rectangle with these corners in order; `normal` decides from which side it is seen. */
  face(corners, material) {
    const geometry = new this.THREE.BufferGeometry();
    geometry.setAttribute("position", new this.THREE.Float32BufferAttribute(corners.flat(), 3));
    geometry.setAttribute("uv", new this.THREE.Float32BufferAttribute([0, 0, 1, 0, 1, 1, 0, 1], 2));
    geometry.setIndex([0, 1, 2, 0, 2, 3]);
    const mesh = new this.THREE.Mesh(geometry, material);
    this.world.add(mesh);
    return mesh;
  }

  addDomain() {
    const { THREE, scene } = this;
    const box = scene.box;
    if (!box || !box.size) {
      const { low, high } = this.extent;
      const ends = axisEnds(low, scaled([1, 1, 1], 0.15 * Math.max(...plus(high, low, -1))));
      this.colours.lines.push(this.segments(ends.flatMap((end) => [...low, ...end]), new THREE.LineBasicMaterial()));
      this.axes = ends;
    }
    if (!box) return;
    const bounds = box.size ? { low: [0, 0, 0], high: box.size } : around(this.extent);
    if (box.size) {
      this.domain = bounds;
      this.axes = axisEnds([0, 0, 0], box.size);
    }
    const across = (axis, at) => rectangle(scaled(unitVector(axis), at), ...[0, 1, 2].filter((k) => k !== axis), bounds);
    const seeThrough = { transparent: true, depthWrite: false };
    for (const name of box.walls) {
      const axis = "xyz".indexOf(name[0]);
      const high = name.endsWith("high");
      const corners = across(axis, box.size ? (high ? bounds.high : bounds.low)[axis] : 0);
      if (high === (axis !== 1)) corners.reverse(); // seen from the inside only
      const material = new THREE.MeshBasicMaterial({ ...seeThrough, opacity: 0.5 });
      if (!box.size) material.side = THREE.DoubleSide;
      this.colours.faces.push(this.face(corners, material));
    }
    for (const name of box.symmetry) {
      const axis = "xyz".indexOf(name);
      const corners = across(axis, box.size[axis] / 2);
      const material = new THREE.MeshBasicMaterial({ ...seeThrough, opacity: 0.07, side: THREE.DoubleSide });
      this.colours.mirrors.push(this.face(corners, material));
      const round = corners.flatMap((point, k) => [...point, ...corners[(k + 1) % 4]]);
      this.colours.mirrors.push(this.segments(round, new THREE.LineBasicMaterial({ transparent: true, opacity: 0.5 })));
    }
    if (!box.size) return;
    const edges = [0, 1, 2].flatMap((axis) => {
      const [from, to] = [0, box.size[axis]].map((at) => across(axis, at));
      return from.flatMap((point, k) => [...point, ...to[k]]);
    });
    this.colours.lines.push(this.segments(edges, new THREE.LineBasicMaterial()));
  }

  addFlow() {
    const { THREE, scene } = this;
    if (!scene.flow) return;
    const { along, across, low, shape } = scene.flow;
    const pixels = new Uint8Array(3 * shape[0] * shape[1]);
    this.texture = new THREE.DataTexture(pixels, shape[1], shape[0], THREE.RGBFormat);
    this.texture.magFilter = this.texture.minFilter = THREE.LinearFilter;
    this.texture.unpackAlignment = 1;
    const material = new THREE.MeshBasicMaterial({ map: this.texture, side: THREE.DoubleSide });
    this.flow = this.face(rectangle(low, along, across, scene.flow), material);
  }

  /** `look`: beads, flow (lists of colours), arms, line, face, mirror. */
  recolour(look) {
    const set = (object, colour) => object.material.color.set(colour);
    this.beads.forEach((mesh) => set(mesh, look.beads[mesh.userData[0].colour]));
    this.pathLooks.forEach((material, colour) => material.color.set(look.beads[colour]));
    [this.rods, ...this.colours.obstacles].forEach((object) => set(object, look.arms));
    this.colours.lines.forEach((object) => set(object, look.line));
    this.colours.faces.forEach((object) => set(object, look.face));
    this.colours.mirrors.forEach((object) => set(object, look.mirror));
    if (!this.flow) return;
    const stops = look.flow.map((colour) => new this.THREE.Color(colour));
    const mixed = new this.THREE.Color();
    bytesOf(this.scene.flow.levels).forEach((level, cell) => {
      const place = (level / 255) * (stops.length - 1);
      const before = Math.min(Math.floor(place), stops.length - 2);
      mixed.copy(stops[before]).lerp(stops[before + 1], place - before);
      this.texture.image.data.set([mixed.r, mixed.g, mixed.b].map((share) => 255 * share), 3 * cell);
    });
    this.texture.needsUpdate = true;
  }

  setVisible(what, visible) {
    const of = { paths: this.pathLooks, flow: [this.flow], domain: Object.values(this.colours).flat() };
    of[what].forEach((object) => object && (object.visible = visible));
  }

  /** Draws; width and height of the canvas in pixels of the page. */
  render(orbit, width, height) {
    if (this.width !== width || this.height !== height) {
      Object.assign(this, { width, height });
      this.renderer.setSize(width, height, false);
    }
    const { camera } = this;
    const { low, high } = this.whole();
    const away = plus(orbit.target, scaled(plus(low, high), 0.5), -1);
    const reach = 1.5 * (orbit.radius + Math.hypot(...away)) + Math.hypot(...plus(high, low, -1));
    camera.aspect = width / height;
    camera.near = Math.max(orbit.distance - reach, orbit.distance / 200);
    camera.far = orbit.distance + reach;
    camera.position.fromArray(orbit.eye);
    camera.up.fromArray(orbit.screen.up);
    camera.lookAt(...orbit.target);
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
    const { right, up } = orbit.screen;
    this.light.position.fromArray(plus(plus(orbit.outwards, up, 0.8), right, -0.5));
    this.renderer.render(this.world, camera);
  }

  whole() {
    return this.domain ? joined(this.domain, this.extent) : this.extent;
  }

  /** The entry of the body or image nearest to the eye at a place in the picture, from (-1, -1) to (1, 1), or null. */
  entryAt(x, y) {
    const ray = new this.THREE.Raycaster();
    ray.setFromCamera({ x, y }, this.camera);
    const [nearest] = ray.intersectObjects(this.beads);
    return nearest ? nearest.object.userData[nearest.instanceId] : null;
  }

  /** Where a point of the world is in the picture, in shares of width and height from its upper left corner. */
  projected(point) {
    const seen = new this.THREE.Vector3(...point).project(this.camera);
    return { left: (seen.x + 1) / 2, top: (1 - seen.y) / 2 };
  }
}

/** Ends of three axes from a corner. */
function axisEnds(corner, lengths) {
  return [0, 1, 2].map((axis) => plus(corner, unitVector(axis), lengths[axis]));
}

/** Three times as wide, for a plane without edges. */
function around({ low, high }) {
  const size = Math.max(...plus(high, low, -1));
  return { low: low.map((value) => value - size), high: high.map((value) => value + size) };
}

function joined(a, b) {
  return {
    low: a.low.map((value, k) => Math.min(value, b.low[k])),
    high: a.high.map((value, k) => Math.max(value, b.high[k])),
  };
}
