"use strict";
// The live page: asks for the state of the run once a second, and shows what has changed.
(() => {
  const EVERY_MS = 1000;
  const AFTER_END_MS = 5000; // the run may be resumed
  const { openView, withUnit } = window.copepod;
  const live = document.getElementById("live");
  const find = (selector) => live.querySelector(selector);
  const figure = find(".view");
  let view = null;
  let version = "";
  let reported = false;

  const made = (name, text = "") => Object.assign(document.createElement(name), { textContent: text });

  function showProgress({ state, sentence, phase, step, steps, figures }) {
    const status = find(".status");
    const text = phase && phase !== "running" ? `${sentence} It is ${phase}.` : sentence;
    if (status.textContent !== text) status.textContent = text;
    status.className = `status ${state}`;
    const bar = find("progress");
    Object.assign(bar, { max: steps || 1, value: step });
    bar.setAttribute("aria-label", `step ${step} of ${steps}`);
    find(".pace").textContent = [`step ${step} of ${steps}`, ...figures].join(", ");
    document.title = `${steps ? Math.floor((100 * step) / steps) : 0} % ${state}: ${document.title.split(": ").pop()}`;
  }

  /** A line of the values, with as many places as the widest run has. */
  function sparkline(values) {
    const [width, height] = [160, 28];
    const [low, high] = [Math.min(0, ...values), Math.max(0, ...values)];
    const x = (place) => 3 + (place * (width - 6)) / Math.max(1, values.length - 1);
    const y = (value) => height - 3 - ((value - low) / (high - low || 1)) * (height - 6);
    const points = values.map((value, place) => `${x(place).toFixed(1)},${y(value).toFixed(1)}`).join(" ");
    const drawing = new DOMParser().parseFromString(
      `<svg width="${width}" height="${height}" role="img" aria-label="by cycle"><line x1="0" x2="${width}" y1="${y(0)}" ` +
        `y2="${y(0)}" stroke="var(--line)"/><polyline points="${points}" fill="none" stroke="var(--mark)" ` +
        `stroke-width="1.5"/><circle cx="${x(values.length - 1)}" cy="${y(values[values.length - 1])}" r="3" ` +
        `fill="var(--mark)"/></svg>`,
      "text/html"
    );
    return drawing.body.firstChild;
  }

  function showSpeeds(speeds) {
    const place = find(".speeds");
    const rows = speeds.filter(({ along_m_per_s: along }) => along.length);
    if (!rows.length) return place.replaceChildren();
    const table = made("table");
    const head = table.createTHead().insertRow();
    ["swimmer", "cycles", "along the own axis", "across it", "by cycle"].forEach((text) => head.append(made("th", text)));
    const body = table.createTBody();
    for (const { name, along_m_per_s: along, across_m_per_s: across } of rows) {
      const row = body.insertRow();
      const last = along.length - 1;
      [name, along.length, withUnit(along[last], "m/s"), withUnit(across[last], "m/s")].forEach((text) =>
        row.append(made("td", text))
      );
      row.insertCell().append(sparkline(along));
    }
    const scroll = Object.assign(made("div"), { className: "scroll" });
    scroll.append(table);
    place.replaceChildren(made("h3", "Speeds in the last cycle"), scroll);
  }

  async function showScene(scene) {
    if (view) return view.update(scene);
    figure.hidden = false;
    view = await openView(find(".stage"), scene, true);
    window.copepod.views.push(view);
  }

  /** The report of the run that has ended: its tables and figures, without its own view. False if there is none yet. */
  async function showReport() {
    const answer = await fetch("report");
    if (!answer.ok) return false;
    const report = new DOMParser().parseFromString(await answer.text(), "text/html");
    report.querySelectorAll(".view, h2, section > p").forEach((part) => part.remove());
    find(".report").replaceChildren(...report.querySelectorAll("section"));
    return true;
  }

  async function ask() {
    let wait = EVERY_MS;
    try {
      const answer = await fetch(`state?have=${encodeURIComponent(version)}`);
      if (!answer.ok) throw new Error(await answer.text());
      const content = await answer.json();
      showProgress(content);
      showSpeeds(content.speeds);
      version = content.version;
      if (content.scene) await showScene(content.scene);
      if (content.state !== "running") {
        wait = AFTER_END_MS;
        reported ||= await showReport();
      } else {
        reported = false;
      }
    } catch (problem) {
      find(".status").textContent = `The server does not answer (${problem.message}). Is copepod watch still running?`;
      find(".status").className = "status interrupted";
      version = "";
    }
    setTimeout(ask, wait);
  }
  ask();
})();
