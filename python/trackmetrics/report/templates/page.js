"use strict";
(() => {
  const find = (selector, parent = document) => parent.querySelector(selector);
  const all = (selector, parent = document) => [...parent.querySelectorAll(selector)];
  const root = document.documentElement;
  const rows = all("#overview tbody tr");
  const MIN_WIDTH = 900;

  // The data of the page are compressed; each part is unpacked once, when it is first needed.
  const unpacked = new Map();
  async function unpack(id) {
    const bytes = Uint8Array.from(atob(find("#" + id).textContent), (c) => c.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).text();
  }
  function content(id) {
    if (!unpacked.has(id)) unpacked.set(id, unpack(id).then(JSON.parse));
    return unpacked.get(id);
  }
  async function loadPlotly() {
    const script = document.createElement("script");
    script.textContent = await unpack("plotly");
    document.head.append(script);
  }

  // Colours are given as roles ("@high/0.2"); the current theme maps them to colours.
  function paint(value, style) {
    if (Array.isArray(value)) return typeof value[0] === "number" ? value : value.map((v) => paint(v, style));
    if (value && typeof value === "object")
      return Object.fromEntries(Object.entries(value).map(([k, v]) => [k, paint(v, style)]));
    if (typeof value !== "string" || value[0] !== "@") return value;
    const [role, alpha] = value.slice(1).split("/");
    const hex = style.getPropertyValue("--" + role).trim();
    const part = (i) => parseInt(hex.slice(i, i + 2), 16);
    return `rgba(${part(1)},${part(3)},${part(5)},${alpha ?? 1})`;
  }
  const CONFIG = { displaylogo: false, modeBarButtonsToRemove: ["lasso2d", "select2d", "autoScale2d"] };
  function draw(container, figure) {
    const width = Math.max(MIN_WIDTH, container.clientWidth);
    const painted = paint(figure, getComputedStyle(root));
    return Plotly.react(container, painted.data, { ...painted.layout, width }, CONFIG);
  }

  const isOn = (row) => find(".draw", row).checked;
  const drawn = () => rows.filter(isOn).sort((a, b) => a.dataset.index - b.dataset.index);
  async function drawComparison() {
    const on = drawn();
    const base = await content("comparison-data");
    const parts = await Promise.all(on.map((row) => content("data-" + row.dataset.index)));
    const lines = (trace) => trace.mode === "lines";
    const data = parts.flatMap((part) => part.comparison).sort((a, b) => lines(a) - lines(b));
    const names = on.map((row) => row.dataset.name);
    find("#drawn").textContent = `${on.length} of ${rows.length} drawn; switch them in the table above`;
    find("#comparison").dataset.tracks = JSON.stringify(names);
    await draw(find("#comparison"), { data, layout: base.layout });
  }
  async function drawTrack(details) {
    if (!details.open || details.hidden) return;
    const part = await content("data-" + details.dataset.index);
    await draw(find(".track-figure", details), part.track);
    details.dataset.drawn = "yes";
  }
  async function listUpdates(details) {
    const container = find(".scroll", details);
    if (!details.open || container.childElementCount) return;
    const { updates } = await content("data-" + details.closest(".track").dataset.index);
    container.append(updateTable(updates));
  }
  function updateTable(columns) {
    const table = document.createElement("table");
    const names = Object.keys(columns);
    const head = table.createTHead().insertRow();
    for (const name of names) {
      const cell = document.createElement("th");
      cell.scope = "col";
      cell.textContent = name;
      head.append(cell);
    }
    const body = table.createTBody();
    (columns.minute ?? []).forEach((_, i) => {
      const row = body.insertRow();
      for (const name of names) row.insertCell().textContent = columns[name][i] ?? "–";
    });
    return table;
  }

  // Check boxes: several changes within 30 ms are drawn once.
  let waiting = null;
  function redraw(everything) {
    clearTimeout(waiting);
    waiting = setTimeout(() => attempt(async () => {
      await drawComparison();
      if (everything) await Promise.all(all(".track[data-drawn]").map(drawTrack));
    }), 30);
  }
  function show(row, on) {
    find(".draw", row).checked = on;
    row.classList.toggle("off", !on);
    const details = find("#track-" + row.dataset.index);
    details.hidden = !on;
    attempt(() => drawTrack(details));
  }
  function filter() {
    const wanted = find("#find").value.trim().toLowerCase();
    const verdicts = all("#counts [aria-pressed=true]").map((chip) => chip.dataset.verdict);
    for (const row of rows) {
      const verdict = !verdicts.length || verdicts.includes(row.dataset.verdict);
      row.hidden = !verdict || !row.textContent.toLowerCase().includes(wanted);
    }
  }
  const KEYS = {
    name: (row) => row.dataset.name,
    severity: (row) => Number(row.dataset.index),
    since: (row) => Number(row.dataset.since.replace("inf", "Infinity")),
    scale: (row) => Number(row.dataset.scale.replace("nan", "Infinity")),
    weakest: (row) => row.dataset.weakest || "\uffff",
  };
  function sort(button) {
    const head = button.closest("th");
    const up = button.dataset.sort === "severity" ? "descending" : "ascending";
    const down = up === "ascending" ? "descending" : "ascending";
    const order = head.getAttribute("aria-sort") === up ? down : up;
    all("#overview th").forEach((th) => th.removeAttribute("aria-sort"));
    head.setAttribute("aria-sort", order);
    const key = KEYS[button.dataset.sort];
    const compare = (a, b) => (key(a) < key(b) ? -1 : key(a) > key(b) ? 1 : 0);
    const sorted = [...rows].sort((a, b) => (order === up ? compare(a, b) : compare(b, a)));
    find("#overview tbody").append(...sorted);
  }
  function changeTheme() {
    const next = { system: "light", light: "dark", dark: "system" }[root.dataset.theme ?? "system"];
    if (next === "system") delete root.dataset.theme;
    else root.dataset.theme = next;
    find("#theme span").textContent = next;
    redraw(true);
  }
  async function attempt(action) {
    try {
      await action();
    } catch (error) {
      const message = find("#message");
      message.textContent = `The figures could not be drawn: ${error.message ?? error}`;
      message.hidden = false;
      console.error(error);
    }
  }

  function listen() {
    for (const row of rows) {
      row.classList.toggle("off", !isOn(row));
      find(".draw", row).addEventListener("change", (event) => {
        show(row, event.target.checked);
        redraw(false);
      });
    }
    for (const link of all("#overview a, #predictions a"))
      link.addEventListener("click", () => {
        const details = find(link.getAttribute("href"));
        show(rows.find((row) => row.dataset.index === details.dataset.index), true);
        details.open = true;
        redraw(false);
      });
    for (const button of all("[data-draw]"))
      button.addEventListener("click", () => {
        const want = { all: () => true, none: () => false, first: (row) => row.dataset.index < {{ shown }} };
        for (const row of rows) show(row, want[button.dataset.draw](row));
        redraw(false);
      });
    for (const chip of all("#counts [data-verdict]"))
      chip.addEventListener("click", () => {
        chip.setAttribute("aria-pressed", chip.getAttribute("aria-pressed") !== "true");
        filter();
      });
    find("#find").addEventListener("input", filter);
    all("[data-sort]").forEach((button) => button.addEventListener("click", () => sort(button)));
    find("#theme").addEventListener("click", changeTheme);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => redraw(true));
    addEventListener("resize", () => redraw(true));
    for (const details of all("details.track"))
      details.addEventListener("toggle", () => attempt(() => drawTrack(details)));
    for (const details of all("details.updates"))
      details.addEventListener("toggle", () => attempt(() => listUpdates(details)));
  }

  attempt(async () => {
    if (!window.DecompressionStream) throw new Error("this browser is too old to unpack them");
    await loadPlotly();
    listen();
    await drawComparison();
    await Promise.all(all("details.track[open]").map(drawTrack));
    root.dataset.ready = "yes";
  });
})();
