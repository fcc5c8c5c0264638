"use strict";
(() => {
  const find = (selector, parent = document) => parent.querySelector(selector);
  const all = (selector, parent = document) => [...parent.querySelectorAll(selector)];
  const root = document.documentElement;
  let rows = all("#overview tbody tr");
  const MIN_WIDTH = 900;

  // The data of the page are compressed; each part is unpacked once, when it is first needed.
  async function unpack(id) {
    const bytes = Uint8Array.from(atob(find("#" + id).textContent), (c) => c.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).arrayBuffer();
  }
  const text = (buffer) => new TextDecoder().decode(buffer);

  // A block holds the figures and tables of some tracks as JSON, and behind it their columns.
  const BLOCK = {{ block_size }};
  const blocks = new Map();
  async function loadBlock(number) {
    const buffer = await unpack("data-" + number);
    const size = new DataView(buffer).getUint32(0, true);
    const header = JSON.parse(text(buffer.slice(4, 4 + size)));
    locate(header.columns.flat(), new Uint8Array(buffer, 4 + size));
    return { ...header, tracks: new Map() };
  }
  async function content(index) {
    const number = Math.floor(index / BLOCK);
    if (!blocks.has(number)) blocks.set(number, loadBlock(number));
    const block = await blocks.get(number);
    const i = index % BLOCK;
    if (!block.tracks.has(i)) {
      const parts = ["comparison", "layout", "data", "tables", "updates"].map((part) => [part, block[part][i]]);
      block.tracks.set(i, resolve(Object.fromEntries(parts), block.columns[i]));
    }
    return block.tracks.get(i);
  }
  // The forms of columns; see packing.py: bytes are sorted by form, plane and column.
  const FORMS = {{ forms|tojson }};
  const planes = (form) => (form === "b" ? 1 : Number(form[1]));
  const length = ({ form, n }) => (form === "b" ? Math.ceil(n / 8) : n);
  function locate(columns, bytes) {
    const totals = Object.fromEntries(FORMS.map((form) => [form, 0]));
    for (const one of columns) {
      one.at = totals[one.form];
      totals[one.form] += length(one);
    }
    let start = 0;
    const regions = {};
    for (const form of FORMS) {
      regions[form] = bytes.subarray(start);
      start += planes(form) * totals[form];
    }
    for (const one of columns) {
      const at = (plane) => plane * totals[one.form] + one.at;
      one.planes = Array.from({ length: planes(one.form) }, (_, plane) => regions[one.form].subarray(at(plane)));
    }
  }
  function numbers(one) {
    one.numbers ??= decode(one);
    return one.numbers;
  }
  function decode({ form, n, low, step, zero, planes }) {
    if (form === "b") return Uint8Array.from({ length: n }, (_, i) => (planes[0][i >> 3] >> (7 - (i & 7))) & 1);
    const range = 256 ** planes.length, values = new Float64Array(n);
    let last = 0;
    for (let i = 0; i < n; i++) {
      let code = 0;
      for (const plane of planes) code = 256 * code + plane[i];
      if (form.endsWith("d")) code = last = (last + code) % range;
      const value = code === range - 1 ? NaN : low + code * step;
      values[i] = form[0] === "l" ? (zero && code === 0 ? 0 : Math.exp(value)) : value;
    }
    return values;
  }
  // References to columns become arrays of numbers.
  function resolve(value, columns) {
    if (Array.isArray(value)) return value.map((v) => resolve(v, columns));
    if (!value || typeof value !== "object") return value;
    if ("column" in value) {
      const all = numbers(columns[value.column]);
      if (!("rows" in value)) return all;
      const rows = numbers(columns[value.rows]);
      return all.filter((_, i) => rows[i]);
    }
    const whole = Object.fromEntries(Object.entries(value).map(([k, v]) => [k, resolve(v, columns)]));
    if ("product" in whole) return Float64Array.from(whole.product[0], (v, i) => v * whole.product[1][i]);
    if ("names" in whole) return Array.from(whole.codes, (code) => whole.names[code]);
    if ("around" in whole) {
      const { around: [x, centre, std], factor, ...trace } = whole;
      const side = (sign) => Array.from(centre, (v, i) => v + sign * factor * std[i]);
      return outlined({ band: [x, side(-1), side(1)], ...trace });
    }
    return "band" in whole ? outlined(whole) : whole;
  }
  // The outline of a band: along its upper side, back along its lower, for each run without gaps.
  function outlined({ band: [x, low, high], ...trace }) {
    const xs = [], ys = [];
    let start = 0;
    for (let i = 0; i <= x.length; i++) {
      if (i < x.length && x[i] + low[i] + high[i] - high[i] === x[i] + low[i]) continue;
      if (xs.length && i > start) xs.push(NaN), ys.push(NaN);
      for (let k = start; k < i; k++) xs.push(x[k]), ys.push(high[k]);
      for (let k = i - 1; k >= start; k--) xs.push(x[k]), ys.push(low[k]);
      start = i + 1;
    }
    return { ...trace, x: xs, y: ys };
  }
  async function loadPlotly() {
    const script = document.createElement("script");
    script.textContent = text(await unpack("plotly"));
    document.head.append(script);
  }

  // Colours are given as roles ("@high/0.2"); the current theme maps them to colours.
  function paint(value, style) {
    if (ArrayBuffer.isView(value)) return value;
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
  let base = null;
  async function drawComparison() {
    const on = drawn();
    base ??= JSON.parse(text(await unpack("comparison-data")));
    const parts = [];
    for (const row of on) parts.push(await content(row.dataset.index));
    const lines = (trace) => trace.mode === "lines";
    const data = parts.flatMap((part) => part.comparison).sort((a, b) => lines(a) - lines(b));
    const names = on.map((row) => row.dataset.name);
    find("#drawn").textContent = `${on.length} of ${rows.length} drawn; switch them in the table above`;
    find("#comparison").dataset.tracks = JSON.stringify(names);
    await draw(find("#comparison"), { data, layout: base.layout });
  }
  // Each track has an element that is filled when it is opened.
  function addDetails(row) {
    const details = find("#track-template").content.firstElementChild.cloneNode(true);
    details.id = "track-" + row.dataset.index;
    details.dataset.index = row.dataset.index;
    const name = document.createElement("b");
    name.textContent = row.dataset.name;
    find("summary", details).append(find(".swatch", row).cloneNode(), name, " ", find(".chip", row).cloneNode(true));
    find(".summary", details).textContent = find(".text p", row).textContent;
    const label = `NIS, NEES, measurements and states of ${row.dataset.name} over time; the tables below hold the numbers`;
    find(".figure", details).setAttribute("aria-label", label);
    details.hidden = !isOn(row);
    find("#tracks").append(details);
  }
  async function drawTrack(details) {
    if (!details.open || details.hidden) return;
    const part = await content(details.dataset.index);
    const tables = find(".tables", details);
    if (!tables.childElementCount) for (const table of part.tables) tables.append(textTable(table));
    await draw(find(".track-figure", details), { data: part.data, layout: part.layout });
    details.dataset.drawn = "yes";
  }
  async function listUpdates(details) {
    const container = find(".scroll", details);
    if (!details.open || container.childElementCount) return;
    const { updates } = await content(details.closest(".track").dataset.index);
    const head = Object.keys(updates);
    const format = (v) => (typeof v === "number" ? (Number.isNaN(v) ? "–" : String(Number(v.toPrecision(4)))) : v ?? "–");
    const columns = head.map((name) => Array.from(updates[name], format));
    const rows = (columns[0] ?? []).map((_, i) => columns.map((values) => values[i]));
    container.append(textTable({ head, rows }).firstElementChild);
  }
  function textTable({ caption, head, rows }) {
    const table = document.createElement("table");
    if (caption) table.createCaption().textContent = caption;
    const headRow = table.createTHead().insertRow();
    for (const name of head) {
      const cell = document.createElement("th");
      cell.scope = "col";
      cell.textContent = name;
      headRow.append(cell);
    }
    const body = table.createTBody();
    for (const cells of rows) {
      const row = body.insertRow();
      for (const cell of cells) row.insertCell().textContent = cell;
    }
    const scroll = document.createElement("div");
    scroll.className = "scroll";
    scroll.append(table);
    return scroll;
  }

  // Check boxes: several changes within 30 ms are drawn once.
  let waiting = null;
  function redraw(everything) {
    clearTimeout(waiting);
    waiting = setTimeout(() => attempt(async () => {
      await drawComparison();
      if (everything) for (const details of all(".track[data-drawn]")) await drawTrack(details);
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
    if (find("#rows")) {
      find("#overview tbody").innerHTML = text(await unpack("rows"));
      rows = all("#overview tbody tr");
    }
    rows.forEach(addDetails);
    listen();
    await drawComparison();
    const first = find("details.track:not([hidden])");
    if (first) first.open = true;
    if (first) await drawTrack(first);
    root.dataset.ready = "yes";
  });
})();
