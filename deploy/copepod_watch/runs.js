"use strict";
// The live page of a campaign: asks for the state of its runs every few seconds, and shows what has changed.
(() => {
  const EVERY_MS = 3000;
  const find = (selector) => document.getElementById("runs").querySelector(selector);
  let version = "";

  const parsed = (html) => new DOMParser().parseFromString(html, "text/html").body;

  /** Cell by cell, so that the table stays where it was scrolled to, and links keep the focus. */
  function showTable(html) {
    const fresh = parsed(html);
    const [cells, shown] = [fresh, find(".table")].map((place) => [...place.querySelectorAll("th, td")]);
    if (cells.length !== shown.length) return find(".table").replaceChildren(...fresh.childNodes);
    cells.forEach((cell, place) => {
      if (cell.innerHTML !== shown[place].innerHTML) shown[place].replaceChildren(...cell.childNodes);
    });
  }

  async function ask() {
    const status = find(".status");
    try {
      const answer = await fetch(`state?have=${encodeURIComponent(version)}`);
      if (!answer.ok) throw new Error(await answer.text());
      const { sentence, share, table, version: newest, figures } = await answer.json();
      if (status.textContent !== sentence) status.textContent = sentence;
      status.className = "status";
      find(".whole").value = share;
      document.title = `${Math.floor(100 * share)} %: ${document.title.split(": ").pop()}`;
      showTable(table);
      if (figures !== null) find(".answer").replaceChildren(...parsed(figures).childNodes);
      version = newest;
    } catch (problem) {
      status.textContent = `The server does not answer (${problem.message}). Is copepod watch still running?`;
      status.className = "status interrupted";
      version = "";
    }
    setTimeout(ask, EVERY_MS);
  }
  ask();
})();
