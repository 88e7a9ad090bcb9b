// The map: shaded ground, tracks, plans, way-points and props. North is up.
const MOST = 4000, PARTS = 12, SHARP = .7, ROOM = .2, REST_MS = 200; // points of a track; nearer pictures that are kept; pixels of a picture for one of the canvas; around what is seen
export class ChartMap {
  constructor(canvas) {
    this.canvas = canvas; this.picture = new Image(); this.picture.onload = () => { this.draw(); this.refine(); }; this.tracks = {}; this.known = {}; this.agents = {}; this.goals = {};
    this.near = 1; this.middle = null; this.touches = new Map(); this.plans = {}; this.props = {}; this.bounds = null; this.tool = "way"; this.held = null; this.parts = []; this.depths = {}; this.onGoal = this.onProp = this.onMove = this.onRemove = this.onNear = () => {};
    canvas.addEventListener("pointerdown", (e) => this.down(e)); canvas.addEventListener("pointermove", (e) => this.drag(e));
    canvas.addEventListener("pointerup", (e) => this.up(e)); canvas.addEventListener("dblclick", (e) => this.twice(e));
    canvas.addEventListener("keydown", (e) => this.key(e)); canvas.addEventListener("blur", () => { this.cross = false; this.draw(); });
    canvas.addEventListener("wheel", (e) => { e.preventDefault(); this.zoom(Math.exp(-e.deltaY * .0015), e); }, { passive: false });
    canvas.addEventListener("pointercancel", (e) => { this.touches.delete(e.pointerId); this.held = null; });
    new ResizeObserver(() => { this.draw(); this.refine(); }).observe(canvas);
  }
  load(bounds, plans, depths) { this.bounds = bounds; this.plans = plans; this.depths = depths || {}; this.parts = []; this.near = 1; this.middle = null; this.fit(); this.picture.src = "data/map.png"; this.shape(); this.refine(); }
  refine() { clearTimeout(this.rest); this.rest = setTimeout(() => this.ask(), REST_MS); } // once the map rests
  ask() { // a nearer picture of what is seen, where the ones that there are would blur
    if (!this.bounds || !this.picture.naturalWidth || !this.canvas.clientWidth) return;
    const f = this.frame(), [x0, y0, x1, y1] = this.bounds, high = x1 + f.top / f.scale, left = y1 + f.left / f.scale, seen = [Math.max(x0, high - f.h / f.scale), Math.max(y0, left - f.w / f.scale), Math.min(x1, high), Math.min(y1, left)];
    if (seen[2] - seen[0] < .5 || seen[3] - seen[1] < .5) return;
    const sharp = (p) => p.sharp >= SHARP * f.scale, covers = ([a, b, c, d]) => a <= seen[0] + .01 && b <= seen[1] + .01 && c >= seen[2] - .01 && d >= seen[3] - .01;
    if (this.picture.naturalWidth / (y1 - y0) >= SHARP * f.scale || this.parts.some((p) => sharp(p) && covers(p.bounds))) return;
    const rx = ROOM * (seen[2] - seen[0]), ry = ROOM * (seen[3] - seen[1]); this.onNear([seen[0] - rx, seen[1] - ry, seen[2] + rx, seen[3] + ry]);
  }
  part(bounds, blob) { // a nearer picture; coarse ones lie below fine ones
    const image = new Image(), url = URL.createObjectURL(blob);
    image.onload = () => { URL.revokeObjectURL(url); this.parts.push({ bounds, image, sharp: image.naturalWidth / (bounds[3] - bounds[1]) }); if (this.parts.length > PARTS) this.parts.shift(); this.draw(); };
    image.src = url;
  }
  fit() { // a plan that is small in its world is shown near
    const points = Object.values(this.plans).flat(); if (!points.length) return; const [x0, y0, x1, y1] = this.bounds, of = (i) => points.map((p) => p[i]), low = [0, 1].map((i) => Math.min(...of(i))), high = [0, 1].map((i) => Math.max(...of(i)));
    const near = Math.min((x1 - x0) / (1.5 * (high[0] - low[0]) + 10), (y1 - y0) / (1.5 * (high[1] - low[1]) + 10)); if (near > 1.5) { this.near = near; this.middle = [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2]; }
  }
  shape() { const [x0, y0, x1, y1] = this.bounds, w = this.canvas.clientWidth || 350; this.canvas.style.height = `${Math.min(Math.max((x1 - x0) / (y1 - y0) * w, 120), 260)}px`; }
  clear() { this.tracks = {}; this.known = {}; }
  frame() { // the part of the canvas that the world fills
    const w = this.canvas.clientWidth, h = this.canvas.clientHeight, [x0, y0, x1, y1] = this.bounds, scale = this.near * Math.min(w / (y1 - y0), h / (x1 - x0)), [mx, my] = this.middle || [(x0 + x1) / 2, (y0 + y1) / 2];
    return { w, h, scale, left: w / 2 - (y1 - my) * scale, top: h / 2 - (x1 - mx) * scale };
  }
  place(x, y) { const f = this.frame(), [, , x1, y1] = this.bounds; return [f.left + (y1 - y) * f.scale, f.top + (x1 - x) * f.scale]; }
  world(e, near = this.near) { const now = this.near; this.near = near; const f = this.frame(); this.near = now; const r = this.canvas.getBoundingClientRect(), [, , x1, y1] = this.bounds; return [x1 - (e.clientY - r.top - f.top) / f.scale, y1 - (e.clientX - r.left - f.left) / f.scale]; }
  zoom(k, e) { // about the pointer, else about the vehicle or the middle
    if (!this.bounds) return; const [x0, y0, x1, y1] = this.bounds, old = this.near; this.near = Math.max(1, Math.min(Math.max(x1 - x0, y1 - y0) / 8, this.near * k));
    const first = Object.values(this.agents)[0], at = e ? this.world(e, old) : first ? [first.x, first.y] : this.middle || [(x0 + x1) / 2, (y0 + y1) / 2], m = this.middle || [(x0 + x1) / 2, (y0 + y1) / 2], part = e ? 1 - old / this.near : 1;
    this.shift([m[0] + part * (at[0] - m[0]), m[1] + part * (at[1] - m[1])]);
  }
  shift([x, y]) { const [x0, y0, x1, y1] = this.bounds; this.middle = this.near > 1 ? [Math.max(x0, Math.min(x1, x)), Math.max(y0, Math.min(y1, y))] : null; this.draw(); this.refine(); }
  inside([x, y]) { const [x0, y0, x1, y1] = this.bounds; return x >= x0 && x <= x1 && y >= y0 && y <= y1; }
  prop(e) { return this.nearest(this.world(e)); }
  nearest([x, y]) { const near = 9 / this.frame().scale; return (this.free || []).find((name) => { const p = this.props[name]; return p && Math.hypot(p[0] - x, p[1] - y) < near; }); }
  key(e) { // arrows move a cross, Enter sets what a click would
    const steps = { ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowLeft: [0, 1], ArrowRight: [0, -1] }, step = steps[e.key]; if (!this.bounds) return;
    const [x0, y0, x1, y1] = this.bounds, far = Math.max(x1 - x0, y1 - y0) / this.near / (e.shiftKey ? 200 : 40);
    if (step) { const [x, y] = this.cross && this.cursor || Object.values(this.agents).map((a) => [a.x, a.y])[0] || [(x0 + x1) / 2, (y0 + y1) / 2]; this.cursor = [Math.max(x0, Math.min(x1, x + far * step[0])), Math.max(y0, Math.min(y1, y + far * step[1]))]; this.cross = true; this.draw(); }
    else if (e.key === "+" || e.key === "-") this.zoom(e.key === "+" ? 1.3 : 1 / 1.3);
    else if (e.key === "Delete" && this.cursor && this.tool === "prop") { const found = this.nearest(this.cursor); if (found) this.onRemove(found); }
    else if (e.key === "Enter" && this.cursor) { this.cross = true; (this.tool === "prop" ? this.onProp : this.onGoal)(...this.cursor); } else return;
    e.preventDefault(); e.stopPropagation();
  }
  down(e) {
    if (!this.bounds) return; this.touches.set(e.pointerId, [e.clientX, e.clientY]); this.canvas.setPointerCapture(e.pointerId);
    if (this.touches.size > 1) { this.held = null; this.gap = 0; return; } // two fingers come nearer
    this.held = this.tool === "prop" ? this.prop(e) : undefined; this.moved = false; this.from = [e.clientX, e.clientY];
  }
  drag(e) {
    if (!this.bounds) return; this.cursor = this.world(e); const was = this.touches.get(e.pointerId); if (!was) return; this.touches.set(e.pointerId, [e.clientX, e.clientY]);
    if (this.touches.size > 1) { const [a, b] = [...this.touches.values()], gap = Math.hypot(a[0] - b[0], a[1] - b[1]); if (this.gap) this.zoom(gap / this.gap, { clientX: (a[0] + b[0]) / 2, clientY: (a[1] + b[1]) / 2 }); this.gap = gap; return; }
    this.moved ||= Math.hypot(e.clientX - this.from[0], e.clientY - this.from[1]) > 4; if (!this.moved || this.held === null) return;
    if (this.held) { this.props[this.held] = this.world(e); this.draw(); }
    else if (this.near > 1) { const s = this.frame().scale, [x, y] = this.middle; this.shift([x + (e.clientY - was[1]) / s, y + (e.clientX - was[0]) / s]); }
  }
  up(e) {
    this.touches.delete(e.pointerId); if (!this.bounds || this.held === null) return;
    const at = this.world(e), held = this.held; this.held = null;
    if (held) { if (this.moved) this.onMove(held, ...at); return; }
    if (!this.moved && this.inside(at)) (this.tool === "prop" ? this.onProp : this.onGoal)(...at);
  }
  twice(e) { if (this.tool === "prop") { const found = this.prop(e); if (found) this.onRemove(found); } }
  state(agents, props, run) {
    this.agents = agents; this.free = run.props; if (!this.held) this.props = props;
    for (const [name, a] of Object.entries(agents)) {
      add(this.tracks[name] ||= [], a.x, a.y); if (a.known) add(this.known[name] ||= [], a.known[0], a.known[1]);
      this.goals[name] = run.agents?.[name]?.goals || [];
    }
    this.draw();
  }
  draw() {
    const canvas = this.canvas, w = canvas.clientWidth, h = canvas.clientHeight, ratio = devicePixelRatio || 1;
    if (!this.bounds || !w) return;
    if (canvas.width !== Math.round(w * ratio) || canvas.height !== Math.round(h * ratio)) { canvas.width = Math.round(w * ratio); canvas.height = Math.round(h * ratio); }
    const c = canvas.getContext("2d"), f = this.frame(), [x0, y0, x1, y1] = this.bounds; c.setTransform(ratio, 0, 0, ratio, 0, 0); c.fillStyle = "#061421"; c.fillRect(0, 0, w, h);
    if (this.picture.complete && this.picture.naturalWidth) c.drawImage(this.picture, f.left, f.top, f.scale * (y1 - y0), f.scale * (x1 - x0));
    for (const { bounds: [a, b, d, e], image } of [...this.parts].sort((p, q) => p.sharp - q.sharp)) c.drawImage(image, ...this.place(d, e), f.scale * (e - b), f.scale * (d - a));
    c.setLineDash([5, 4]); for (const plan of Object.values(this.plans)) this.line(c, plan, "rgba(11, 31, 75, .75)", 1.3); c.setLineDash([]);
    for (const track of Object.values(this.known)) this.line(c, track, "#b14be0", 1.3);
    for (const track of Object.values(this.tracks)) { this.line(c, track, "#0c2238", 3); this.line(c, track, "#ffd166", 1.7); }
    for (const [name, goals] of Object.entries(this.goals)) {
      if (!goals.length) continue;
      const a = this.agents[name]; c.setLineDash([3, 3]); this.line(c, [[a.x, a.y], ...goals], "#ffffff", 1.4); c.setLineDash([]);
      goals.forEach((g, i) => { const [px, py] = this.place(...g); c.beginPath(); c.arc(px, py, 6, 0, 7); c.fillStyle = "#0c2238"; c.fill(); c.strokeStyle = "#ffd166"; c.stroke(); c.fillStyle = "#fff"; c.font = "9px system-ui"; c.textAlign = "center"; c.fillText(i + 1, px, py + 3); });
    }
    for (const p of Object.values(this.props)) { const [px, py] = this.place(...p); c.fillStyle = "#e07b39"; c.strokeStyle = "#fff"; c.lineWidth = 1; c.fillRect(px - 4, py - 4, 8, 8); c.strokeRect(px - 4, py - 4, 8, 8); }
    for (const a of Object.values(this.agents)) this.arrow(c, a);
    if (this.cross) { const [px, py] = this.place(...this.cursor); c.strokeStyle = "#fff"; c.lineWidth = 1.5; c.beginPath(); c.moveTo(px - 10, py); c.lineTo(px + 10, py); c.moveTo(px, py - 10); c.lineTo(px, py + 10); c.stroke(); }
    this.scale(c, f, h); this.legend(c, w, h);
  }
  line(c, points, colour, width) { if (points.length < 2) return; c.strokeStyle = colour; c.lineWidth = width; c.lineJoin = "round"; c.beginPath(); points.forEach((p, i) => i ? c.lineTo(...this.place(...p)) : c.moveTo(...this.place(...p))); c.stroke(); }
  arrow(c, a) { const [px, py] = this.place(a.x, a.y); c.save(); c.translate(px, py); c.rotate(a.heading * Math.PI / 180); c.beginPath(); c.moveTo(0, -9); c.lineTo(5.5, 7); c.lineTo(0, 4); c.lineTo(-5.5, 7); c.closePath(); c.fillStyle = "#ffd166"; c.fill(); c.strokeStyle = "#0c2238"; c.lineWidth = 1.3; c.stroke(); c.restore(); }
  legend(c, w, h) { // depths that the colours stand for
    const { shallow, deep, shades } = this.depths; if (!shades) return;
    const digits = deep - shallow < 10 ? 1 : 0, [low, high] = [shallow, deep].map((v) => v.toFixed(digits)), text = `${high} m`; c.font = "9.5px system-ui"; c.textAlign = "left";
    const before = c.measureText(low).width, after = c.measureText(text).width, long = 44, left = w - long - before - after - 20, fill = c.createLinearGradient(left + before + 10, 0, left + before + 10 + long, 0);
    shades.forEach((shade, i) => fill.addColorStop(1 - i / (shades.length - 1), shade)); c.fillStyle = "rgba(6,20,33,.7)"; c.fillRect(left, h - 21, w - left - 4, 16); c.fillStyle = "#e8f1f7"; c.fillText(low, left + 5, h - 9.5); c.fillText(text, left + before + long + 15, h - 9.5);
    c.fillStyle = fill; c.fillRect(left + before + 10, h - 17, long, 8);
  }
  scale(c, f, h) { const metres = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000].find((m) => m * f.scale > 44) || 10000, long = metres * f.scale; c.fillStyle = "rgba(6,20,33,.7)"; c.fillRect(6, h - 21, long + 12, 16); c.strokeStyle = c.fillStyle = "#e8f1f7"; c.lineWidth = 1.5; c.beginPath(); c.moveTo(12, h - 9); c.lineTo(12 + long, h - 9); c.stroke(); c.font = "9.5px system-ui"; c.textAlign = "left"; c.fillText(`${metres} m`, 12, h - 11.5); }
}
function add(list, x, y) { const p = list.at(-1); if (!p || Math.hypot(p[0] - x, p[1] - y) > 0.3) list.push([x, y]); if (list.length > MOST) list.splice(0, list.length - MOST); }
