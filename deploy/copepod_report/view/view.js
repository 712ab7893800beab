// One interactive view: its controls, and what mouse, fingers and keys do to it.

const SECONDS_PER_CYCLE = 2; // of the stroke, at normal speed
const SECONDS_PER_RUN = 12; // without a stroke

/** A duration or a speed in a unit of a good size, from SI: three digits. */
function withUnit(value, unit) {
  if (value === 0) return `0 ${unit}`;
  const prefixes = [["", 1], ["m", 1e-3], ["µ", 1e-6], ["n", 1e-9]];
  const [prefix, factor] = prefixes.find(([, factor]) => Math.abs(value) >= factor) || prefixes[3];
  const shown = value / factor;
  const isShort = Math.abs(shown) < 1e5 && Math.abs(shown) >= 1e-3;
  return `${isShort ? Number(shown.toPrecision(3)) : shown.toExponential(2)} ${prefix}${unit}`;
}

function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

const prefersLittleMotion = window.matchMedia("(prefers-reduced-motion: reduce)");

class View {
  /** `place`: the element to fill; `live`: new samples will arrive, and the view stays with the newest. */
  constructor(place, scene, live) {
    Object.assign(this, { place, scene, at: 0, playing: false, selected: null, isAtEnd: live });
    this.switches = { paths: true, flow: true, domain: true, follow: false };
    this.build();
    this.take(scene);
    if (live) this.at = this.motion.last;
    this.watchPage();
  }

  take(scene) {
    this.scene = scene;
    this.motion = new Motion(scene.motion, scene.bodies.length);
    this.slider.max = this.motion.last;
  }

  build() {
    const find = (selector) => this.place.querySelector(selector);
    const all = (selector) => [...this.place.querySelectorAll(selector)];
    this.place.replaceChildren(document.getElementById("controls").content.cloneNode(true));
    [this.holder, this.tip, this.clock, this.speed] = [".canvas", ".tip", ".clock", "select"].map(find);
    [this.playButton, this.slider] = [".play", "[type=range]"].map(find);
    this.labels = all(".axis");
    this.keys = find("details p").textContent;
    this.playButton.onclick = () => this.toggle();
    this.slider.oninput = () => (this.pause(), this.goTo(Number(this.slider.value)));
    all("[type=checkbox]").forEach((box) => (box.onchange = () => this.setSwitch(box.name, box.checked)));
    all(".switches button").forEach((button) => (button.onclick = () => this.lookAt(button.name)));
    find("[name=flow]").parentElement.hidden = !this.scene.flow;
    find("button[name=domain]").hidden = !this.scene.box || !this.scene.box.size;
    this.showPlaying();
  }

  /** Shows or hides a part of what is drawn, or follows the bodies or not. */
  setSwitch(what, isOn) {
    this.switches[what] = isOn;
    if (this.stage) this.stage.setVisible(what, isOn);
    this.draw();
  }

  /** Draws only while on the screen: a page of many runs holds few contexts of WebGL at a time. */
  watchPage() {
    new IntersectionObserver((entries) => (entries.pop().isIntersecting ? this.open() : this.close()), {
      rootMargin: "50px",
    }).observe(this.holder);
    new ResizeObserver(() => this.draw()).observe(this.holder);
    window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => (this.recolour(), this.draw()));
  }

  open() {
    if (this.stage) return;
    const label = `Interactive view of ${this.scene.name}. ${this.keys}`;
    this.canvas = element("canvas", { tabindex: 0, role: "application", "aria-label": label });
    this.holder.prepend(this.canvas);
    try {
      this.stage = new Stage(this.canvas, this.scene, this.motion);
    } catch (problem) {
      this.place.replaceChildren(
        element("p", { class: "missing" }, `The interactive view needs WebGL (${problem.message}). The figures show the run.`)
      );
      return;
    }
    this.listen();
    for (const [what, isOn] of Object.entries(this.switches)) this.stage.setVisible(what, isOn);
    if (!this.orbit) {
      this.orbit = new Orbit(this.stage.whole(), this.scene.up);
      this.lookAt(this.bodiesAreSmall() ? "bodies" : "domain");
    }
    this.recolour();
    this.draw();
  }

  close() {
    if (!this.stage) return;
    this.pause();
    this.stage.close();
    this.canvas.remove();
    this.stage = null;
  }

  bodiesAreSmall() {
    const length = (extent) => Math.hypot(...sizeOf(extent));
    return length(this.stage.whole()) > 6 * length(this.stage.extent);
  }

  lookAt(what) {
    if (!this.stage) return;
    const { clientWidth, clientHeight } = this.holder;
    this.orbit.frame(what === "domain" ? this.stage.whole() : this.stage.extent, clientWidth / clientHeight);
    this.centre = null;
    this.draw();
  }

  recolour() {
    if (!this.stage) return;
    const style = getComputedStyle(this.place);
    const colour = (name) => style.getPropertyValue(name).trim();
    const [soft, face, mirror] = ["--soft", "--line", "--mark"].map(colour);
    const beads = [0, 1, 2].map((number) => colour(`--bead-${number}`));
    const flow = colour("--flow").split(",").map((part) => part.trim());
    this.stage.recolour({ beads, flow, rod: soft, line: soft, face, mirror, obstacle: soft });
  }

  /** New samples of a run that continues. */
  update(scene) {
    if (scene.bodies.length !== this.scene.bodies.length || JSON.stringify(scene.box) !== JSON.stringify(this.scene.box)) {
      this.close();
      this.orbit = null;
      this.take(scene);
      this.at = this.motion.last;
      return this.open();
    }
    const step = this.motion.stepAt(this.at);
    this.take(scene);
    if (this.stage) this.stage.replaceMotion(this.motion);
    if (this.isAtEnd && !prefersLittleMotion.matches && this.stage) {
      this.at = this.motion.frameAt(step);
      this.play();
    } else {
      this.goTo(this.isAtEnd ? this.motion.last : this.motion.frameAt(step), this.isAtEnd);
    }
  }

  goTo(at, isAtEnd = at >= this.motion.last) {
    this.at = Math.max(0, Math.min(this.motion.last, at));
    this.isAtEnd = isAtEnd;
    this.draw();
  }

  toggle() {
    if (this.playing) return this.pause();
    if (this.at >= this.motion.last) this.at = 0;
    this.isAtEnd = false;
    this.play();
  }

  play() {
    if (this.playing || this.motion.last === 0) return;
    this.playing = true;
    this.before = performance.now();
    this.showPlaying();
    requestAnimationFrame((now) => this.advance(now));
  }

  pause() {
    this.playing = false;
    this.showPlaying();
  }

  /** Steps of the run that pass in a second of the playback at normal speed. */
  stepsPerSecond() {
    const { steps } = this.motion;
    const all = steps[steps.length - 1] - steps[0];
    return this.scene.period_steps ? this.scene.period_steps / SECONDS_PER_CYCLE : all / SECONDS_PER_RUN;
  }

  advance(now) {
    if (!this.playing || !this.stage) return;
    const { motion } = this;
    const seconds = Math.min(1, (now - this.before) / 1000);
    const pace = this.isAtEnd // catches up with a live run within a second
      ? Math.max(this.stepsPerSecond(), motion.steps[motion.last] - motion.stepAt(this.at))
      : this.stepsPerSecond() * Number(this.speed.value);
    this.before = now;
    this.at = motion.frameAt(motion.stepAt(this.at) + pace * seconds);
    if (this.at >= motion.last) {
      this.pause();
      this.isAtEnd = true;
    }
    this.drawNow();
    if (this.playing) requestAnimationFrame((later) => this.advance(later));
  }

  showPlaying() {
    const shape = this.playing ? "M1 0h3v10H1zM6 0h3v10H6z" : "M1 0l9 5-9 5z"; // no font needs to have it
    this.playButton.innerHTML = `<svg viewBox="0 0 10 10" aria-hidden="true"><path d="${shape}"/></svg>`;
    this.playButton.setAttribute("aria-label", this.playing ? "pause" : "play");
  }

  draw() {
    if (!this.stage || this.wanted) return;
    this.wanted = true;
    requestAnimationFrame(() => {
      this.wanted = false;
      this.drawNow();
    });
  }

  drawNow() {
    if (!this.stage) return;
    const { clientWidth: width, clientHeight: height } = this.holder;
    if (!width || !height) return;
    this.stage.show(this.at);
    this.followBodies();
    this.stage.render(this.orbit, width, height);
    this.writeTime();
    this.placeLabels();
    this.writeTip();
    this.place.dataset.drawn = Number(this.place.dataset.drawn || 0) + 1;
  }

  followBodies() {
    const all = this.stage.states.map((state) => state.position);
    const centre = scaled(all.reduce((sum, position) => plus(sum, position)), 1 / all.length);
    if (this.switches.follow && this.centre) this.orbit.target.add(new THREE.Vector3(...plus(centre, this.centre, -1)));
    this.centre = centre;
  }

  writeTime() {
    const { motion } = this;
    const time = motion.between(motion.time_s, this.at);
    const step = Math.round(motion.stepAt(this.at));
    this.slider.value = Math.round(this.at);
    this.clock.textContent = `${withUnit(time, "s")}, step ${step}`;
    this.slider.setAttribute("aria-valuetext", this.clock.textContent);
  }

  placeLabels() {
    const { corner, axes } = this.stage;
    this.labels.forEach((label, axis) => {
      label.hidden = !this.switches.domain;
      const end = plus(corner, plus(axes[axis], corner, -1), 1.06);
      const { left, top } = this.stage.projected(end);
      label.style.left = `${100 * left}%`;
      label.style.top = `${100 * top}%`;
    });
  }

  /** Name, position and speed of the body under the pointer, or chosen by keys. */
  writeTip() {
    const entry = this.selected;
    this.tip.hidden = !entry;
    if (!entry) return;
    const position = this.stage.placeOf(entry);
    const { name } = this.scene.bodies[entry.body];
    const text = position.map((value) => value.toPrecision(4)).join(", ");
    const speed = withUnit(this.stage.states[entry.body].speed_m_per_s, "m/s");
    this.tip.replaceChildren(
      element("b", {}, entry.image.length ? `${name}, mirror image` : name),
      element("span", {}, `(${text}) ${this.scene.unit}`),
      element("span", {}, speed)
    );
    const { left, top } = this.stage.projected(position);
    this.tip.style.left = `clamp(0px, ${100 * left}%, 100% - ${this.tip.offsetWidth}px)`;
    this.tip.style.top = `clamp(0px, ${100 * top}% + 14px, 100% - ${this.tip.offsetHeight}px)`;
  }

  listen() {
    const { canvas } = this;
    const fingers = new Map(); // the last event of each; a mouse is one, too
    const seen = () => {
      const [a, b = a] = fingers.values();
      return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, apart: Math.hypot(a.x - b.x, a.y - b.y) || 1 };
    };
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, event);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!fingers.has(event.pointerId)) return this.point(event);
      const before = seen();
      fingers.set(event.pointerId, event);
      const now = seen();
      const [right, down] = [now.x - before.x, now.y - before.y].map((pixels) => pixels / this.holder.clientHeight);
      if (fingers.size > 1 || event.shiftKey || event.buttons & 6) this.orbit.pan(right, -down);
      else this.orbit.turn(4 * right, 4 * down);
      this.orbit.zoom(before.apart / now.apart);
      this.draw();
    });
    const release = (event) => fingers.delete(event.pointerId);
    canvas.addEventListener("pointerup", release);
    canvas.addEventListener("pointercancel", release);
    canvas.addEventListener("pointerleave", () => fingers.size || this.select(null));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener(
      "wheel",
      (event) => {
        if (document.activeElement !== canvas) return; // the page scrolls
        event.preventDefault();
        this.orbit.zoom(Math.exp(0.0015 * event.deltaY * (event.deltaMode ? 30 : 1)));
        this.draw();
      },
      { passive: false }
    );
    canvas.addEventListener("webglcontextlost", () => canvas === this.canvas && this.close());
    canvas.addEventListener("keydown", (event) => this.press(event));
  }

  point(event) {
    const frame = this.canvas.getBoundingClientRect();
    const x = (2 * (event.clientX - frame.left)) / frame.width - 1;
    const y = 1 - (2 * (event.clientY - frame.top)) / frame.height;
    this.select(this.stage.entryAt(x, y));
  }

  select(entry) {
    if (entry === this.selected) return;
    this.selected = entry;
    this.draw();
  }

  selectNext(offset) {
    const { entries } = this.stage;
    const place = entries.indexOf(this.selected);
    this.select(entries[(place + offset + entries.length + (place < 0 && offset < 0 ? 1 : 0)) % entries.length]);
  }

  press(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const move = (right, up) => (event.shiftKey ? this.orbit.pan(-0.05 * right, -0.05 * up) : this.orbit.turn(-0.1 * right, 0.1 * up));
    const keys = {
      ArrowLeft: () => move(-1, 0),
      ArrowRight: () => move(1, 0),
      ArrowUp: () => move(0, 1),
      ArrowDown: () => move(0, -1),
      "+": () => this.orbit.zoom(0.9),
      "=": () => this.orbit.zoom(0.9),
      "-": () => this.orbit.zoom(1 / 0.9),
      " ": () => this.toggle(),
      ",": () => (this.pause(), this.goTo(Math.ceil(this.at) - 1)),
      ".": () => (this.pause(), this.goTo(Math.floor(this.at) + 1)),
      n: () => this.selectNext(1),
      b: () => this.selectNext(-1),
      Home: () => this.lookAt(this.bodiesAreSmall() ? "bodies" : "domain"),
      Escape: () => (this.select(null), this.canvas.blur()),
    };
    const act = keys[event.key] || keys[event.key.toLowerCase()];
    if (!act) return;
    event.preventDefault();
    act();
    this.draw();
  }
}

/** three.js from the page, where it is compressed; only when a view needs it. */
async function loadThree() {
  if (window.THREE) return;
  const packed = bytesOf(document.getElementById("three").textContent);
  const code = await new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
  document.head.append(element("script", {}, code));
}

/** Fills an element with the view of a scene, or with why there is none; returns the view or null. */
async function openView(place, scene, live) {
  try {
    await loadThree();
    return new View(place, scene, live);
  } catch (problem) {
    const reason = `The interactive view does not work in this browser (${problem.message}). The figures show the run.`;
    place.replaceChildren(element("p", { class: "missing" }, reason));
    return null;
  }
}

window.copepod = { openView, views: [] };
document.querySelectorAll(".view > script").forEach(async (script) => {
  const stage = script.parentElement.querySelector(".stage");
  window.copepod.views.push(await openView(stage, JSON.parse(script.textContent), false));
});
