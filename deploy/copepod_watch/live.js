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
    const { openView } = window.copepod;
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
      find(".speeds").replaceChildren(...parsed(content.speeds).childNodes);
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
