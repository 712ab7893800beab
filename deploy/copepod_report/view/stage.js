// What is drawn: bodies, arms, paths, domain and flow as objects of three.js, and the camera that turns around them.

const FIELD_OF_VIEW = 35; // degrees, from top to bottom
const SLOPE = Math.tan((FIELD_OF_VIEW / 2) * (Math.PI / 180));
const MOST_PATH_LINES = 6000; // of all bodies: more stutter without a graphics card

/** Turns around a target with `up` upwards on the screen; the longest axis of what is shown lies to the right. */
class Orbit {
  constructor(extent, up) {
    const size = sizeOf(extent);
    const longest = size.indexOf(Math.max(...size));
    const upwards = Math.hypot(...up) > 0 ? normalised(up) : unitVector(longest === 2 ? 0 : 2);
    const level = (axis) => plus(unitVector(axis), upwards, -dot(unitVector(axis), upwards));
    const along = Math.hypot(...level(longest)) > 0.1 ? longest : (longest + 1) % 3;
    const right = normalised(level(along));
    const axes = [right, upwards, cross(right, upwards)].map((axis) => new THREE.Vector3(...axis));
    this.level = new THREE.Quaternion().setFromRotationMatrix(new THREE.Matrix4().makeBasis(...axes));
  }

  /** Looks at the whole of an extent; `aspect`: width of the picture divided by its height. */
  frame(extent, aspect) {
    const { low, high } = extent;
    this.target = new THREE.Vector3(...middleOf(extent));
    this.radius = Math.hypot(...sizeOf(extent)) / 2 || 1;
    this.azimuth = 0.5;
    this.elevation = 0.35;
    const toScreen = this.orientation.inverse();
    const distances = [0, 1, 2, 3, 4, 5, 6, 7].map((corner) => {
      const point = new THREE.Vector3(...[0, 1, 2].map((k) => ((corner >> k) & 1 ? high : low)[k]));
      const { x, y, z } = point.sub(this.target).applyQuaternion(toScreen);
      return z + Math.max(Math.abs(x) / aspect, Math.abs(y)) / SLOPE;
    });
    this.distance = 1.14 * Math.max(...distances);
  }

  /** Of the screen: from its axes, to the right, upwards and towards the eye, to those of the world. */
  get orientation() {
    const turn = new THREE.Euler(-this.elevation, this.azimuth, 0, "YXZ");
    return new THREE.Quaternion().setFromEuler(turn).premultiply(this.level);
  }

  /** Turns what is shown, by angles in radians. */
  turn(right, down) {
    this.azimuth -= right;
    this.elevation = Math.max(-1.55, Math.min(1.55, this.elevation + down));
  }

  /** Moves what is shown by shares of the picture's height. */
  pan(right, up) {
    const height = 2 * this.distance * SLOPE;
    this.target.sub(new THREE.Vector3(right * height, up * height, 0).applyQuaternion(this.orientation));
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

  /** `marked`: with two darker quarters around its z axis. */
  geometry(marked) {
    const { points } = this;
    const meeting = points.map(() => []);
    const faces = [];
    for (let at = 0; at < this.triangles.length; at += 3) {
      const corners = [...this.triangles.subarray(at, at + 3)];
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
  constructor(canvas, scene, motion) {
    Object.assign(this, { scene, motion });
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
    this.camera = new THREE.PerspectiveCamera(FIELD_OF_VIEW);
    this.world = new THREE.Scene();
    this.light = new THREE.DirectionalLight(0xffffff, 0.5);
    this.world.add(new THREE.HemisphereLight(0xffffff, 0x8090a0, 0.62), this.light);
    this.surroundings = { line: [], face: [], mirror: [], obstacle: [] };
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
    const material = new THREE.MeshLambertMaterial(look);
    const mesh = new THREE.InstancedMesh(geometry, material, entries.length);
    mesh.frustumCulled = false;
    mesh.userData = entries;
    this.world.add(mesh);
    return mesh;
  }

  addBodies() {
    const { scene, motion } = this;
    const least = 0.004 * Math.hypot(...sizeOf(this.extent));
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
      const { surface, image } = entries[0];
      const geometry = this.surfaces[surface].geometry(marked);
      const mesh = this.instances(geometry, entries, { vertexColors: THREE.VertexColors });
      for (const axis of image) {
        mesh.position.setComponent(axis, scene.box.size[axis]);
        mesh.scale.setComponent(axis, -1);
      }
      return mesh;
    });
    const rods = scene.arms.flatMap(([from, to]) =>
      imagesOf([motion.sampled(0, from), motion.sampled(0, to)], scene.box).map((image) => ({ from, to, image }))
    );
    this.rods = this.instances(new THREE.CylinderBufferGeometry(1, 1, 1, 24, 1, true).rotateX(Math.PI / 2), rods);
    this.rods.userData.radius = 0.16 * Math.max(least, Math.min(...this.shapes.map((shape) => shape.radius)));
    for (const { surface, position, orientation_wxyz } of scene.obstacles) {
      const look = new THREE.MeshLambertMaterial({ transparent: true, opacity: 0.7 });
      const mesh = new THREE.Mesh(this.surfaces[surface].geometry(false), look);
      mesh.position.fromArray(position);
      mesh.quaternion.copy(quaternion(orientation_wxyz));
      this.world.add(mesh);
      this.surroundings.obstacle.push(mesh);
    }
  }

  /** All bodies and arms as they are at a frame, with its fraction. */
  show(at) {
    const { scene, motion } = this;
    this.states = scene.bodies.map((_, body) => motion.state(at, body));
    const pose = new THREE.Object3D();
    const put = (mesh, number) => {
      pose.updateMatrix();
      mesh.setMatrixAt(number, pose.matrix);
      mesh.instanceMatrix.needsUpdate = true;
    };
    this.beads.forEach((mesh) =>
      mesh.userData.forEach(({ body, scale }, number) => {
        pose.position.set(...this.states[body].position);
        pose.quaternion.copy(this.states[body].orientation);
        pose.scale.setScalar(scale);
        put(mesh, number);
      })
    );
    const { radius } = this.rods.userData;
    this.rods.userData.forEach(({ from, to, image }, number) => {
      const [start, end] = [from, to].map((body) => this.placeOf({ body, image }));
      pose.position.set(...scaled(plus(start, end), 0.5));
      pose.scale.set(radius, radius, Math.hypot(...plus(end, start, -1)));
      pose.lookAt(...end);
      put(this.rods, number);
    });
  }

  /** Where a body or image is in the frame that is shown. */
  placeOf({ body, image }) {
    const { position } = this.states[body];
    return position.map((value, k) => (image.includes(k) ? this.scene.box.size[k] - value : value));
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
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
    const lines = new THREE.LineSegments(geometry, material);
    lines.frustumCulled = false;
    this.world.add(lines);
    return lines;
  }

  /** A rectangle with these corners; their order decides from which side it is seen. */
  face(corners, material) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.Float32BufferAttribute(corners.flat(), 3));
    geometry.setAttribute("uv", new THREE.Float32BufferAttribute([0, 0, 1, 0, 1, 1, 0, 1], 2));
    geometry.setIndex([0, 1, 2, 0, 2, 3]);
    const mesh = new THREE.Mesh(geometry, material);
    this.world.add(mesh);
    return mesh;
  }

  addDomain() {
    const { box } = this.scene;
    if (box && box.size) this.domain = { low: [0, 0, 0], high: box.size };
    this.corner = (this.domain || this.extent).low;
    const lengths = this.domain ? box.size : scaled([1, 1, 1], 0.15 * Math.max(...sizeOf(this.extent)));
    this.axes = [0, 1, 2].map((axis) => plus(this.corner, unitVector(axis), lengths[axis]));
    const lines = this.domain ? edgesOf(this.domain) : this.axes.flatMap((end) => [...this.corner, ...end]);
    this.surroundings.line.push(this.segments(lines, new THREE.LineBasicMaterial()));
    if (!box) return;
    const bounds = this.domain || widened(this.extent, Math.max(...sizeOf(this.extent)));
    const across = (axis, at) => rectangle(scaled(unitVector(axis), at), ...[0, 1, 2].filter((k) => k !== axis), bounds);
    const seeThrough = { transparent: true, depthWrite: false };
    for (const name of box.walls) {
      const axis = "xyz".indexOf(name[0]);
      const high = name.endsWith("high");
      const corners = across(axis, box.size ? (high ? bounds.high : bounds.low)[axis] : 0);
      if (high === (axis !== 1)) corners.reverse(); // seen from the inside only
      const material = new THREE.MeshBasicMaterial({ ...seeThrough, opacity: 0.5 });
      if (!box.size) material.side = THREE.DoubleSide;
      this.surroundings.face.push(this.face(corners, material));
    }
    for (const name of box.symmetry) {
      const axis = "xyz".indexOf(name);
      const corners = across(axis, box.size[axis] / 2);
      const material = new THREE.MeshBasicMaterial({ ...seeThrough, opacity: 0.07, side: THREE.DoubleSide });
      const round = corners.flatMap((point, k) => [...point, ...corners[(k + 1) % 4]]);
      const edges = this.segments(round, new THREE.LineBasicMaterial({ transparent: true, opacity: 0.5 }));
      this.surroundings.mirror.push(this.face(corners, material), edges);
    }
  }

  addFlow() {
    const { scene } = this;
    if (!scene.flow) return;
    const { along, across, low, shape } = scene.flow;
    const pixels = new Uint8Array(3 * shape[0] * shape[1]);
    this.texture = new THREE.DataTexture(pixels, shape[1], shape[0], THREE.RGBFormat);
    this.texture.magFilter = this.texture.minFilter = THREE.LinearFilter;
    this.texture.unpackAlignment = 1;
    const material = new THREE.MeshBasicMaterial({ map: this.texture, side: THREE.DoubleSide });
    this.flow = this.face(rectangle(low, along, across, scene.flow), material);
  }

  /** `look`: beads, flow (lists of colours), rod, line, face, mirror, obstacle. */
  recolour(look) {
    const set = (object, colour) => object.material.color.set(colour);
    this.beads.forEach((mesh) => set(mesh, look.beads[mesh.userData[0].colour]));
    this.pathLooks.forEach((material, colour) => material.color.set(look.beads[colour]));
    set(this.rods, look.rod);
    for (const [kind, objects] of Object.entries(this.surroundings))
      objects.forEach((object) => set(object, look[kind]));
    if (!this.flow) return;
    const stops = look.flow.map((colour) => new THREE.Color(colour));
    const mixed = new THREE.Color();
    bytesOf(this.scene.flow.levels).forEach((level, cell) => {
      const place = (level / 255) * (stops.length - 1);
      const before = Math.min(Math.floor(place), stops.length - 2);
      mixed.copy(stops[before]).lerp(stops[before + 1], place - before);
      this.texture.image.data.set([mixed.r, mixed.g, mixed.b].map((share) => 255 * share), 3 * cell);
    });
    this.texture.needsUpdate = true;
  }

  setVisible(what, visible) {
    const { pathLooks, flow, surroundings } = this;
    const parts = { paths: pathLooks, flow: flow ? [flow] : [], domain: Object.values(surroundings).flat(), follow: [] };
    parts[what].forEach((object) => (object.visible = visible));
  }

  /** Draws; width and height of the canvas in pixels of the page. */
  render(orbit, width, height) {
    if (this.width !== width || this.height !== height) {
      Object.assign(this, { width, height });
      this.renderer.setSize(width, height, false);
    }
    const { camera } = this;
    const whole = this.whole();
    const away = plus(orbit.target.toArray(), middleOf(whole), -1);
    const reach = 1.5 * (orbit.radius + Math.hypot(...away)) + Math.hypot(...sizeOf(whole));
    camera.aspect = width / height;
    camera.near = Math.max(orbit.distance - reach, orbit.distance / 200);
    camera.far = orbit.distance + reach;
    camera.quaternion.copy(orbit.orientation);
    camera.position.set(0, 0, orbit.distance).applyQuaternion(camera.quaternion).add(orbit.target);
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
    this.light.position.set(-0.5, 0.8, 1).applyQuaternion(camera.quaternion);
    this.renderer.render(this.world, camera);
  }

  whole() {
    return this.domain ? joined(this.domain, this.extent) : this.extent;
  }

  /** The entry of the body or image nearest to the eye at a place in the picture, from (-1, -1) to (1, 1), or null. */
  entryAt(x, y) {
    const ray = new THREE.Raycaster();
    ray.setFromCamera({ x, y }, this.camera);
    const [nearest] = ray.intersectObjects(this.beads);
    return nearest ? nearest.object.userData[nearest.instanceId] : null;
  }

  /** Where a point of the world is in the picture, in shares of width and height from its upper left corner. */
  projected(point) {
    const seen = new THREE.Vector3(...point).project(this.camera);
    return { left: (seen.x + 1) / 2, top: (1 - seen.y) / 2 };
  }
}

/** Ends of all edges of a box. */
function edgesOf(box) {
  const block = new THREE.BoxBufferGeometry(...sizeOf(box)).translate(...middleOf(box));
  return new THREE.EdgesGeometry(block).attributes.position.array;
}
