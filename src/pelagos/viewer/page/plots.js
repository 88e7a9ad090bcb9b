// Plots over time: what is measured, and beside it what is true.
const SPAN_S = 60, MOST = 1200;
export const SERIES = [
  { key: "depth", title: "depth", unit: "m", least: 1, down: true, sensor: ["depth", "depth [m]"] },
  { key: "altitude", title: "altitude", unit: "m", least: 1, sensor: ["altimeter", "range [m]"] },
  { key: "speed", title: "speed", unit: "m/s", least: .5, sensor: ["dvl", "velocity x [m/s]"] },
  { key: "turn", title: "turn rate", unit: "°/s", least: 4, sensor: ["imu", "rate z [rad/s]"], factor: -180 / Math.PI },
];

export class Plots {
  constructor(place) {
    this.plots = SERIES.map((series) => {
      const figure = document.createElement("figure"), caption = document.createElement("figcaption");
      const name = document.createElement("span"), value = document.createElement("span"), canvas = document.createElement("canvas");
      name.textContent = series.title; value.style.color = "#ffd166"; caption.append(name, value); figure.append(caption, canvas); place.append(figure);
      canvas.setAttribute("role", "img"); canvas.setAttribute("aria-label", `${series.title} over time`);
      return { series, canvas, value, name, truth: [], measured: [], own: "" };
    });
  }
  clear() { for (const p of this.plots) { p.truth = []; p.measured = []; p.own = ""; p.name.textContent = p.series.title; } }
  add(t, agent, before) {
    for (const p of this.plots) {
      if (p.own) continue;
      let v = agent[p.series.key];
      if (p.series.key === "turn") {
        if (!before || t <= before.t) continue;
        v = ((agent.heading - before.heading + 540) % 360 - 180) / (t - before.t);
      }
      if (v !== null && v !== undefined) push(p.truth, t, v);
    }
  }
  measured(t, sensor, kind, numbers, truth) { // the line is what the sensor would have said without noise, where it stands and looks
    for (const p of this.plots) {
      const [wanted, name] = p.series.sensor, v = numbers[name], true_ = truth?.[name], factor = p.series.factor || 1;
      if (kind !== wanted || (p.own && p.own !== sensor)) continue; // of two of a kind the first
      if (v !== null && v !== undefined) push(p.measured, t, v * factor);
      if (true_ === null || true_ === undefined) continue;
      if (!p.own) { p.own = sensor; p.truth = []; p.name.textContent = sensor === p.series.title ? sensor : `${p.series.title} · ${sensor}`; }
      push(p.truth, t, true_ * factor);
    }
  }
  draw() { for (const p of this.plots) drawOne(p); }
}

function push(list, t, v) { if (list.length && list.at(-1)[0] >= t) return; list.push([t, v]); if (list.length > MOST) list.shift(); }

export function graduations(low, high) { // three lines and their numbers, rounded by a tenth of their distance at most
  const digits = Math.max(0, Math.min(3, Math.ceil(-Math.log10(.08 * (high - low)))));
  return [.1, .5, .9].map((part) => { const v = low + part * (high - low); return [v, v.toFixed(digits).replace(/^-(0(\.0*)?)$/, "$1")]; });
}

function drawOne({ series, canvas, value, truth, measured }) {
  const w = canvas.clientWidth, h = canvas.clientHeight, ratio = devicePixelRatio || 1;
  if (!w || !h) return;
  if (canvas.width !== Math.round(w * ratio)) { canvas.width = Math.round(w * ratio); canvas.height = Math.round(h * ratio); }
  const c = canvas.getContext("2d"); c.setTransform(ratio, 0, 0, ratio, 0, 0); c.clearRect(0, 0, w, h);
  const last = Math.max(truth.length ? truth.at(-1)[0] : 0, measured.length ? measured.at(-1)[0] : 0), first = last - SPAN_S;
  const shown = [truth, measured].map((list) => list.filter(([t]) => t >= first));
  const values = shown.flat().map((p) => p[1]);
  if (!values.length) { value.textContent = ""; return; }
  let low = Math.min(...values), high = Math.max(...values);
  const room = Math.max((high - low) * 0.15, (series.least - (high - low)) / 2); low -= room; high += room; // noise of a constant signal stays small
  const left = 34, x = (t) => left + ((t - first) / SPAN_S) * (w - left - 2), y = (v) => series.down ? 5 + ((v - low) / (high - low)) * (h - 12) : h - 7 - ((v - low) / (high - low)) * (h - 12);
  c.font = "9.5px system-ui, sans-serif"; c.fillStyle = "#8fa9bd"; c.strokeStyle = "#1b3a54"; c.lineWidth = 1;
  for (const [v, text] of graduations(low, high)) { const at = y(v); c.beginPath(); c.moveTo(left, at); c.lineTo(w, at); c.stroke(); c.fillText(text, 2, at + 3); }
  c.fillStyle = "#e07b39"; for (const [t, v] of shown[1]) c.fillRect(x(t) - 1, y(v) - 1, 2, 2);
  c.strokeStyle = "#f6f3cf"; c.lineWidth = 1.4; c.beginPath(); shown[0].forEach(([t, v], i) => i ? c.lineTo(x(t), y(v)) : c.moveTo(x(t), y(v))); c.stroke();
  const now = shown[0].length ? shown[0].at(-1)[1] : shown[1].at(-1)[1];
  value.textContent = `${now.toFixed(2).replace(/^-(0\.00)$/, "$1")} ${series.unit}`;
}
