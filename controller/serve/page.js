"use strict";
// Draws what the server-sent events tell. Every text goes in as text, never as markup.

const $ = (id) => document.getElementById(id);
const SVG = "http://www.w3.org/2000/svg";

function el(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  node.append(...children.filter((child) => child !== null));
  return node;
}

function svg(tag, attributes = {}, text = null) {
  const node = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  if (text !== null) node.textContent = text;
  return node;
}

// --- words ---

const known = (x) => typeof x === "number" && Number.isFinite(x);
const short = (x, digits = 3) => (known(x) ? String(Number(x.toPrecision(digits))) : "-");
const percent = (x) => (known(x) ? short(100 * x) + " %" : "-");
const um = (x) => (known(x) ? (1e6 * x).toFixed(1) : "-");

function duration(s) {
  if (!known(s)) return "-";
  if (s < 59.95) return s.toFixed(1) + " s";
  const whole = Math.round(s), two = (n) => String(n).padStart(2, "0");
  if (whole < 3600) return `${Math.floor(whole / 60)} min ${two(whole % 60)} s`;
  if (whole < 172800) return `${Math.floor(whole / 3600)} h ${two(Math.floor(whole / 60) % 60)} min`;
  return `${Math.floor(whole / 86400)} d ${two(Math.floor(whole / 3600) % 24)} h`;
}

// "1:02.3": for a column of times.
function clock(s) {
  const tenths = Math.round(10 * s), whole = Math.floor(tenths / 10), two = (n) => String(n).padStart(2, "0");
  if (whole < 3600) return `${Math.floor(whole / 60)}:${two(whole % 60)}.${tenths % 10}`;
  return `${Math.floor(whole / 3600)}:${two(Math.floor(whole / 60) % 60)}:${two(whole % 60)}`;
}

function coresOf(list) {
  const parts = [];
  for (let k = 0; k < list.length; ) {
    let end = k;
    while (end + 1 < list.length && list[end + 1] === list[end] + 1) ++end;
    parts.push(end > k ? `${list[k]}-${list[end]}` : String(list[k]));
    k = end + 1;
  }
  return parts.join(", ") || "none";
}

const kindWords = {dem: "DEM", pbm: "PBM"};
const kindOf = (kind) => kindWords[kind] || kind;
const drawnKind = (kind) => (["dem", "pbm", "estimation", "monitor"].includes(kind) ? kind : "other");

// --- charts ---

// Round numbers that cover low..high in about n steps.
function ticks(low, high, n) {
  if (!(high > low)) return [low];
  const raw = (high - low) / n, power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 2.5, 5, 10].map((f) => f * power).find((s) => s >= raw * 0.999);
  const list = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) list.push(k * step);
  return list;
}

// A frame with axes; x() and y() bring numbers into it.
class Chart {
  constructor(width, height, xs, ys, xLabel, yLabel) {
    Object.assign(this, {width, height, xs, ys, left: 56, right: width - 14, top: 16, bottom: height - 48});
    this.root = svg("svg", {viewBox: `0 0 ${width} ${height}`, role: "img"});
    for (const t of ticks(ys[0], ys[1], 4)) {
      this.add("line", {class: "grid", x1: this.left, x2: this.right, y1: this.y(t), y2: this.y(t)});
      this.add("text", {x: this.left - 7, y: this.y(t) + 4, "text-anchor": "end"}, short(t, 4));
    }
    for (const t of ticks(xs[0], xs[1], width > 800 ? 10 : 5)) {
      this.add("line", {class: "frame", x1: this.x(t), x2: this.x(t), y1: this.bottom, y2: this.bottom + 4});
      this.add("text", {x: this.x(t), y: this.bottom + 18, "text-anchor": "middle"}, short(t, 4));
    }
    this.add("line", {class: "frame", x1: this.left, x2: this.right, y1: this.bottom, y2: this.bottom});
    this.add("text", {x: this.right, y: height - 4, "text-anchor": "end"}, xLabel);
    this.add("text", {x: 2, y: 10}, yLabel);
  }
  x(v) { return this.left + ((v - this.xs[0]) / (this.xs[1] - this.xs[0] || 1)) * (this.right - this.left); }
  y(v) { return this.bottom - ((v - this.ys[0]) / (this.ys[1] - this.ys[0] || 1)) * (this.bottom - this.top); }
  add(tag, attributes, text = null) { this.root.append(svg(tag, attributes, text)); }
  curve(time, value, attributes) {
    let path = "", pen = "M";
    time.forEach((t, k) => {
      if (!known(value[k])) return void (pen = "M");
      path += `${pen}${this.x(t).toFixed(1)} ${this.y(value[k]).toFixed(1)}`;
      pen = "L";
    });
    this.add("path", {...attributes, class: "curve " + attributes.class, d: path});
  }
  // A tick at the start and the end of each burst, below the axis.
  bursts(list, kind) {
    for (const b of list) {
      if (!known(b.end_s)) continue;
      const from = Math.max(this.left, this.x(b.start_s)), to = Math.min(this.right, this.x(b.end_s));
      if (to > from) this.add("rect", {class: `burst ${kind}`, x: from + 0.5, y: this.bottom + 24, width: Math.max(0.5, to - from - 1), height: 4, rx: 1});
    }
  }
}

function range(values, from = null) {
  const all = values.filter(known);
  let low = from ?? Math.min(...all), high = Math.max(...all);
  if (!(high > low)) [low, high] = [low - Math.abs(low) * 0.05 - 1e-9, high + Math.abs(high) * 0.05 + 1e-9];
  const margin = 0.06 * (high - low);
  return [from ?? low - margin, high + margin];
}

function put(place, chart) {
  place.replaceChildren(chart ? chart.root : el("p", {class: "soft"}, "Nothing yet."));
}

function allBursts(view) { return view.burst ? [...view.bursts, {...view.burst, end_s: view.burst_time_s}] : view.bursts; }

function drawSizes(view) {
  const {time_s: time, d50_m: d50} = view.sizes;
  if (time.length < 2) return put($("sizes"), null);
  const values = d50.map((row) => row.map((x) => (known(x) ? 1e6 * x : null)));
  const chart = new Chart(620, 290, [time[0], time[time.length - 1]], range(values.flat()), "process time [s]", "d50 [um]");
  values.forEach((row, x) => {
    const opacity = values.length > 1 ? 0.3 + (0.7 * x) / (values.length - 1) : 1;
    chart.curve(time, row, {class: "pbm", opacity: opacity.toFixed(2)});
  });
  chart.bursts(allBursts(view).filter((b) => b.kind === "pbm"), "pbm");
  put($("sizes"), chart);
}

function drawContacts(view) {
  const {time_s: time, collisions_1_s: collisions, impacts_1_s: impacts} = view.contacts;
  if (time.length < 2) return put($("contacts"), null);
  const chart = new Chart(620, 290, [time[0], time[time.length - 1]], range([...collisions, ...impacts], 0), "DEM time [s]", "per particle [1/s]");
  chart.curve(time, collisions, {class: "dem"});
  chart.curve(time, impacts, {class: "dem", "stroke-dasharray": "5 4"});
  chart.add("text", {class: "key dem", x: chart.right, y: chart.y(collisions[collisions.length - 1]) - 9, "text-anchor": "end"}, "collisions");
  chart.add("text", {class: "key dem", x: chart.right, y: chart.y(impacts[impacts.length - 1]) - 9, "text-anchor": "end"}, "impacts");
  chart.bursts(allBursts(view).filter((b) => b.kind === "dem"), "dem");
  put($("contacts"), chart);
}

function drawFit(view) {
  $("fit").hidden = !view.fit;
  if (!view.fit) return;
  const {time_s: time, cost} = view.fit;
  if (time.length < 2) return put($("objective"), null);
  const logs = cost.map((c) => (c > 0 ? Math.log10(c) : null));
  const chart = new Chart(1260, 230, [time[0], time[time.length - 1]], range(logs), "wall time [s]", "log10 of half the sum of squares");
  chart.curve(time, logs, {class: "estimation"});
  put($("objective"), chart);
}

function drawCores(view) {
  const {slice_s: slice, busy} = view.core_history;
  const kinds = Object.keys(busy);
  const slices = Math.max(0, ...kinds.map((kind) => busy[kind].length));
  if (!slices || !view.cores) return put($("cores"), null);
  const end = Math.max(view.time_s, slice);
  const chart = new Chart(1260, 214, [0, end], [0, view.cores], "wall time [s]", "cores");
  const below = new Array(slices).fill(0);
  let key = chart.left + 6;
  for (const kind of kinds) {
    let path = "";
    busy[kind].forEach((cores, k) => {
      if (!(cores > 0)) return;
      const from = chart.x(k * slice), to = chart.x(Math.min(end, (k + 1) * slice)), foot = chart.y(below[k]);
      below[k] = Math.min(view.cores, below[k] + cores);
      path += `M${from.toFixed(1)} ${foot.toFixed(1)}V${chart.y(below[k]).toFixed(1)}H${to.toFixed(1)}V${foot.toFixed(1)}Z`;
    });
    chart.add("path", {class: `fill ${drawnKind(kind)}`, d: path});
    chart.add("text", {class: `key ${drawnKind(kind)}`, x: key + 44, y: 10}, kindOf(kind));
    key += 34 + 8 * kind.length;
  }
  put($("cores"), chart);
}

// --- the rest of the page ---

function card(value, what, more = {}) {
  const node = el("div", {class: "card"}, el("b", {class: more.good ? "good" : ""}, value));
  if (known(more.share)) {
    const meter = svg("svg", {viewBox: "0 0 100 6", preserveAspectRatio: "none"});
    meter.append(svg("rect", {class: "fill " + (more.kind || "dem"), width: 100 * Math.min(1, Math.max(0, more.share)), height: 6}));
    node.append(el("div", {class: "meter"}, meter));
  }
  node.append(el("span", {}, what));
  return node;
}

function timeLeft(view) {
  const left = view.time_left;
  if (!left) return null;
  const one = left.most_s - left.least_s < 0.5, none = left.least_s < 0.5;
  const words = one ? "about " + duration(left.most_s) : none ? "at most " + duration(left.most_s) : `${duration(left.least_s)} to ${duration(left.most_s)}`;
  return card(words, "left: " + left.how);
}

function steadyCard(view) {
  const s = view.steadiness;
  if (!s) return null;
  const yes = [s.dem_quiet, s.rounds >= s.least_rounds, s.rounds_agree].filter(Boolean).length;
  const change = known(s.change) ? `rounds differ ${percent(Math.abs(s.change))} of ${percent(s.tolerance)} (${s.changed}${s.where && s.where !== "all" ? ", " + s.where : ""})` : "no two rounds to compare yet";
  return card(`${yes} of 3 signs of steady`, `DEM quiet ${short(s.quiet_time_s)} of ${short(s.window_s)} s; ${s.rounds} of at least ${s.least_rounds} rounds; ${change}`, {good: yes === 3});
}

function fitCards(view) {
  if (!view.fit) return [];
  const shown = (p, v) => (p.unit === "m" ? um(v) + " um" : short(v) + (p.unit === "1" ? "" : " " + p.unit));
  const fit = card(short(view.fit.misfit), `squares per datum after ${view.fit.evaluations} evaluations on idle cores (${view.fit.phase})`);
  return [fit, ...view.fit.parameters.map((p) => card(shown(p, p.value), known(p.low) ? `${p.name}; 95 % within ${shown(p, p.low)} to ${shown(p, p.high)}` : p.name))];
}

function cards(view) {
  const list = [card(duration(view.time_s), "wall time"), timeLeft(view)];
  if (view.coupled) {
    const b = view.burst;
    if (b) list.push(card(b.name, `${short(view.burst_time_s, 4)} s of ${short(b.start_s, 4)} to ${short(b.start_s + b.longest_s, 4)} s; ${b.why_started}`, {share: (view.burst_time_s - b.start_s) / b.longest_s, kind: b.kind}));
    list.push(card(`${short(view.process_time_s, 4)} of ${short(view.process_end_s, 4)} s`, `process time; DEM clock ${short(view.dem_time_s, 4)} s`, {share: view.process_time_s / view.process_end_s, kind: "pbm"}));
    const d50 = view.sizes.d50_m.map((row) => row[row.length - 1]).filter(known);
    if (d50.length) list.push(card(um(d50[d50.length - 1]) + " um", `d50 at the outlet; ${um(Math.min(...d50))} to ${um(Math.max(...d50))} um over the compartments`));
    const c = view.contacts, n = c.time_s.length - 1;
    if (n >= 0) list.push(card(Math.round(c.particles[n]) + " particles", `in the DEM; ${short(c.collisions_1_s[n])} collisions and ${short(c.impacts_1_s[n])} impacts a second for each`));
    list.push(steadyCard(view));
  }
  list.push(...fitCards(view));
  const idle = view.phase === "ended" || view.phase === "waiting";
  list.push(card(percent(view.core_use), idle ? `core use of ${view.cores} cores` : `core use; now ${view.busy_cores} of ${view.cores} busy`, {share: view.core_use, kind: "estimation"}));
  const counts = Object.entries(view.counts).map(([state, n]) => `${n} ${state}`).join(", ");
  if (counts) list.push(card(counts.split(", ")[0], counts.split(", ").slice(1).join(", ") || "tasks"));
  if (view.fillers) list.push(card(`${view.fillers_done} of ${view.fillers}`, "estimation runs done, on idle cores", {share: view.fillers_done / view.fillers, kind: "estimation"}));
  $("cards").replaceChildren(...list.filter((one) => one !== null));
}

const cell = (text, name = "") => el("td", name ? {class: name} : {}, text);

function tables(view) {
  $("tasks").tBodies[0].replaceChildren(...view.tasks.map((t) => el("tr", {}, cell(t.name, "name " + drawnKind(t.kind)), cell(kindOf(t.kind)), cell(t.state + (t.attempt > 1 ? `, attempt ${t.attempt}` : "")), cell(duration(t.seconds), "n"), cell(coresOf(t.cores)))));
  $("tasks").hidden = view.tasks.length === 0;
  $("no-tasks").hidden = view.tasks.length > 0;
  $("bursts-panel").hidden = view.bursts.length === 0;
  $("bursts").tBodies[0].replaceChildren(...view.bursts.slice().reverse().map((b) => {
    const result = b.kind === "dem" ? `${short(b.collision_rate_1_s)} collisions/s` : `d50 ${um(b.d50_smallest_m)} to ${um(b.d50_largest_m)} um`;
    return el("tr", {}, cell(b.name, "name " + b.kind), cell(b.reason, "word"), cell(b.message), cell(`${short(b.start_s, 4)} to ${short(b.end_s, 4)} s`, "n"), cell(duration(b.pilot_end_s - b.pilot_start_s), "n"), cell(result, "n"));
  }));
  const list = $("happenings"), low = list.scrollHeight - list.scrollTop - list.clientHeight < 40;
  list.replaceChildren(...view.happenings.map((h) => el("li", {class: h.level}, el("span", {class: "at"}, clock(h.time_s)), el("span", {}, h.words))));
  if (low) list.scrollTop = list.scrollHeight;
}

function show(view) {
  document.title = `${view.campaign}: ${view.phase}`;
  $("campaign").textContent = view.campaign;
  const end = view.exit === null ? "" : view.exit === 0 ? "ok" : view.exit === 4 ? "stopped" : "failed";
  $("phase").textContent = view.exit === null ? view.phase : `${view.phase}, exit code ${view.exit}`;
  $("phase").className = `badge ${view.phase} ${end}`;
  $("headline").textContent = view.headline;
  $("folder").textContent = view.folder + (view.mode ? `, coupled ${view.mode}` : "") + (view.nodes > 1 ? `, ${view.nodes} nodes` : "");
  $("warnings").hidden = view.warnings.length === 0;
  $("warnings").replaceChildren(...view.warnings.map((text) => el("li", {}, text)));
  $("coupled").hidden = !view.coupled;
  $("cores-caption").textContent = `Core seconds used: ${percent(view.core_use)} of ${view.cores} cores` + (view.core_use_fillers > 0 ? `, of which estimation ${percent(view.core_use_fillers)}.` : ".");
  cards(view);
  if (view.coupled) drawSizes(view), drawContacts(view);
  drawFit(view);
  drawCores(view);
  tables(view);
}

let updates = 0;
const events = new EventSource("events");
events.addEventListener("view", (event) => {
  show(JSON.parse(event.data));
  $("updates").textContent = String(++updates);
  $("link").textContent = "";
});
events.onerror = () => {
  $("link").textContent = "; the connection is lost: is `granary serve` still running?";
};
