#!/usr/bin/env node
// A fluid component in JavaScript: Stokes drag on isolated spheres, F = −6π η r v, T = −8π η r³ ω.
// Neglects the other bodies, the walls and the inertia of the fluid. Written from docs/protocol.md alone; comments name
// its sections. One event loop serves both lanes, since no computation here takes longer than a second.
import { randomBytes } from "node:crypto";
import { appendFileSync, readFileSync, writeFileSync } from "node:fs";
import { hostname } from "node:os";
import { parseArgs } from "node:util";
import { createXXHash3 } from "hash-wasm";
import protobuf from "protobufjs";
import { Dealer } from "zeromq";

const NEGLECTED = ["boundary", "symmetry_planes", "body_force", "fields"].map((name) => `neglects:${name}`);
const FEATURES = ["checkpoint", "snapshots", "shape:sphere", "solver:external", ...NEGLECTED];
const CAPABILITIES = { name: "Stokes drag in JavaScript", version: "1.0", features: FEATURES };
const MAJOR = 2, MINOR = 0, FLUID = 1;
const FINISHED = 0, BAD_CASE = 2, REFUSED = 65, LOST = 69, FAILED = 70, STORAGE = 73, DEADLINE = 74;

const failure = (code, reason) => Object.assign(new Error(reason), { code });
const refused = (why) => failure(REFUSED, `The message was refused (${why}). Use the same protocol on both sides.`);

class StokesDrag {
  constructor(setup, step) {
    this.steps = step;
    this.radius_m = setup.bodies.map((body) => body.radius_m);
    this.viscosity_Pa_s = setup.density_kg_per_m3 * setup.kinematic_viscosity_m2_per_s;
  }
  exchange({ velocity_m_per_s, angular_velocity_rad_per_s }) {
    const drag = (factor, power, rates) => rates.map((rate, i) =>
      -factor * Math.PI * this.viscosity_Pa_s * this.radius_m[Math.floor(i / 3)] ** power * rate);
    return { force_N: drag(6, 1, velocity_m_per_s), torque_N_m: drag(8, 3, angular_velocity_rad_per_s) };
  }
  advance() { // the bulk update, after the reply; returns the next step
    return ++this.steps;
  }
  save(path) {
    writeFileSync(path, `${this.steps} steps\n`);
  }
  restore(path) {
    const found = /^(\d+) steps\n$/.exec(readFileSync(path, "utf8"));
    if (!found) throw new Error("it does not hold a number of steps");
    this.steps = Number(found[1]);
  }
}

// ---- Frames
const proto = process.env.COPEPOD_PROTO ?? new URL("../../proto", import.meta.url).pathname;
const root = new protobuf.Root();
root.resolvePath = (_, file) => `${proto}/${file}`;
await root.load("copepod/v1/envelope.proto", { keepCase: true });
const Envelope = root.lookupType("copepod.v1.Envelope");
const xxh3 = await createXXHash3();

const checksum = (content) => // as field 15 of the Envelope
  Buffer.concat([Buffer.from([0x79]), Buffer.from(xxh3.init().update(content).digest("hex"), "hex").reverse()]);

function toFrame(header, name, body) {
  const fields = { protocol_major: MAJOR, protocol_minor: MINOR, step: -1, ...header, [name]: body };
  const content = Envelope.encode(Envelope.fromObject(fields)).finish();
  return Buffer.concat([content, checksum(content)]);
}

/** The Envelope in a frame; undefined if the frame was damaged. */
function fromFrame(frame) {
  const content = frame.subarray(0, -9);
  if (frame.length < 9 || !frame.subarray(-9).equals(checksum(content))) return undefined;
  let envelope;
  try {
    envelope = Envelope.decode(content);
  } catch (error) {
    throw refused(error.message);
  }
  const { body, protocol_major } = envelope;
  if (!body) throw refused("it is empty or unknown");
  if (protocol_major !== MAJOR && body !== "refusal") throw refused(`it is of protocol ${protocol_major}`);
  return envelope;
}

const sessionOf = ({ session_id, epoch }) => ({ session_id, epoch });
const isOf = (session, { session_id, epoch }) => session?.session_id.equals(session_id) && session.epoch.equals(epoch);

// ---- Limits
const ANY = 0; // of joints, other shapes and the field output, which this fluid does not use
// Others have 3 for each body.
const LENGTHS = { boundaries: 6, orientation_wxyz: 4, jointed: ANY, quantities: ANY, probes: ANY, faces: ANY, region_cells: ANY,
  profile: ANY, parts: ANY, obstacles: ANY, meshes: ANY, vertices_m: ANY, triangles: ANY };

function checkFields(message, bodies = 1) {
  for (const { name, type, repeated, resolvedType } of message.$type.fieldsArray.map((field) => field.resolve())) {
    const entries = repeated ? message[name] : [message[name]];
    const isAbsent = name === "extents_m" && entries.length === 0; // of spheres
    const fixed = repeated && LENGTHS[name] !== ANY && !isAbsent;
    if (name === "bodies" ? entries.length > 1e6 : fixed && entries.length !== (LENGTHS[name] ?? 3) * bodies)
      throw refused(`${name} has ${entries.length} entries`);
    for (const entry of entries) {
      if (resolvedType instanceof protobuf.Enum) {
        if (!entry || !(entry in resolvedType.valuesById)) throw refused(`${name} has the unknown value ${entry}`);
      } else if (resolvedType && entry) checkFields(entry);
      else if (type === "double" && !Number.isFinite(entry)) throw refused(`${name} is not finite`);
      else if (type === "string" && Buffer.byteLength(entry) > 4096) throw refused(`${name} has more than 4096 bytes`);
    }
  }
}

function checkSetup(setup) {
  checkFields(setup);
  const cells = setup.domain_cells.map(Number);
  if (cells.some((count) => count < 0) || cells.reduce((product, count) => product * Math.max(1, count), 1) > 1e12)
    throw refused("domain_cells is negative or too large");
  if (setup.no_slip_plane > 6) throw refused("no_slip_plane is not a face of the domain");
  const names = ["every_steps", "mean_start", "mean_stop", "mean_every_steps"];
  const [every, start, stop, meanEvery] = names.map((name) => Number(setup.fields?.[name] ?? 0));
  if (Math.min(every, start, stop, meanEvery) < 0) throw refused("fields has a negative number of steps");
  if (stop !== 0 && (start >= stop || meanEvery === 0)) throw refused("fields has a mean of no step");
}

// ---- States: the messages that each allows, and the state once their work is done
const ALLOWED = {
  greeted: { FluidSetup: "configured", Finish: "done" },
  configured: { FluidSetup: "configured", Restore: "ready", Kinematics: "ready", Summarise: "configured",
    Finish: "done" },
  ready: { FluidSetup: "configured", Kinematics: "ready", Save: "ready", Summarise: "ready", Finish: "done" },
};
const PHASES = { FluidSetup: "CONFIGURING", Save: "CHECKPOINTING", Restore: "CHECKPOINTING" }; // others: EXCHANGING

function serve(options) {
  const instance = (BigInt("0x" + randomBytes(8).toString("hex")) | 1n).toString();
  const [data, control] = ["data", "control"].map((lane) => new Dealer({
    routingId: `fluid-${instance}-${lane}`, linger: 500, maxMessageSize: 256 << 20, reconnectInterval: 100 }));
  let state = "connected", phase = "HANDSHAKE", step = -1, nextStep = -1, last = 0, replied = 0;
  let session, controlSession, lastReply, solver, bodies, lastPing, brokenSince;

  async function fail({ message, code }) {
    code = Number.isInteger(code) ? code : FAILED;
    const report = { code, component: "fluid", host: hostname(), step, reason: message.slice(0, 1000) };
    if (options["log-file"]) appendFileSync(options["log-file"], `${message}\n`);
    if (session) await data.send(toFrame({ ...session, step }, "failure", report));
    else process.stderr.write(`error: ${message}\n`);
    setTimeout(() => process.exit(code), 200); // the message needs a moment to leave
  }

  // ---- A run: Hello every second on each lane until its Welcome
  async function run(socket, lane, isWelcomed, handle) {
    const hello = { role: FLUID, lane, versions: { major: MAJOR, minor_min: 0, minor_max: MINOR }, host: hostname(),
      session_token: options.session, capabilities: CAPABILITIES, pid: process.pid, ranks: 1, instance };
    const sayHello = () => isWelcomed() || socket.send(toFrame({}, "hello", { ...hello })).catch(() => {});
    socket.connect(options.endpoint);
    setInterval(sayHello, 1000);
    sayHello();
    for await (const [frame] of socket) await handle(frame);
  }

  async function onData(frame) { // Order of checks
    const envelope = fromFrame(frame);
    if (!envelope) return;
    const name = Envelope.fields[envelope.body].resolvedType.name;
    if (name === "Welcome" || name === "Refusal") return onHandshake(envelope);
    if (!isOf(session, envelope)) return;
    const sequence = Number(envelope.sequence);
    if (sequence === 0) throw refused(`${name} has the sequence number 0`);
    if (sequence === last) return data.send(lastReply);
    if (sequence < last) return;
    const to = ALLOWED[state]?.[name], allowed = Object.keys(ALLOWED[state] ?? {}).join(", ") || "no message";
    if (!to) throw refused(`${name} is not allowed in state '${state}', which allows ${allowed}`);
    if (sequence !== last + 1) throw refused(`request ${sequence} came after request ${last}`);
    if (name === "Kinematics" && Number(envelope.step) !== nextStep)
      throw refused(`step ${envelope.step} came where step ${nextStep} was due`);
    [last, step, phase] = [sequence, Number(envelope.step), PHASES[name] ?? "EXCHANGING"];
    lastReply = toFrame({ ...session, sequence, step }, ...perform(name, envelope[envelope.body]));
    await data.send(lastReply);
    [replied, phase] = [sequence, "ADVANCING"];
    if (name === "Kinematics") nextStep = solver.advance();
    [state, phase] = [to, "WAITING"];
    if (state === "done") setTimeout(() => process.exit(FINISHED), 500); // the coupler may have to ask again
    await new Promise(setImmediate); // so that pings are answered between the requests of a long queue
  }

  function onHandshake({ body, welcome, refusal }) {
    if (state !== "connected") return;
    if (body === "refusal") throw failure(REFUSED, refusal.reason);
    if (welcome.minor > MINOR) throw refused(`minor version ${welcome.minor} was not offered`);
    [session, state, phase] = [sessionOf(welcome), "greeted", "WAITING"];
  }

  /** The name of the reply as a field of the Envelope, and its content. */
  function perform(name, body) {
    if (name === "FluidSetup") {
      checkSetup(body);
      [bodies, nextStep, solver] = [body.bodies.length, step, new StokesDrag(body, step)];
      return ["configured", {}];
    }
    if (name === "Kinematics") {
      checkFields(body, bodies);
      return ["loads", solver.exchange(body)];
    }
    if (name === "Summarise") return ["summary", { digest: String(solver.steps), ranks: 1 }];
    if (name === "Finish") return ["finished", {}];
    checkFields(body);
    try {
      name === "Save" ? solver.save(body.path) : solver.restore(body.path);
    } catch ({ message }) {
      const problem = `${name} failed for ${body.path} (${message}). Choose another path.`;
      if (name === "Save") return ["saved", { problem }];
      throw failure(STORAGE, problem);
    }
    return [name === "Save" ? "saved" : "restored", {}];
  }

  // ---- Who is alive
  async function onControl(frame) {
    const envelope = fromFrame(frame);
    if (envelope?.body === "welcome") [controlSession, lastPing] = [sessionOf(envelope.welcome), Date.now()];
    if (!envelope || !isOf(controlSession, envelope)) return;
    if (envelope.body === "abort") process.exit(envelope.abort.failure?.code || FAILED);
    if (envelope.body === "ping") {
      lastPing = Date.now();
      const { stamp_ns } = envelope.ping, sequences = { received_sequence: last, replied_sequence: replied };
      const pong = { stamp_ns, step, phase: `PHASE_${phase}`, ...sequences };
      await control.send(toFrame({ ...controlSession, step }, "pong", pong));
    }
  }

  control.events.on("connect", () => (brokenSince = undefined));
  control.events.on("disconnect", () => (brokenSince ??= Date.now()));
  let looked = Date.now();
  setInterval(() => {
    const wasSuspended = Date.now() - looked > 1000;
    looked = Date.now();
    if (wasSuspended) [lastPing, brokenSince] = [lastPing, brokenSince].map((time) => time && looked);
    const [silent_s, broken_s] = [lastPing, brokenSince].map((time) => (Date.now() - (time ?? Date.now())) / 1000);
    if (lastPing && (silent_s > options["orphan-after"] || broken_s > 3)) process.exit(LOST);
  }, 100);
  const noAnswer = failure(DEADLINE, "The coupler did not answer (is it running?). Check --endpoint.");
  setTimeout(() => session || fail(noAnswer), 1000 * options["connect-deadline"]);
  run(data, 1, () => session, onData).catch(fail);
  run(control, 2, () => controlSession, (frame) => onControl(frame).catch(() => {})).catch(fail); // it ignores nonsense
}

// ---- Command line
const text = { type: "string" };
const OPTIONS = { capabilities: { type: "boolean" }, endpoint: text, session: text, keys: text, "log-file": text,
  "log-level": text, "orphan-after": { ...text, default: "10" }, "connect-deadline": { ...text, default: "60" } };
try {
  const { values } = parseArgs({ options: OPTIONS });
  values.session ??= process.env.COPEPOD_SESSION;
  if (values.capabilities) console.log(JSON.stringify({ ...CAPABILITIES, role: "fluid" }));
  else if (!values.endpoint || !values.session) throw new Error("No coupler is named. Give --endpoint and --session.");
  else if (values.keys) throw new Error("Keys are not supported by this example. Use an ipc or loopback endpoint.");
  else serve(values);
} catch ({ message }) {
  process.stderr.write(`error: ${message}\n`);
  process.exit(BAD_CASE);
}
