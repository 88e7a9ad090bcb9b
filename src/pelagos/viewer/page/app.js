import { ChartMap } from "./map.js";
import { Plots } from "./plots.js";
import { Hands } from "./drive.js";
import { Stage } from "./stage.js";

const $ = (id) => document.getElementById(id);
const map = new ChartMap($("map")), plots = new Plots($("plots"));
let props = []; // that can be moved
let hello = null, state = null, socket = null, agent = "", tries = 0, before = null, scrubbing = false;
const cards = {}, urls = {}, kinds = {};
const send = (message) => { if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message)); };
const can = (order) => !!hello?.can.includes(order);
const hands = new Hands(send, () => can("drive") ? agent : "");

const TEXT = new TextDecoder(), TAKE = { loading: (x) => lost(x.text), hello: onHello, water: onWater, section: onSection, state: onState, waiting: onWaiting, panel: onPanel, jump: onJump, say: onSay, chart: (x, b) => map.part(x.bounds, new Blob([b], { type: "image/png" })), node: (x, b) => stage?.node(x, b), part: (x, b) => stage?.part(x, b), gone: (x) => stage?.gone(x), seen: (x) => stage?.seen(x), poses: (x) => stage?.move(x) };
function connect() {
  socket = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/live`);
  socket.binaryType = "arraybuffer";
  socket.onopen = () => { tries = 0; stage?.reset(); $("lost").hidden = true; };
  socket.onmessage = (e) => { // records: lengths of header and blob, header, blob, in whole words
    const lengths = new DataView(e.data); let at = 0;
    while (at < e.data.byteLength) {
      const size = lengths.getUint32(at, true), blob = lengths.getUint32(at + 4, true), header = JSON.parse(TEXT.decode(new Uint8Array(e.data, at + 8, size)));
      TAKE[header.type]?.(header, new Uint8Array(e.data, at + 8 + size, blob)); at += 8 + size + 4 * Math.ceil(blob / 4);
    }
  };
  socket.onclose = () => { lost(tries++ ? "The simulation has ended, or the connection is lost. This page tries again by itself." : ""); setTimeout(connect, Math.min(500 * 2 ** tries, 8000)); };
}
function lost(text) { if (!text) return; $("lost-text").textContent = text; $("lost").hidden = false; }

function onHello(h) {
  $("lost").hidden = true; hello = h; document.title = `${h.name} · Pelagos`; $("title").textContent = h.name; $("title").title = h.description; $("kind").textContent = h.kind; document.body.className = h.kind;
  for (const e of document.querySelectorAll("[data-needs]")) e.classList.toggle("cannot", !can(e.dataset.needs)); // what would be ignored is not offered
  if (h.kind === "live" && !can("drive")) { $("kind").textContent = "live · looking on"; $("kind").title = "A program steps this run. The page can hold it and let it go on; sim.view(drive=True) gives it all controls."; }
  const names = Object.keys(h.agents); $("agent").replaceChildren(...names.map((n) => option(n, n))); choose(names.includes(agent) ? agent : names[0] || "");
  map.load(h.bounds, h.plans, h.chart); if (stage) { if (!names.length) { stage.overview(h.bounds, h.floor); look("free"); stage.clarity = .1; stage.showSea = document.querySelector("[data-show=sea]").checked = false; } }
  $("section").replaceChildren(option("off", "none"), ...Object.entries(h.sections).map(([name, title]) => option(name, title))); $("section-row").hidden = !can("section"); $("map-hint").textContent = can("goal") ? "click: way-point" : "";
  $("panels").replaceChildren(); for (const s of [...h.sensors].sort((a, b) => b.pictured - a.pictured)) addCard(s);
  $("sights").replaceChildren(...h.sensors.filter((s) => ["imaging_sonar", "profiling_sonar", "dvl", "camera"].includes(s.kind)).map((s) => tickbox(s.name)));
  for (const note of h.notes) onSay({ text: note });
  if (h.kind === "replay") timeline(h); watched();
}
function onWater(w) {
  if (stage) { stage.sea(w.waves); stage.water = w.attenuation; stage.sunward = w.sunward; stage.again = true; }
  const s = w.settings, set = (id, value) => { if (value !== undefined) { $(id).value = value; $(id).oninput?.({ target: $(id) }); } };
  if (s.current) { set("current-speed", s.current[0]); set("current-towards", s.current[1]); }
  if (s.waves) { set("waves-height", s.waves[0]); if (s.waves[0]) { set("waves-period", s.waves[1]); set("waves-towards", s.waves[2]); } }
  if (s.sun) { set("sun", s.sun[0]); set("sun-from", s.sun[1]); } set("turbidity", s.turbidity);
}
function onSection(s) {
  $("legend").hidden = !s.title; if (!s.title) return;
  $("legend-title").textContent = s.unit ? `${s.title} [${s.unit}]` : s.title; $("legend-bar").style.background = `linear-gradient(90deg, ${s.shades.join(", ")})`;
  const digits = s.low === null ? 0 : Math.max(0, Math.min(4, 2 - Math.floor(Math.log10(Math.max(s.high - s.low, 1e-4))))), text = (v) => v === null ? "–" : v.toFixed(digits);
  $("legend-low").textContent = s.low === s.high ? "" : text(s.low); $("legend-high").textContent = s.low === s.high ? `${text(s.high)} everywhere` : text(s.high);
}
function option(value, text) { const o = document.createElement("option"); o.value = value; o.textContent = text; return o; }
function tickbox(name) { const l = document.createElement("label"), i = document.createElement("input"); l.className = "tickbox"; i.type = "checkbox"; i.checked = true; i.dataset.show = name; l.append(i, ` ${name}`); return l; }

function choose(name) {
  const other = name !== agent; agent = name; $("agent").value = name; if (!name) return;
  const modes = Object.keys(hello.agents[name].modes); $("mode").replaceChildren(...modes.map((m) => option(m, m.replaceAll("_", " ")))); if (other) { plots.clear(); before = null; } if (stage) { stage.agent = name; stage.length = hello.agents[name].length; stage.offset = null; } send({ do: "follow", agent: name });
}

function onState(s) {
  if (state && s.t < state.t) onJump(); // a run that has begun anew while nobody was connected
  state = s; $("time").textContent = `${s.t.toFixed(1)} s`; const run = s.run;
  $("rate").textContent = run.paused ? "paused" : run.rate ? `${run.rate.toFixed(run.rate < 10 ? 1 : 0)} × real time` : "";
  $("pause").textContent = run.paused ? "Run" : "Pause"; $("pause").setAttribute("aria-pressed", String(!!run.paused));
  if (run.speed !== undefined && document.activeElement !== $("speed")) $("speed").value = String(run.speed);
  $("record").setAttribute("aria-pressed", String(!!run.recording));
  const a = s.agents[agent], r = run.agents?.[agent];
  if (a) {
    $("hud-depth").textContent = `${a.depth.toFixed(2)} m`; $("hud-altitude").textContent = a.altitude === null ? "–" : `${a.altitude.toFixed(2)} m`;
    $("hud-heading").textContent = `${((Math.round(10 * a.heading) % 3600) / 10).toFixed(1).padStart(5, "0")}°`; $("hud-speed").textContent = `${a.speed.toFixed(2)} m/s`;
    plots.add(s.t, a, before); before = { t: s.t, heading: a.heading };
  }
  if (r) { $("leg").textContent = r.goals.length ? `${r.goals.length} way-point${r.goals.length > 1 ? "s" : ""} ahead` : r.leg ? `mission ${r.leg}` : "by command"; if (document.activeElement !== $("mode")) $("mode").value = r.mode; }
  if (hello?.kind === "replay") $("leg").textContent = run.event || "";
  for (const c of Object.values(cards)) age(c, s.t);
  map.state(s.agents, s.props, run); props = run.props || [];
  if (hello?.kind === "replay" && !scrubbing) $("scrub").value = s.t;
}
let drawn = 0;
function paint(now) { if (now - drawn > 150) { drawn = now; plots.draw(); } requestAnimationFrame(paint); }

function addCard(s) {
  const card = document.createElement("div"), head = document.createElement("h2"), fold = document.createElement("button"), about = document.createElement("span"), more = document.createElement("button");
  card.className = s.pictured ? "card" : "card folded"; card.dataset.sensor = s.name; fold.className = "fold"; fold.textContent = s.name; about.textContent = `${s.kind.replaceAll("_", " ")} · ${s.rate_hz} Hz`;
  more.className = "about"; more.textContent = "i"; more.title = "Configuration"; head.append(fold, about, more); card.append(head);
  const image = document.createElement("img"); image.alt = `${s.name}: ${s.kind}`; image.className = ["sidescan", "multibeam", "singlebeam", "synthetic_aperture_sonar"].includes(s.kind) ? "wide" : "photo"; image.hidden = true;
  const numbers = document.createElement("div"); numbers.className = "numbers"; card.append(image, numbers); $("panels").append(card);
  const config = document.createElement("div"); config.className = "config"; config.hidden = true; config.textContent = Object.entries(s.config).map(([k, v]) => `${k}: ${JSON.stringify(v)}`).join("\n"); card.append(config);
  fold.onclick = () => { card.classList.toggle("folded"); watched(); }; fold.setAttribute("aria-label", `${s.name}: fold or unfold`);
  more.onclick = () => { config.hidden = !config.hidden; }; more.setAttribute("aria-label", `${s.name}: configuration`);
  const bar = document.createElement("div"); if (s.shades) { const low = document.createElement("span"), shown = document.createElement("i"), high = document.createElement("span"); shown.style.background = `linear-gradient(270deg, ${s.shades.join(", ")})`; bar.className = "bar"; bar.hidden = true; bar.title = "depth below the sonar"; bar.append(low, shown, high); image.after(bar); }
  cards[s.name] = { card, image, numbers, bar, rate: s.rate_hz }; kinds[s.name] = s.kind;
}
function watched() { send({ do: "panels", names: Object.entries(cards).filter(([, c]) => !c.card.classList.contains("folded")).map(([n]) => n) }); }
function onPanel(p, blob) {
  const c = cards[p.name]; if (!c) return; c.t = p.t; age(c, state?.t);
  if (p.name.startsWith(`${agent}.`)) plots.measured(p.t, p.name.slice(agent.length + 1), kinds[p.name], p.numbers, p.truth);
  if (p.pictured) { const old = urls[p.name]; c.image.src = urls[p.name] = URL.createObjectURL(new Blob([blob], { type: "image/jpeg" })); c.image.hidden = false; if (old) c.image.onload = () => URL.revokeObjectURL(old); }
  if (p.bar) { c.bar.hidden = false; c.bar.firstChild.textContent = `${p.bar[0].toFixed(1)} m`; c.bar.lastChild.textContent = `${p.bar[1].toFixed(1)} m below`; }
  if (c.card.classList.contains("folded")) return;
  const rows = Object.entries(p.numbers); if (c.numbers.childElementCount !== 2 * rows.length) { c.numbers.replaceChildren(...rows.flatMap(() => [document.createElement("span"), document.createElement("b")])); }
  rows.forEach(([name, value], i) => { c.numbers.children[2 * i].textContent = name; c.numbers.children[2 * i + 1].textContent = value === null ? "–" : value.toPrecision(5); });
}
function onWaiting(w) { // nothing to read between ticks: a clock that stands still looks like a hang
  $("waiting").hidden = !w.s; $("waiting").textContent = w.s ? `The next step has taken ${w.s} s so far. What this machine computes for the first time is compiled before it runs; that is kept, and is quick from then on.` : "";
}
function age(c, now) { c.card.classList.toggle("old", Number.isFinite(c.t) && now - c.t > Math.max(1, 3 / c.rate)); } // as the server has it
function onJump() {
  plots.clear(); map.clear(); before = null;
  for (const c of Object.values(cards)) c.t = null; // what a sensor says after the jump comes at once, in a recording
  setTimeout(() => { for (const c of Object.values(cards)) if (c.t === null) { c.image.hidden = true; c.image.removeAttribute("src"); c.bar.hidden = true; c.numbers.replaceChildren(); } }, 400);
}
function onSay(s) { const p = document.createElement("p"); p.textContent = s.text; p.className = s.kind || "note"; $("says").append(p); setTimeout(() => p.remove(), s.kind === "error" ? 9000 : 6000); }

function timeline(h) {
  $("timeline").hidden = false; const s = $("scrub"); s.min = h.first_s; s.max = h.last_s;
  s.oninput = () => { scrubbing = true; send({ do: "seek", t: Number(s.value) }); }; s.onchange = () => { scrubbing = false; };
  $("marks").replaceChildren(...h.events.map((e) => {
    const b = document.createElement("button"); b.title = `${e.t.toFixed(1)} s: ${e.text}`; b.setAttribute("aria-label", b.title); b.onclick = () => send({ do: "seek", t: e.t });
    b.dataset.at = (e.t - h.first_s) / Math.max(h.last_s - h.first_s, 1e-9); b.textContent = e.text; return b;
  }));
  layMarks();
}
function layMarks() { // no text on another: what has no room is a stroke alone, and the last ones stand to the left of their strokes
  const wide = $("marks").clientWidth, all = [...$("marks").children]; let free = 0; if (!wide) return;
  for (const b of all) { b.className = ""; b.style.left = b.style.right = ""; }
  const sizes = all.map((b) => b.offsetWidth);
  all.forEach((b, i) => {
    const at = b.dataset.at * wide, late = at + sizes[i] > wide, from = late ? at + 2 - sizes[i] : at; b.style.left = `${from}px`;
    if (from >= free) { b.className = late ? "late" : ""; free = from + sizes[i] + 6; } else { b.className = "bare"; b.style.left = `${at}px`; }
  });
}
new ResizeObserver(layMarks).observe($("marks"));

$("pause").onclick = () => send({ do: "pause", paused: !state?.run.paused });
$("tick").onclick = () => send({ do: "tick" });
$("speed").onchange = (e) => { send({ do: "speed", speed: Number(e.target.value) }); e.target.blur(); };
$("reset").onclick = () => { const seed = $("seed").value.trim(); if (seed && !/^\d+$/.test(seed)) { onSay({ text: `A seed is a whole number from 0 on, not ${seed}.`, kind: "error" }); return; } send(seed ? { do: "reset", seed: Number(seed) } : { do: "reset" }); };
$("record").onclick = () => send({ do: "record", on: !state?.run.recording });
$("agent").onchange = (e) => { choose(e.target.value); e.target.blur(); };
$("mode").onchange = (e) => { send({ do: "mode", agent, mode: e.target.value }); e.target.blur(); };
$("map-in").onclick = () => map.zoom(1.6); $("map-out").onclick = () => map.zoom(1 / 1.6);
$("clear").onclick = () => send({ do: "clear_goals", agent });
for (const [button, tool] of [["map-way", "way"], ["map-prop", "prop"]]) $(button).onclick = () => { map.tool = tool; if (stage) { stage.tool = tool; $("scene").style.cursor = tool === "prop" ? "crosshair" : ""; } $("map-way").setAttribute("aria-pressed", String(tool === "way")); $("map-prop").setAttribute("aria-pressed", String(tool === "prop")); $("map-hint").textContent = tool === "way" ? "click: way-point" : "click: put · drag: move · double click: remove"; };
map.onGoal = (x, y) => { if (can("goal")) send({ do: "goal", agent, x, y }); };
map.onNear = (bounds) => send({ do: "chart", bounds });
map.onProp = (x, y) => send({ do: "spawn", shape: $("shape").value, x, y });
map.onMove = (name, x, y) => send({ do: "move", name, x, y });
map.onRemove = (name) => send({ do: "remove", name });
for (const b of document.querySelectorAll("[data-look]")) b.onclick = () => look(b.dataset.look);
function look(name) { stage?.choose(name); for (const b of document.querySelectorAll("[data-look]")) b.setAttribute("aria-pressed", String(b.dataset.look === name)); }
document.addEventListener("change", (e) => { const what = e.target.dataset?.show; if (what === "sea" && stage) { stage.showSea = e.target.checked; stage.again = true; } else if (what) send({ do: "show", what: e.target.dataset.show, visible: e.target.checked }); });
$("clarity").oninput = (e) => { if (stage) { stage.clarity = Number(e.target.value); stage.again = true; } };
$("ground").onchange = (e) => send({ do: "ground", by: e.target.value });
for (const [id, text] of [["current-speed", (v) => `${Number(v).toFixed(2)} m/s`], ["current-towards", (v) => `${v}°`], ["turbidity", (v) => `${Number(v).toFixed(1)} ×`], ["waves-height", (v) => `${Number(v).toFixed(1)} m`], ["waves-period", (v) => `${Number(v).toFixed(1)} s`], ["waves-towards", (v) => `${v}°`], ["sun", (v) => `${Number(v).toFixed(0)}°`], ["sun-from", (v) => `${Number(v).toFixed(0)}°`]]) $(id).oninput = (e) => { $(`${id}-out`).textContent = text(e.target.value); };
$("current-set").onclick = () => send({ do: "current", speed: Number($("current-speed").value), towards_deg: Number($("current-towards").value) });
$("sun-set").onclick = () => send({ do: "sun", elevation_deg: Number($("sun").value), azimuth_deg: Number($("sun-from").value) });
$("waves-set").onclick = () => send({ do: "waves", height: Number($("waves-height").value), period: Number($("waves-period").value), towards_deg: Number($("waves-towards").value) });
for (const id of ["section", "section-along"]) $(id).onchange = (e) => { send({ do: "section", what: $("section").value, along: $("section-along").value }); e.target.blur(); };
$("turbidity-set").onclick = () => send({ do: "turbidity", turbidity: Number($("turbidity").value) });
for (const id of ["water", "things", "help"]) $(`${id}-button`).onclick = () => open_(id);
function open_(id) { for (const other of ["water", "things", "help"]) { const shown = other === id && $(other).hidden; $(other).hidden = !shown; $(`${other}-button`).setAttribute("aria-expanded", String(shown)); } }

document.addEventListener("click", (e) => { if (e.detail) e.target.closest?.("button")?.blur(); }); // after a click with the mouse, space runs and pauses again
const ARROWS = { ArrowLeft: [.09, 0], ArrowRight: [-.09, 0], ArrowUp: [0, -.09], ArrowDown: [0, .09] };
function typing(e) { return ["INPUT", "SELECT", "TEXTAREA"].includes(e.target.tagName); }
function keydown(e) {
  if (e.key === "Escape") { for (const id of ["water", "things", "help"]) { $(id).hidden = true; $(`${id}-button`).setAttribute("aria-expanded", "false"); } return; }
  if (typing(e) && e.target.type !== "range" && e.target.type !== "checkbox") return;
  if (e.key === " " && e.target.tagName !== "BUTTON") { e.preventDefault(); if (can("pause")) $("pause").click(); }
  else if (e.key === "." && can("tick")) $("tick").click();
  else if (e.key === "?") open_("help");
  else if ("1234".includes(e.key) && !e.ctrlKey) look(["follow", "free", "aboard", "top"][Number(e.key) - 1]);
  else if (hello?.kind === "replay" && !e.shiftKey && (e.key === "ArrowLeft" || e.key === "ArrowRight") && state) { e.preventDefault(); send({ do: "seek", t: state.t + (e.key === "ArrowLeft" ? -1 : 1) }); }
  else if ((e.key === "+" || e.key === "-") && !e.ctrlKey && !e.metaKey) stage?.zoom(e.key === "+" ? .85 : 1 / .85);
  else if (e.shiftKey && ARROWS[e.key]) { e.preventDefault(); stage?.orbit(...ARROWS[e.key]); }
  else if (hands.key(e, true)) e.preventDefault();
}
addEventListener("keydown", keydown); addEventListener("keyup", (e) => hands.key(e, false));
function noGl(error) { const p = document.createElement("p"); p.className = "no-gl"; p.textContent = "This browser has no WebGL 2, so the 3-D scene cannot be drawn; map, sensors, plots and controls work without it."; if (error && !/WebGL/.test(error.message)) throw error; $("scene").replaceWith(p); }
let stage = null;
try { stage = new Stage($("scene"), $("labels")); stage.onLook = ([x, y]) => { if (stage.look === "free") send({ do: "look_at", x, y }); }; } catch (error) { noGl(error); }
if (stage) stage.onPick = (eye, way) => { if (agent && can("goal_seen")) send({ do: "goal_seen", agent, eye, way }); };
if (stage) {
  stage.props = () => props; stage.onPut = (eye, way) => send({ do: "spawn_seen", shape: $("shape").value, eye, way });
  stage.onDrag = (name, eye, way) => send({ do: "move_seen", name, eye, way }); stage.onRemove = (name) => send({ do: "remove", name });
}
window.pelagos = { stage, map, plots }; // for the tests and for the curious
connect(); requestAnimationFrame(paint);
