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

  /** Between two frames: {position, orientation (w, x, y, z), speed_m_per_s}; `at`: frame with a fraction. */
  state(at, body) {
    const before = Math.min(Math.floor(at), this.last);
    const after = Math.min(before + 1, this.last);
    const share = at - before;
    const mixed = (a, b) => a + share * (b - a);
    const [from, to] = [this.sampled(before, body), this.sampled(after, body)];
    const speed = (frame) => (this.fastest_m_per_s[body] * this.speeds[frame * this.bodies + body]) / LEVELS;
    return {
      position: from.map((value, k) => mixed(value, to[k])),
      orientation: this.turned(before, after, share, body),
      speed_m_per_s: mixed(speed(before), speed(after)),
    };
  }

  turned(before, after, share, body) {
    if (!this.turns.has(body)) return this.orientations[body];
    const [from, to] = [this.quaternion(before, body), this.quaternion(after, body)];
    const sign = from.reduce((sum, value, k) => sum + value * to[k], 0) < 0 ? -1 : 1;
    const mixed = from.map((value, k) => value + share * (sign * to[k] - value));
    const norm = Math.hypot(...mixed);
    return mixed.map((value) => value / norm);
  }

  quaternion(frame, body) {
    const at = 3 * (frame * this.turns.size + this.turns.get(body));
    const [x, y, z] = [0, 1, 2].map((k) => this.rotations[at + k] / 32767);
    return [Math.sqrt(Math.max(0, 1 - x * x - y * y - z * z)), x, y, z];
  }

  /** Frame, with its fraction, at a step of the run. */
  frameAt(step) {
    let after = this.steps.findIndex((sampled) => sampled >= step);
    if (after < 0) after = this.last;
    if (after === 0) return 0;
    const before = after - 1;
    return Math.min(after, before + (step - this.steps[before]) / (this.steps[after] - this.steps[before]));
  }

  /** Step or time of the run at a frame with its fraction, from those of all frames. */
  between(values, at) {
    const before = Math.min(Math.floor(at), this.last);
    const after = Math.min(before + 1, this.last);
    return values[before] + (at - before) * (values[after] - values[before]);
  }

  stepAt(at) {
    return this.between(this.steps, at);
  }

  /** Opposite corners of what all bodies, with their shapes, sweep. */
  extent(shapes) {
    const low = [Infinity, Infinity, Infinity];
    const high = [-Infinity, -Infinity, -Infinity];
    shapes.forEach(({ reach }, body) => {
      for (let k = 0; k < 3; k++) {
        low[k] = Math.min(low[k], this.low[body][k] - reach);
        high[k] = Math.max(high[k], this.low[body][k] + this.span[body][k] + reach);
      }
    });
    return { low, high };
  }
}

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const plus = (a, b, factor = 1) => a.map((value, k) => value + factor * b[k]);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const scaled = (a, factor) => a.map((value) => value * factor);
const normalised = (a) => scaled(a, 1 / (Math.hypot(...a) || 1));
