"use strict";

const RPM = 30 / Math.PI; // what multiplies a speed in rad/s
const MODE_COUNT = 12;
const CAMPBELL_POINTS = 25;
const SYNCHRONOUS_POINTS = 300;
const TURNS = 4;
const byId = (id) => document.getElementById(id);

/** Bytes of a text in base 64. */
function bytesOf(text) {
  return Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
}

/** Lets the browser draw before the next computation. */
function drawn() {
  return new Promise((resolve) => setTimeout(resolve, 20));
}

function say(text, isError = false) {
  byId("status").textContent = text;
  byId("status").classList.toggle("error", isError);
}

/** An element of a drawing. */
function shape(name, attributes, text = "") {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  element.textContent = text;
  return element;
}

/** Points of a curve through nodes: cubic pieces whose slopes are those of a parabola through three nodes. */
function smooth(x, y) {
  const last = x.length - 1;
  if (last < 2) return x.map((at, node) => [at, y[node]]);
  const chord = (i) => (y[i + 1] - y[i]) / (x[i + 1] - x[i]);
  const slope = x.map((at, node) => {
    const i = Math.min(Math.max(node, 1), last - 1);
    const [before, after] = [x[i] - x[i - 1], x[i + 1] - x[i]];
    const bend = (chord(i) - chord(i - 1)) / (before + after);
    return chord(i - 1) + bend * (2 * at - x[i - 1] - x[i]);
  });
  const points = [];
  for (let i = 0; i < last; i++) {
    const length = x[i + 1] - x[i];
    for (let k = 0; k < 12; k++) {
      const t = k / 12;
      const [a, b] = [(1 + 2 * t) * (1 - t) ** 2, t * t * (3 - 2 * t)];
      const [c, d] = [t * (1 - t) ** 2, t * t * (t - 1)];
      points.push([x[i] + t * length, a * y[i] + b * y[i + 1] + length * (c * slope[i] + d * slope[i + 1])]);
    }
  }
  return [...points, [x[last], y[last]]];
}

/** Draws the shafts to scale from the side, one above the other, with the bow enlarged. */
function drawTrain(layout) {
  const radiusAt = (index) => Math.max(
    ...layout.shafts[index].pieces.flatMap((piece) => piece.outer_radii),
    ...layout.gears.filter((gear) => gear.shaft === index).map((gear) => gear.radius),
  );
  const length = Math.max(...layout.shafts.map((shaft) => shaft.length));
  const gap = 0.06 * length;
  const axes = [];
  let y = 0;
  layout.shafts.forEach((_, index) => {
    y += radiusAt(index) + gap;
    axes.push(y);
    y += radiusAt(index) + gap;
  });
  const margin = 0.16 * length;
  const largest = Math.max(...layout.shafts.flatMap((shaft) => shaft.bow));
  const enlarged = largest > 0 ? (0.6 * gap) / largest : 0;
  const drawing = shape("svg", { viewBox: `${-margin} 0 ${length + margin + 0.14 * length} ${y}`, role: "img" });
  const thin = { stroke: "#1b2733", "stroke-width": 0.0025 * length };
  layout.shafts.forEach((shaft, index) => {
    drawing.append(shape("text", { x: -margin, y: axes[index], "font-size": 0.028 * length, "dominant-baseline": "middle" }, shaft.name));
    for (const piece of shaft.pieces) {
      const [begin, end] = piece.outer_radii;
      const right = piece.x + piece.length;
      const y = axes[index];
      const corners = [[piece.x, y - begin], [right, y - end], [right, y + end], [piece.x, y + begin]];
      drawing.append(shape("polygon", { points: corners.join(" "), fill: "#d7dee5", ...thin, "stroke-width": 0.001 * length }));
    }
  });
  for (const gear of layout.gears) {
    const width = gear.width || 0.03 * length;
    drawing.append(shape("rect", {
      x: gear.x - width / 2, y: axes[gear.shaft] - gear.radius, width, height: 2 * gear.radius, fill: "#8fb3cc", "fill-opacity": 0.85, ...thin,
    }));
    drawing.append(shape("text", { x: gear.x + 0.7 * width, y: axes[gear.shaft] - 0.75 * gear.radius, "font-size": 0.024 * length }, `${gear.name} (${gear.teeth})`));
  }
  for (const disk of layout.disks) {
    const radius = 1.8 * radiusAt(disk.shaft) * (layout.gears.some((gear) => gear.shaft === disk.shaft) ? 0.5 : 1);
    drawing.append(shape("rect", { x: disk.x - 0.01 * length, y: axes[disk.shaft] - radius, width: 0.02 * length, height: 2 * radius, fill: "#b9a36b", ...thin }));
    drawing.append(shape("text", { x: disk.x + 0.015 * length, y: axes[disk.shaft] - radius, "font-size": 0.024 * length, "dominant-baseline": "hanging" }, disk.name));
  }
  for (const bearing of layout.bearings) {
    const size = 0.018 * length;
    const at = layout.shafts[bearing.shaft].pieces.find((one) => bearing.x <= one.x + one.length * 1.000001);
    const foot = axes[bearing.shaft] + at.outer_radii[1];
    drawing.append(shape("path", { d: `M ${bearing.x} ${foot} l ${size} ${1.6 * size} h ${-2 * size} z`, fill: "#fff", ...thin }));
  }
  layout.shafts.forEach((shaft, index) => {
    if (!shaft.bow.some((size) => size > 0)) return;
    const points = smooth(shaft.nodes, shaft.bow).map(([x, size]) => `${x},${axes[index] - enlarged * size}`);
    drawing.append(shape("polyline", { points: points.join(" "), fill: "none", stroke: "#c0392b", "stroke-width": 0.004 * length }));
  });
  const note = document.createElement("p");
  note.className = "note";
  const bow = largest > 0 ? ` Red: bow, ${Number(enlarged.toPrecision(1))} times enlarged, in its own plane.` : "";
  note.textContent = `Each shaft from its own left end, one below the other; disks without their size.${bow}`;
  byId("drawing").replaceChildren(drawing, note);
}

/** Fills a table. */
function tabulate(id, heads, rows) {
  const line = (cells, kind) => {
    const row = document.createElement("tr");
    row.append(...cells.map((cell) => Object.assign(document.createElement(kind), { textContent: cell })));
    return row;
  };
  byId(id).replaceChildren(line(heads, "th"), ...rows.map((cells) => line(cells, "td")));
}

function plot(id, traces, x, y, layout = {}) {
  const axes = { xaxis: { title: { text: x } }, yaxis: { title: { text: y } } };
  const common = { showlegend: true, margin: { l: 70, r: 20, t: 40, b: 50 }, legend: { orientation: "h", x: 0, y: 1.02, yanchor: "bottom" }, ...axes, ...layout };
  Plotly.react(id, traces, common, { responsive: true, displaylogo: false });
}

function plotCampbell(found) {
  const speeds = found.speeds.map((speed) => speed * RPM);
  const highest = Math.max(...found.frequencies_hz.flat());
  const modes = found.frequencies_hz[0].map((_, mode) => ({
    x: speeds, y: found.frequencies_hz.map((row) => row[mode]), mode: "lines", name: `mode ${mode + 1}`, showlegend: false, line: { color: "#1f5f8b" },
  }));
  const lines = found.lines.map((line) => {
    const x = found.speeds.filter((speed) => Math.abs(line.order) * speed <= highest * 2 * Math.PI);
    const ends = [0, ...x];
    return {
      x: ends.map((speed) => speed * RPM), y: ends.map((speed) => (Math.abs(line.order) * speed) / (2 * Math.PI)), mode: "lines", name: line.name, line: { dash: "dash", width: 1 },
    };
  });
  const at = found.intersections;
  const critical = {
    x: at.map((one) => one.speed * RPM), y: at.map((one) => one.frequency_hz), mode: "markers", name: "intersections",
    text: at.map((one) => `${one.line}, ${one.whirl}, damping ratio ${(100 * one.damping_ratio).toFixed(2)} %`), marker: { color: "#c0392b", size: 7 },
  };
  plot("campbell", [...modes, ...lines, critical], "speed of the reference shaft [rpm]", "frequency [Hz]", { yaxis: { title: { text: "frequency [Hz]" }, range: [0, highest * 1.05] } });
}

function plotSynchronous(found) {
  const traces = found.names.map((name, index) => ({ x: found.speeds.map((speed) => speed * RPM), y: found.semi_major_axes[index].map((size) => size * 1e6), mode: "lines", name }));
  plot("synchronous", traces, "speed of the reference shaft [rpm]", "semi-major axis of the orbit [µm]", { yaxis: { type: "log", title: { text: "semi-major axis of the orbit [µm]" }, exponentformat: "power" } });
}

function plotRun(run) {
  const micro = (values) => values.map((value) => value * 1e6);
  plot("orbits", run.points.map((point) => ({ x: micro(point.y), y: micro(point.z), mode: "lines", name: point.name })), "y [µm]", "z [µm]", { yaxis: { title: { text: "z [µm]" }, scaleanchor: "x" } });
  byId("meshing").hidden = run.meshes.length === 0;
  if (run.meshes.length === 0) return;
  const time = run.time.map((instant) => instant * 1e3);
  plot("contact", run.meshes.map((mesh) => ({ x: time, y: mesh.contact_ratio, mode: "lines", name: mesh.name })), "time [ms]", "contact ratio");
  plot("force", run.meshes.map((mesh) => ({ x: time, y: mesh.force.map((force) => force / 1e3), mode: "lines", name: mesh.name })), "time [ms]", "mesh force [kN]");
}

/** Calls a method of the train, and frees nothing: the caller frees the train. */
function asked(train, name, ...values) {
  return JSON.parse(train[name](...values));
}

let pending = false;
/** Largest bow of each shaft of the train as it is written [µm]. */
const present = new Map();

/** Computes with the train as it is written, with a bow [µm] of a shaft; an empty name keeps all bows. One computation at a time. */
async function withTrain(button, text, shaft, bow, work) {
  if (pending) return;
  pending = true;
  byId(button).disabled = true;
  say(text);
  await drawn();
  let train;
  try {
    train = new wasm_bindgen.Train(byId("scene").value, JSON.stringify(UNITS), shaft, bow * 1e-6);
    await work(train);
  } catch (error) {
    say(String(error.message ?? error), true);
  } finally {
    train?.free();
    byId(button).disabled = false;
    pending = false;
  }
}

async function compute() {
  if (pending) return;
  const begin = performance.now();
  const results = {};
  await withTrain("compute", "Assembling …", byId("shaft").value, byId("bow").value, async (train) => {
    const speed = byId("speed").value / RPM;
    const fastest = byId("fastest").value / RPM;
    const layout = asked(train, "layout");
    offerShafts(layout);
    limitBow(layout);
    byId("warnings").replaceChildren(...layout.warnings.map((text) => Object.assign(document.createElement("li"), { textContent: text })));
    drawTrain(layout);
    byId("bow-limits").hidden = true;
    const parts = [
      ["modes", () => {
        results.modes = asked(train, "modes", speed, MODE_COUNT);
        const rows = results.modes.map((mode, index) => [index + 1, mode.frequency_hz.toFixed(2), (100 * mode.damping_ratio).toFixed(2), mode.whirl]);
        tabulate("modes", ["mode", "frequency [Hz]", "damping ratio [%]", "motion"], rows);
      }],
      ["Campbell diagram", () => plotCampbell((results.campbell = asked(train, "campbell", fastest, CAMPBELL_POINTS, MODE_COUNT)))],
      ["synchronous response", () => plotSynchronous((results.synchronous = asked(train, "synchronous", fastest, SYNCHRONOUS_POINTS)))],
      ["run", () => plotRun((results.run = asked(train, "run", speed, TURNS)))],
    ];
    const failed = [];
    for (const [name, part] of parts) {
      say(`Computing: ${name} …`);
      await drawn();
      try {
        part();
      } catch (error) {
        failed.push(`${name}: ${error.message ?? error}`);
      }
    }
    const seconds = ((performance.now() - begin) / 1000).toFixed(1);
    const done = `${layout.degrees_of_freedom} degrees of freedom, ${seconds} s`;
    say([done, ...failed].join("\n"), failed.length > 0);
  });
  window.gearbowResults = results;
  byId("report").disabled = results.modes === undefined;
  byId("limits").disabled = byId("shaft").value === "";
}

/** Seeks the bow of the chosen shaft at which each mesh loses contact. */
async function findLimits() {
  const shaft = byId("shaft").value;
  await withTrain("limits", "Seeking the largest bow …", "", 0, (train) => {
    const found = asked(train, "bow_limits", shaft, byId("speed").value / RPM);
    const text = (limit) => (limit.bow === null ? "none" : (limit.bow * 1e6).toPrecision(4));
    tabulate("limit-table", ["mesh", `largest bow of ${shaft} [µm]`], found.map((limit) => [limit.mesh, text(limit)]));
    byId("bow-limits").hidden = found.length === 0;
    window.gearbowLimits = found;
    say(found.length === 0 ? "This train has no teeth." : `Largest bow of ${shaft} found.`);
  });
}

/** Writes train and results into a page of its own, which needs no script. */
async function saveReport() {
  const escaped = (text) => text.replace(/[&<>]/g, (one) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;" })[one]);
  const results = byId("results").cloneNode(true);
  for (const part of [...results.querySelectorAll("[hidden]")]) part.remove();
  for (const part of results.querySelectorAll(".plot")) {
    const image = document.createElement("img");
    image.src = await Plotly.toImage(byId(part.id), { format: "svg", width: 900, height: 450 });
    image.alt = part.id;
    part.replaceWith(image);
  }
  const at = `Speed of the reference shaft ${byId("speed").value} rpm; bow of ${byId("shaft").value || "the shafts as in the train"}, ${byId("bow-text").textContent}.`;
  const style = document.querySelector("style").textContent;
  const page = `<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>Report of gearbow</title><style>${style}</style></head>`
    + `<body><h1>Report of gearbow</h1><p>${escaped(at)}</p>${results.outerHTML}<h2>Train as TOML</h2><pre>${escaped(byId("scene").value)}</pre></body></html>`;
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([page], { type: "text/html" }));
  link.download = "gearbow-report.html";
  link.click();
  URL.revokeObjectURL(link.href);
}

/** Lists the shafts, and keeps the choice. */
function offerShafts(layout) {
  const chosen = byId("shaft").value;
  const option = (value, text) => Object.assign(document.createElement("option"), { value, textContent: text });
  byId("shaft").replaceChildren(option("", "as in the train"), ...layout.shafts.map((shaft) => option(shaft.name, shaft.name)));
  byId("shaft").value = layout.shafts.some((shaft) => shaft.name === chosen) ? chosen : "";
  byId("bow").disabled = byId("shaft").value === "";
}

/** Gives the slider twice the present bow of the shaft as its end, and at least 200 µm. */
function limitBow(layout) {
  layout.shafts.forEach((shaft) => present.set(shaft.name, byId("shaft").value === shaft.name ? present.get(shaft.name) ?? 0 : 1e6 * Math.max(0, ...shaft.bow)));
}

/** Begins the slider of a shaft at its present bow. */
function beginBow() {
  const size = present.get(byId("shaft").value) ?? 0;
  const end = Math.max(200, 2 * size);
  byId("bow").max = Number(end.toPrecision(2));
  byId("bow").step = end > 1000 ? 10 : 1;
  byId("bow").value = size;
  byId("bow").disabled = byId("shaft").value === "";
  showBow();
}

function showBow() {
  byId("bow-text").textContent = byId("shaft").value === "" ? "–" : `${byId("bow").value} µm`;
}

function choose(name) {
  const example = EXAMPLES[name];
  byId("scene").value = example.scene;
  byId("speed").value = Number(example.speed_rpm.toPrecision(6));
  byId("fastest").value = Number(example.fastest_rpm.toPrecision(4));
  byId("shaft").value = "";
  present.clear();
  beginBow();
}

async function begin() {
  byId("example").append(...Object.keys(EXAMPLES).map((name) => new Option(name, name)));
  byId("example").addEventListener("change", (event) => { choose(event.target.value); compute(); });
  byId("compute").addEventListener("click", compute);
  byId("limits").addEventListener("click", findLimits);
  byId("report").addEventListener("click", saveReport);
  byId("shaft").addEventListener("change", () => { beginBow(); compute(); });
  byId("bow").addEventListener("input", showBow);
  byId("bow").addEventListener("change", compute);
  showBow();
  await wasm_bindgen({ module_or_path: bytesOf(PROGRAM) });
  choose(Object.keys(EXAMPLES)[0]);
  await compute();
}

begin();
