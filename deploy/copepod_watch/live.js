"use strict";
// The live pages of a run and of a campaign: they ask for the state again and again, and show what has changed.
(() => {
  const AFTER_END_MS = 5000; // the run may be resumed
  const parsed = (html) => new DOMParser().parseFromString(html, "text/html").body;

  /** Asks every so often. `show(content)` may return another time to wait; the server sends what `version` lacks. */
  function follow(find, every_ms, show) {
    const status = find(".status");
    let version = "";
    async function ask() {
      let wait_ms = every_ms;
      try {
        const answer = await fetch(`state?have=${encodeURIComponent(version)}`);
        if (!answer.ok) throw new Error(await answer.text());
        const content = await answer.json();
        version = content.version;
        wait_ms = (await show(content)) || every_ms;
      } catch (problem) {
        status.textContent = `The server does not answer (${problem.message}). Is copepod watch still running?`;
        status.className = "status interrupted";
        version = "";
      }
      setTimeout(ask, wait_ms);
    }
    ask();
  }

  function showStatus(find, text, state) {
    const status = find(".status");
    if (status.textContent !== text) status.textContent = text;
    status.className = `status ${state}`;
  }

  /** Writes how far it is in front of the name of the page. */
  const entitle = (progress) => (document.title = `${progress}: ${document.title.split(": ").pop()}`);

  /** What shows the state of a run. */
  function ofRun(find) {
    const { element, openView, withUnit } = window.copepod;
    let view = null;
    let reported = false;

    function showProgress({ state, sentence, phase, step, steps, figures }) {
      showStatus(find, phase && phase !== "running" ? `${sentence} It is ${phase}.` : sentence, state);
      const bar = find("progress");
      Object.assign(bar, { max: steps || 1, value: step });
      bar.setAttribute("aria-label", `step ${step} of ${steps}`);
      find(".pace").textContent = [`step ${step} of ${steps}`, ...figures].join(", ");
      entitle(`${steps ? Math.floor((100 * step) / steps) : 0} % ${state}`);
    }

    /** A line of the values, with as many places as the widest run has. */
    function sparkline(values) {
      const [width, height] = [160, 28];
      const [low, high] = [Math.min(0, ...values), Math.max(0, ...values)];
      const x = (place) => 3 + (place * (width - 6)) / Math.max(1, values.length - 1);
      const y = (value) => height - 3 - ((value - low) / (high - low || 1)) * (height - 6);
      const points = values.map((value, place) => `${x(place).toFixed(1)},${y(value).toFixed(1)}`).join(" ");
      const last = values.length - 1;
      return parsed(
        `<svg width="${width}" height="${height}" role="img" aria-label="by cycle">` +
          `<line x1="0" x2="${width}" y1="${y(0)}" y2="${y(0)}" stroke="var(--line)"/>` +
          `<polyline points="${points}" fill="none" stroke="var(--mark)" stroke-width="1.5"/>` +
          `<circle cx="${x(last)}" cy="${y(values[last])}" r="3" fill="var(--mark)"/></svg>`
      ).firstChild;
    }

    function showSpeeds(speeds) {
      const place = find(".speeds");
      const rows = speeds.filter(({ along_m_per_s: along }) => along.length);
      if (!rows.length) return place.replaceChildren();
      const heads = ["swimmer", "cycles", "along the own axis", "across it", "by cycle"];
      const line = (cell, texts) => element("tr", {}, ...texts.map((text) => element(cell, {}, text)));
      const body = rows.map(({ name, along_m_per_s: along, across_m_per_s: across }) => {
        const last = [along, across].map((speeds) => withUnit(speeds[along.length - 1], "m/s"));
        return line("td", [name, along.length, ...last, sparkline(along)]);
      });
      const table = element("table", {}, element("thead", {}, line("th", heads)), element("tbody", {}, ...body));
      place.replaceChildren(element("h3", {}, "Speeds in the last cycle"), element("div", { class: "scroll" }, table));
    }

    async function showScene(scene) {
      if (view) return view.update(scene);
      view = await openView(find(".stage"), scene, true);
      window.copepod.views.push(view);
    }

    /** The report of the run that has ended: tables and figures, without its own view. False if there is none yet. */
    async function showReport() {
      const answer = await fetch("report");
      if (!answer.ok) return false;
      const report = parsed(await answer.text());
      report.querySelectorAll(".view, h2, section > p").forEach((part) => part.remove());
      find(".report").replaceChildren(...report.querySelectorAll("section"));
      return true;
    }

    return async (content) => {
      showProgress(content);
      showSpeeds(content.speeds);
      if (content.scene) await showScene(content.scene);
      const hasEnded = content.state !== "running";
      reported = hasEnded && (reported || (await showReport()));
      return hasEnded && AFTER_END_MS;
    };
  }

  /** What shows the state of the runs of a campaign. */
  function ofRuns(find) {
    /** Cell by cell, so that the table stays where it was scrolled to, and links keep the focus. */
    function showTable(html) {
      const fresh = parsed(html);
      const [cells, shown] = [fresh, find(".table")].map((place) => [...place.querySelectorAll("th, td")]);
      if (cells.length !== shown.length) return find(".table").replaceChildren(...fresh.childNodes);
      cells.forEach((cell, place) => {
        if (cell.innerHTML !== shown[place].innerHTML) shown[place].replaceChildren(...cell.childNodes);
      });
    }

    return ({ sentence, share, table, figures }) => {
      showStatus(find, sentence, "");
      find(".whole").value = share;
      entitle(`${Math.floor(100 * share)} %`);
      showTable(table);
      if (figures !== null) find(".answer").replaceChildren(...parsed(figures).childNodes);
    };
  }

  for (const [id, every_ms, shows] of [["live", 1000, ofRun], ["runs", 3000, ofRuns]]) {
    const section = document.getElementById(id);
    const find = (selector) => section.querySelector(selector);
    if (section) follow(find, every_ms, shows(find));
  }
})();
