// The motion of all bodies between its samples, from the packed numbers of a scene.

const LEVELS = 65535;

/** Bytes of a text in base64. */
function bytesOf(text) {
  return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
}

class Motion {
  /** `motion`: as copepod_report/scene.py packs it. */
  constructor(motion, bodies) {
    Object.assign(this, motion, { bodies });
    this.turns = new Map(motion.turning.map((body, place) => [body, place]));
    this.positions = new Uint16Array(bytesOf(motion.positions).buffer);
    this.speeds = new Uint16Array(bytesOf(motion.speeds).buffer);
    this.rotations = new Int16Array(bytesOf(motion.rotations).buffer);
  }

  get last() {
    return this.steps.length - 1;
  }

  /** Position of a body in a frame, in the unit of the scene. */
  sampled(frame, body) {
    const at = 3 * (frame * this.bodies + body);
    return [0, 1, 2].map((k) => this.low[body][k] + (this.span[body][k] * this.positions[at + k]) / LEVELS);
  }

  /** Between two frames: {position, orientation (a quaternion), speed_m_per_s}; `at`: frame with a fraction. */
  state(at, body) {
    const { before, after, share } = this.around(at);
    const [from, to] = [this.sampled(before, body), this.sampled(after, body)];
    const speed = (frame) => (this.fastest_m_per_s[body] * this.speeds[frame * this.bodies + body]) / LEVELS;
    return {
      position: plus(from, plus(to, from, -1), share),
      orientation: this.orientation(before, body).slerp(this.orientation(after, body), share),
      speed_m_per_s: speed(before) + share * (speed(after) - speed(before)),
    };
  }

  orientation(frame, body) {
    if (!this.turns.has(body)) return quaternion(this.orientations[body]);
    const at = 3 * (frame * this.turns.size + this.turns.get(body));
    const [x, y, z] = [0, 1, 2].map((k) => this.rotations[at + k] / 32767);
    return quaternion([Math.sqrt(Math.max(0, 1 - x * x - y * y - z * z)), x, y, z]);
  }

  /** Frame, with its fraction, at a step of the run. */
  frameAt(step) {
    let after = this.steps.findIndex((sampled) => sampled >= step);
    if (after < 0) after = this.last;
    if (after === 0) return 0;
    const before = after - 1;
    return Math.min(after, before + (step - this.steps[before]) / (this.steps[after] - this.steps[before]));
  }

  /** The frames before and after `at`, and how much the second one counts. */
  around(at) {
    const before = Math.min(Math.floor(at), this.last);
    return { before, after: Math.min(before + 1, this.last), share: at - before };
  }

  /** Step or time of the run at a frame with its fraction, from those of all frames. */
  between(values, at) {
    const { before, after, share } = this.around(at);
    return values[before] + share * (values[after] - values[before]);
  }

  stepAt(at) {
    return this.between(this.steps, at);
  }

  /** Opposite corners of what all bodies, with their shapes, sweep. */
  extent(shapes) {
    const swept = this.low.map((low, body) => ({ low, high: plus(low, this.span[body]) }));
    return swept.map((corners, body) => widened(corners, shapes[body].reach)).reduce(joined);
  }
}

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const plus = (a, b, factor = 1) => a.map((value, k) => value + factor * b[k]);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const scaled = (a, factor) => a.map((value) => value * factor);
const quaternion = ([w, x, y, z]) => new THREE.Quaternion(x, y, z, w);
const normalised = (a) => scaled(a, 1 / (Math.hypot(...a) || 1));

// Boxes along the axes: {low, high}, two opposite corners.
const sizeOf = ({ low, high }) => plus(high, low, -1);
const middleOf = ({ low, high }) => scaled(plus(low, high), 0.5);
const widened = ({ low, high }, by) => ({ low: low.map((value) => value - by), high: high.map((value) => value + by) });
const joined = (a, b) => ({
  low: a.low.map((value, k) => Math.min(value, b.low[k])),
  high: a.high.map((value, k) => Math.max(value, b.high[k])),
});
