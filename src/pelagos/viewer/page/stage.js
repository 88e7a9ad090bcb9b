// The 3-D stage: draws the nodes that the server names, through water that takes the red first. WebGL 2, no libraries.
const MESH_V = `#version 300 es
precision highp float;
layout(location=0) in vec3 position; layout(location=1) in vec3 normal; layout(location=2) in vec4 colour;
uniform mat4 model, view; uniform vec3 paint; uniform float own;
out vec3 at, up; out vec4 tint;
void main() { vec4 w = model * vec4(position, 1.0); at = w.xyz; up = mat3(model) * normal; tint = mix(vec4(paint, 1.0), vec4(colour.rgb, 1.0), own); gl_Position = view * w; }`;
const LIGHT = `
uniform vec3 eye, water, sunward; uniform float clarity, time, opacity, glow, flat_, plain, day;
vec3 behind(float z) { return mix(.16, 1., day) * mix(vec3(.010, .040, .085), mix(vec3(.045, .19, .29), vec3(.24, .52, .60), smoothstep(.15, .95, z)), smoothstep(-.55, .35, z)); }
float wet(float z) { float low = min(z, eye.z), high = max(z, eye.z); return clamp(-low / max(high - low, 1e-3), low < 0. && high <= 0. ? 1. : 0., 1.); } // of the way to a height z, the part under water
vec3 seen(vec3 lit, vec3 at) { vec3 way = at - eye; float d = length(way); vec3 left = exp(-water * d * wet(at.z) * clarity); return lit * left + behind(way.z / max(d, .001)) * (1. - left); }
vec3 screen(vec3 c) { return pow(clamp(c, 0., 1.), vec3(1. / 2.2)); }`;
const MESH_F = `#version 300 es
precision highp float;
in vec3 at, up; in vec4 tint; out vec4 pixel;
${LIGHT}
float ripple(vec2 p) { float v = 0.; for (int i = 0; i < 3; i++) { p = mat2(.8, .6, -.6, .8) * p * 1.35 + 1.7; v += abs(sin(p.x + sin(p.y * .9 + time * .7)) + sin(p.y + sin(p.x * .8 - time * .6))); } return v / 6.; }
void main() {
  vec3 n = flat_ > .5 ? normalize(cross(dFdx(at), dFdy(at))) : normalize(up);
  if (dot(n, eye - at) < 0.) n = -n;
  vec3 base = pow(tint.rgb, vec3(2.2));
  float depth = max(-at.z, 0.);
  float caustic = 1. + .55 * day * exp(-depth * .13) * max(n.z, 0.) * pow(1. - ripple(at.xy * .9), 3.) * exp(-length(at - eye) * .03);
  float sun = day * max(dot(n, sunward), 0.), sky = mix(.22, 1., day) * (.5 + .5 * n.z);
  vec3 light = exp(-water * depth * .22 * clarity) * (mix(vec3(1.15, .72, .45), vec3(1.05, 1.02, .95), smoothstep(.02, .4, sunward.z)) * sun * caustic + vec3(.46, .56, .62) * sky + .10);
  float head = pow(max(dot(n, normalize(eye - at)), 0.), 2.) * exp(-length(at - eye) * .12);
  vec3 lit = base * (light + .22 * head) + glow * base;
  pixel = vec4(screen(mix(seen(lit, at), mix(base, seen(base, at), .4), plain)), opacity);
}`;
const FAN_F = `#version 300 es
precision highp float;
in vec3 at, up; in vec4 tint; out vec4 pixel; uniform float opacity; uniform vec3 eye;
void main() { float level = max(tint.r, max(tint.g, tint.b)), facing = abs(dot(normalize(cross(dFdx(at), dFdy(at))), normalize(eye - at))); pixel = vec4(tint.rgb, (.10 + .9 * level) * opacity * smoothstep(.0, .09, facing)); }`;
const LINE_V = `#version 300 es
precision highp float;
layout(location=0) in vec2 corner; layout(location=1) in vec3 from; layout(location=2) in vec3 to;
uniform mat4 model, view; uniform vec2 size; uniform float thick; out vec3 at;
void main() {
  vec4 wa = model * vec4(from, 1.), wb = model * vec4(to, 1.), a = view * wa, b = view * wb; const float near = .05;
  if (a.w < near) a = mix(a, b, (near - a.w) / max(b.w - a.w, 1e-5)); if (b.w < near) b = mix(b, a, (near - b.w) / max(a.w - b.w, 1e-5));
  vec2 along = (b.xy / b.w - a.xy / a.w) * size; along = length(along) > 1e-6 ? normalize(along) : vec2(1., 0.);
  vec4 p = corner.x < .5 ? a : b; at = mix(wa, wb, corner.x).xyz; p.xy += vec2(-along.y, along.x) * corner.y * thick / size * p.w; p.z -= .0006 * p.w; gl_Position = p; }`;
const LINE_F = `#version 300 es
precision highp float;
in vec3 at; out vec4 pixel; uniform vec3 paint; uniform float many;
${LIGHT}
void main() { float d = length(at - eye), level = smoothstep(.01, .1, abs(at.z - eye.z) / d), near = exp(-d * .03); // many lines in one plane lie on one another at its horizon
  pixel = vec4(screen(mix(pow(paint, vec3(2.2)), seen(pow(paint, vec3(2.2)), at), .55)), opacity * mix(1., max(level, near), many)); }`;
const POINT_V = `#version 300 es
precision highp float;
layout(location=0) in vec3 position; layout(location=2) in vec4 colour; uniform mat4 model, view; uniform vec2 size; out vec3 at; out vec4 tint;
void main() { vec4 w = model * vec4(position, 1.); at = w.xyz; tint = colour; gl_Position = view * w; gl_Position.z -= .002 * gl_Position.w; gl_PointSize = clamp(.13 * size.y / gl_Position.w, 1.6, 9.); }`;
const POINT_F = `#version 300 es
precision highp float;
in vec3 at; in vec4 tint; out vec4 pixel;
${LIGHT}
void main() { vec2 p = gl_PointCoord - .5; if (dot(p, p) > .25) discard; vec3 c = pow(tint.rgb, vec3(2.2)); pixel = vec4(screen(mix(c, seen(c, at), .5)), 1.); }`;
const SEA_V = `#version 300 es
precision highp float;
layout(location=0) in vec3 position; uniform mat4 view; uniform vec3 centre; uniform float spread, time; uniform vec4 wave[96]; uniform float height[96]; uniform int count; out vec3 at, up;
void main() {
  vec2 p = centre.xy + position.xy * spread * (.12 + .88 * length(position.xy)); float z = 0.; vec2 slope = vec2(0.);
  for (int i = 0; i < count; i++) { float turn = 6.2831853 * fract(wave[i].x * p.x + wave[i].y * p.y - wave[i].z * time + wave[i].w); z += height[i] * cos(turn); slope -= 6.2831853 * height[i] * sin(turn) * wave[i].xy; }
  at = vec3(p, z); up = normalize(vec3(-slope, 1.)); gl_Position = view * vec4(at, 1.); }`;
const SEA_F = `#version 300 es
precision highp float;
in vec3 at, up; out vec4 pixel;
${LIGHT}
float hash(vec2 p) { return fract(sin(dot(p, vec2(127.1, 311.7))) * 43758.5453); }
float bumps(vec2 p) { vec2 i = floor(p), f = fract(p); f = f * f * (3. - 2. * f); return mix(mix(hash(i), hash(i + vec2(1, 0)), f.x), mix(hash(i + vec2(0, 1)), hash(i + 1.), f.x), f.y); }
vec2 ripples(vec2 p) { vec2 s = vec2(0.); mat2 turn = mat2(.8, .6, -.6, .8); for (int i = 0; i < 3; i++) { float h = bumps(p + time * .8); s += vec2(bumps(p + vec2(.35, 0.) + time * .8) - h, bumps(p + vec2(0., .35) + time * .8) - h); p = turn * p * 2.1 - time * .5; } return s; }
void main() {
  float far = length(eye - at); vec3 way = (eye - at) / far, n = normalize(up + vec3(.22 * ripples(at.xy * .9) * exp(-far * .025), 0.));
  float facing = abs(dot(n, way)), under = step(eye.z, at.z), fresnel = .02 + .98 * pow(1. - facing, 5.);
  vec3 r = reflect(-way, n), sky = mix(vec3(.62, .74, .80), vec3(.16, .36, .56), smoothstep(0., .75, abs(r.z)));
  float glint = day * pow(max(dot(r, sunward), 0.), 90.), slope = dot(n.xy, sunward.xy);
  vec3 above = mix(vec3(.015, .10, .15) * (1. + 2.2 * slope), sky, fresnel) + .8 * glint, below = mix(vec3(.40, .66, .70), vec3(.05, .20, .29), smoothstep(.85, .55, facing));
  vec3 c = mix(.16, 1., day) * mix(above, below, under); float veil = mix(.42 + .5 * fresnel, .36, under);
  pixel = vec4(screen(mix(c, seen(c, at), .75 * under + .1)), veil * opacity); }`;
const BACK_V = `#version 300 es
out vec2 p; void main() { p = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2) * 2. - 1.; gl_Position = vec4(p, 1., 1.); }`;
const BACK_F = `#version 300 es
precision highp float;
in vec2 p; out vec4 pixel; uniform mat3 turn; uniform vec2 lens;
${LIGHT}
void main() { vec3 way = normalize(turn * vec3(p * lens, -1.)); vec3 air = mix(.12, 1., day) * mix(mix(vec3(.80, .62, .50), vec3(.55, .70, .78), smoothstep(.02, .3, sunward.z)), vec3(.20, .42, .62), smoothstep(.0, .7, way.z)); pixel = vec4(screen(eye.z > .3 && way.z > -.02 ? air : behind(way.z)), 1.); }`;

const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]], add = (a, b, s = 1) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2], cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const norm = (a) => { const n = Math.hypot(...a) || 1; return [a[0] / n, a[1] / n, a[2] / n]; };
const turned = (q, v) => { const [w, x, y, z] = q, t = [2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])]; return add(add(v, t, w), cross([x, y, z], t)); };
const times = (a, b) => [a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2], a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]];
const matrix = ([p, q]) => { const c = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((e) => turned(q, e)); return new Float32Array([...c[0], 0, ...c[1], 0, ...c[2], 0, ...p, 1]); };
const UNIT = [[0, 0, 0], [1, 0, 0, 0]], FOV = 55 * Math.PI / 180, WAVES = 96, CLICK_PX = 5, NEAR_PX = 22, DRAG_MS = 100;
export const plain = (name) => name.replace(/[^\p{L}\p{N}_-]/gu, "_");

export class Stage {
  constructor(canvas, labels) {
    this.canvas = canvas; this.labelPlace = labels;
    const gl = this.gl = canvas.getContext("webgl2", { antialias: true, alpha: false, powerPreference: "high-performance" });
    if (!gl) throw new Error("no WebGL 2");
    this.programs = { mesh: this.program(MESH_V, MESH_F), fan: this.program(MESH_V, FAN_F), lines: this.program(LINE_V, LINE_F), points: this.program(POINT_V, POINT_F), sea: this.program(SEA_V, SEA_F), back: this.program(BACK_V, BACK_F) };
    this.nodes = new Map(); this.hidden = new Set(); this.goal = {}; this.poses = {}; this.look = "follow"; this.agent = ""; this.length = 1.6;
    this.eye = [-40, 30, 20]; this.target = [0, 0, -5]; this.offset = null; this.time = 0; this.simTime = 0; this.clock = 0; this.sharp = 1; this.spent = 12; this.showSea = true; this.water = [.28, .09, .075]; this.sunward = [-.5, 0, .866]; this.clarity = .55; this.tool = "way";
    this.corner = this.buffer(new Float32Array([0, -1, 0, 1, 1, -1, 1, 1])); this.seaMesh = this.grid(72); this.waves = new Float32Array(4 * WAVES); this.heights = new Float32Array(WAVES); this.waveCount = 0; this.pictures = 0; this.onLook = this.onPick = this.onPut = this.onDrag = this.onRemove = () => {}; this.props = () => [];
    this.empty = gl.createVertexArray(); this.hands(); this.again = true; new ResizeObserver(() => { this.again = true; }).observe(canvas);
    requestAnimationFrame((t) => this.frame(t));
  }
  program(v, f) {
    const gl = this.gl, p = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, v], [gl.FRAGMENT_SHADER, f]]) { const s = gl.createShader(kind); gl.shaderSource(s, text); gl.compileShader(s); if (!gl.getShaderParameter(s, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(s)); gl.attachShader(p, s); }
    gl.linkProgram(p); if (!gl.getProgramParameter(p, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(p));
    const found = {}; for (let i = 0; i < gl.getProgramParameter(p, gl.ACTIVE_UNIFORMS); i++) { const name = gl.getActiveUniform(p, i).name.replace("[0]", ""); found[name] = gl.getUniformLocation(p, name); }
    return { p, at: found };
  }
  buffer(data, kind = this.gl.ARRAY_BUFFER) { const gl = this.gl, b = gl.createBuffer(); gl.bindVertexArray(null); gl.bindBuffer(kind, b); gl.bufferData(kind, data, gl.DYNAMIC_DRAW); return b; }
  grid(n) { // finer in the middle: the shader spreads it
    const v = [], f = []; for (let i = 0; i <= n; i++) for (let j = 0; j <= n; j++) v.push(2 * i / n - 1, 2 * j / n - 1, 0);
    for (let i = 0; i < n; i++) for (let j = 0; j < n; j++) { const a = i * (n + 1) + j; f.push(a, a + n + 1, a + n + 2, a, a + n + 2, a + 1); }
    const gl = this.gl, place = this.buffer(new Float32Array(v)), index = this.buffer(new Uint32Array(f), gl.ELEMENT_ARRAY_BUFFER), vao = gl.createVertexArray(); gl.bindVertexArray(vao); gl.bindBuffer(gl.ARRAY_BUFFER, place); gl.enableVertexAttribArray(0); gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0); gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, index); gl.bindVertexArray(null);
    return { vao, count: f.length };
  }
  sea(rows) { this.waveCount = Math.min(rows.length, WAVES); this.again = true; rows.slice(0, WAVES).forEach(([kx, ky, f, phase, a], i) => { this.waves.set([kx, ky, f, phase], 4 * i); this.heights[i] = a; }); }
  arrays(header, blob) { const kinds = { f4: Float32Array, u4: Uint32Array, u1: Uint8Array }, out = {}; for (const a of header.arrays) out[a.name] = new kinds[a.type](blob.buffer, blob.byteOffset + a.at, a.count); return out; }
  reset() { for (const name of [...this.nodes.keys()]) this.gone({ name }); this.poses = {}; this.goal = {}; }
  node(h, blob) {
    this.drop(h.name); const data = this.arrays(h, blob), n = { ...h, path: h.name.split("/").slice(1).map((_, i, all) => "/" + all.slice(0, i + 1).join("/")), vao: null, buffers: {} };
    if (h.kind === "label") { n.element = document.createElement("span"); n.element.textContent = h.text; n.element.className = h.small ? "label small" : "label"; n.element.style.display = "none"; this.labelPlace.append(n.element); }
    this.nodes.set(h.name, n); this.fill(n, data); this.again = true;
  }
  part(h, blob) { const n = this.nodes.get(h.name); if (n) { this.fill(n, this.arrays(h, blob)); this.again = true; } }
  gone({ name }) { for (const key of [...this.nodes.keys()]) if (key === name || key.startsWith(name + "/")) this.drop(key); this.again = true; }
  drop(name) { const n = this.nodes.get(name); if (!n) return; n.element?.remove(); for (const b of Object.values(n.buffers)) this.gl.deleteBuffer(b); if (n.vao) this.gl.deleteVertexArray(n.vao); this.nodes.delete(name); }
  seen({ name, visible }) { this.hidden[visible ? "delete" : "add"](name); this.again = true; }
  fill(n, data) {
    const gl = this.gl; gl.bindVertexArray(null);
    const set = (key, values, kind = gl.ARRAY_BUFFER) => { n.buffers[key] ||= gl.createBuffer(); gl.bindBuffer(kind, n.buffers[key]); gl.bufferData(kind, values, gl.DYNAMIC_DRAW); };
    const attribute = (at, key, size, type, unit, step = 0, stride = 0, from = 0) => { gl.bindBuffer(gl.ARRAY_BUFFER, n.buffers[key]); gl.enableVertexAttribArray(at); gl.vertexAttribPointer(at, size, type, unit, stride, from); gl.vertexAttribDivisor(at, step); };
    if (data.vertices) { set("vertices", data.vertices); if (n.smooth) set("normals", normals(data.vertices, data.faces)); }
    if (data.colours) set("colours", data.colours);
    if (data.points) { set("points", data.points); n.count = data.points.length / (n.kind === "lines" ? 6 : 3); }
    n.vao ||= gl.createVertexArray(); 
    if (data.faces) { set("faces", data.faces, gl.ELEMENT_ARRAY_BUFFER); n.count = data.faces.length; }
    gl.bindVertexArray(n.vao);
    if (n.kind === "lines" && n.buffers.points) {
      gl.bindBuffer(gl.ARRAY_BUFFER, this.corner); gl.enableVertexAttribArray(0); gl.vertexAttribPointer(0, 2, gl.FLOAT, false, 0, 0);
      attribute(1, "points", 3, gl.FLOAT, false, 1, 24, 0); attribute(2, "points", 3, gl.FLOAT, false, 1, 24, 12);
    } else if (n.buffers.vertices || n.buffers.points) {
      attribute(0, n.buffers.vertices ? "vertices" : "points", 3, gl.FLOAT, false); if (n.buffers.normals) attribute(1, "normals", 3, gl.FLOAT, false); if (n.buffers.colours) attribute(2, "colours", 3, gl.UNSIGNED_BYTE, true);
      if (n.buffers.faces) gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, n.buffers.faces);
    }
    gl.bindVertexArray(null);
  }
  move(h) { this.simTime = h.t; this.goal = h.poses; for (const [name, v] of Object.entries(h.poses)) if (!this.poses[name]) { this.poses[name] = [v.slice(0, 3), v.slice(3)]; this.again = true; } for (const name of Object.keys(this.poses)) if (!h.poses[name]) { delete this.poses[name]; this.again = true; } } // what only moves is drawn by `glide`; what stands still is not drawn again
  glide(dt) { // shown poses run after the newest ones
    const part = 1 - Math.exp(-dt * 14); let moves = false;
    for (const [name, v] of Object.entries(this.goal)) {
      const [p, q] = this.poses[name], far = Math.hypot(v[0] - p[0], v[1] - p[1], v[2] - p[2]), same = q[0] * v[3] + q[1] * v[4] + q[2] * v[5] + q[3] * v[6], s = same < 0 ? -1 : 1;
      if (far < 1e-4 && Math.abs(same) > 1 - 1e-7) continue; moves = true;
      const k = far > 15 ? 1 : part; for (let i = 0; i < 3; i++) p[i] += k * (v[i] - p[i]);
      for (let i = 0; i < 4; i++) q[i] += k * (s * v[3 + i] - q[i]); const n = Math.hypot(...q); for (let i = 0; i < 4; i++) q[i] /= n;
    }
    return moves;
  }
  world(n) { let p = [0, 0, 0], q = [1, 0, 0, 0]; for (const at of n.path) { const own = this.poses[at]; if (own) { p = add(p, turned(q, own[0])); q = times(q, own[1]); } } return [p, q]; }
  visible(n) { return !n.path.some((at) => this.hidden.has(at)); }

  day() { const t = Math.max(0, Math.min(1, (this.sunward[2] + .1) / .35)); return t * t * (3 - 2 * t); } // 0 at night, 1 by day

  // the eye
  followed() { return this.poses[`/agents/${plain(this.agent)}`]; }
  choose(look) { this.look = look; this.offset = null; this.again = true; }
  overview([x0, y0, x1, y1], z) { const s = Math.hypot(x1 - x0, y1 - y0); this.target = [(x0 + x1) / 2, (y0 + y1) / 2, z]; this.eye = add(this.target, [-.42 * s, .30 * s, .36 * s]); this.look = "free"; this.again = true; }
  aim(dt) {
    const pose = this.followed(); if (!pose) return;
    const [p, q] = pose, ahead = turned(q, [1, 0, 0]), level = norm([ahead[0], ahead[1], 0]), left = cross([0, 0, 1], level), L = Math.max(this.length, .3);
    if (this.look === "follow") {
      if (!this.offset) { const back = 2.4 * L + .9; this.offset = add(add(add([0, 0, 0], level, -back), left, .5 * back), [0, 0, 1], .36 * back); }
      this.target = p.slice(); this.eye = add(p, this.offset);
    } else if (this.look === "top") { if (!this.offset) this.offset = [-.01, 0, 14 * L + 14]; this.target = p.slice(); this.eye = add(p, this.offset); }
    else if (this.look === "aboard") { this.eye = add(p, turned(q, [.52 * L, 0, .04 + .15 * L])); this.target = add(this.eye, turned(q, [4, 0, -.7])); }
  }
  hands() {
    const c = this.canvas, held = new Map(); let gap = 0, prop = null, first = null, from = [0, 0], moved = false, told = 0;
    const way = (e) => { const r = c.getBoundingClientRect(); return this.ray(2 * (e.clientX - r.left) / r.width - 1, 1 - 2 * (e.clientY - r.top) / r.height); };
    c.addEventListener("pointerdown", (e) => {
      c.setPointerCapture(e.pointerId); held.set(e.pointerId, [e.clientX, e.clientY]); c.focus();
      if (held.size === 1) { from = [e.clientX, e.clientY]; moved = false; prop = this.tool === "prop" ? this.near(e) : null; }
    });
    c.addEventListener("pointermove", (e) => {
      const was = held.get(e.pointerId); if (!was) return; const dx = e.clientX - was[0], dy = e.clientY - was[1]; held.set(e.pointerId, [e.clientX, e.clientY]);
      moved ||= Math.hypot(e.clientX - from[0], e.clientY - from[1]) > CLICK_PX;
      if (prop) { if (moved && performance.now() - told > DRAG_MS) { told = performance.now(); this.onDrag(prop, this.eye, way(e)); } return; }
      if (held.size > 1) { const [a, b] = [...held.values()], now = Math.hypot(a[0] - b[0], a[1] - b[1]); if (gap) this.zoom(gap / now); gap = now; return; }
      if (e.buttons & 2 || e.shiftKey) this.pan(dx, dy); else this.orbit(-dx * .006, -dy * .006);
    });
    for (const end of ["pointerup", "pointercancel"]) c.addEventListener(end, (e) => { held.delete(e.pointerId); gap = 0; if (prop && moved) this.onDrag(prop, this.eye, way(e)); this.onLook(this.target); });
    c.addEventListener("click", (e) => { if (e.detail === 1) { first = prop; if (this.tool === "prop" && !prop && !moved) this.onPut(this.eye, way(e)); } });
    c.addEventListener("dblclick", (e) => { if (this.tool !== "prop") this.onPick(this.eye, way(e)); else if (first) this.onRemove(first); });
    c.addEventListener("wheel", (e) => { e.preventDefault(); this.zoom(Math.exp(e.deltaY * .0012)); }, { passive: false }); c.addEventListener("contextmenu", (e) => e.preventDefault());
  }
  near(e) { // the prop under the pointer
    const r = this.canvas.getBoundingClientRect(); let best = null, least = NEAR_PX;
    for (const name of this.props()) {
      const pose = this.poses[`/bodies/${plain(name)}`], at = pose && this.project(pose[0]); if (!at) continue;
      const far = Math.hypot(at[0] - (e.clientX - r.left), at[1] - (e.clientY - r.top)); if (far < least) { least = far; best = name; }
    }
    return best;
  }
  project([x, y, z]) { // a place in the picture [px]; null behind the eye
    const m = this.view, w = this.canvas.clientWidth, h = this.canvas.clientHeight; if (!m) return null; const d = m[3] * x + m[7] * y + m[11] * z + m[15]; if (d < .1) return null;
    return [(.5 + .5 * (m[0] * x + m[4] * y + m[8] * z + m[12]) / d) * w, (.5 - .5 * (m[1] * x + m[5] * y + m[9] * z + m[13]) / d) * h, d];
  }
  ray(x, y) { // the way from the eye through a place of the picture, -1 to 1 rightwards and upwards
    const back = norm(sub(this.eye, this.target)), right = norm(cross([0, 0, 1], back)), t = Math.tan(FOV / 2), aspect = this.canvas.clientWidth / this.canvas.clientHeight;
    return norm(add(add(sub([0, 0, 0], back), right, x * t * aspect), cross(back, right), y * t));
  }
  arm(change) { let o = change(sub(this.eye, this.target)); this.eye = add(this.target, o); if (this.look !== "free") this.offset = o; this.again = true; }
  orbit(turn, tilt) { this.arm((o) => { const r = Math.hypot(...o), a = Math.atan2(o[1], o[0]) + turn, e = Math.max(-1.5, Math.min(1.5, Math.asin(o[2] / r) - tilt)); return [r * Math.cos(e) * Math.cos(a), r * Math.cos(e) * Math.sin(a), r * Math.sin(e)]; }); }
  zoom(k) { this.arm((o) => { const r = Math.hypot(...o), s = Math.max(.6, Math.min(5000, r * k)) / r; return o.map((v) => v * s); }); }
  pan(dx, dy) { if (this.look !== "free") return; const o = sub(this.eye, this.target), r = Math.hypot(...o) * .0016, right = norm(cross(sub([0, 0, 0], o), [0, 0, 1])), up = norm(cross(right, sub([0, 0, 0], o))); for (const v of [this.eye, this.target]) for (let i = 0; i < 3; i++) v[i] += (-dx * right[i] + dy * up[i]) * r; this.again = true; }

  // pictures
  frame(now) {
    requestAnimationFrame((t) => this.frame(t)); const dt = Math.min((now - this.clock) / 1000, .25);
    if (now - this.clock < Math.max(15, (this.spent > 60 ? 2.5 : 1.6) * this.spent) || document.hidden) return; // software rendering leaves time for the rest of the page
    const moves = this.glide(dt); this.clock = now; this.time += (this.simTime - this.time) * (Math.abs(this.simTime - this.time) > 2 ? 1 : 1 - Math.exp(-dt * 8));
    if (!moves && !this.again && Math.abs(this.simTime - this.time) < .004) return;
    this.again = false; const start = performance.now(); this.aim(dt); this.draw(); this.gl.finish(); if (this.spent > 30) this.gl.readPixels(0, 0, 1, 1, this.gl.RGBA, this.gl.UNSIGNED_BYTE, new Uint8Array(4));
    this.spent = .7 * this.spent + .3 * (performance.now() - start); this.pictures++; this.sharp = this.spent > 70 ? Math.max(.45, this.sharp * .9) : this.spent < 25 ? Math.min(1, this.sharp * 1.05) : this.sharp;
  }
  draw() {
    const gl = this.gl, c = this.canvas, ratio = Math.min(devicePixelRatio || 1, 1.5) * this.sharp, w = Math.max(2, Math.round(c.clientWidth * ratio)), h = Math.max(2, Math.round(c.clientHeight * ratio));
    if (c.width !== w || c.height !== h) { c.width = w; c.height = h; } gl.viewport(0, 0, w, h);
    const back = norm(sub(this.eye, this.target)), right = norm(cross([0, 0, 1], back)), up = cross(back, right), f = 1 / Math.tan(FOV / 2), aspect = w / h, near = .08, far = 8000;
    const e = this.eye, v = [right[0], up[0], back[0], right[1], up[1], back[1], right[2], up[2], back[2]], t = [-dot(right, e), -dot(up, e), -dot(back, e)], view = new Float32Array(16), zz = (far + near) / (near - far), zw = 2 * far * near / (near - far);
    for (let i = 0; i < 4; i++) { const [a, b, d] = i < 3 ? v.slice(3 * i, 3 * i + 3) : t; view[4 * i] = a * f / aspect; view[4 * i + 1] = b * f; view[4 * i + 2] = d * zz + (i === 3 ? zw : 0); view[4 * i + 3] = -d; }
    this.view = view; gl.clearColor(.02, .09, .15, 1); gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const use = (name) => { const { p, at } = this.programs[name]; gl.useProgram(p); if (at.view) gl.uniformMatrix4fv(at.view, false, view); if (at.eye) gl.uniform3fv(at.eye, e); if (at.water) gl.uniform3fv(at.water, this.water); if (at.sunward) gl.uniform3fv(at.sunward, this.sunward); gl.uniform1f(at.day ?? null, this.day()); gl.uniform1f(at.clarity ?? null, this.clarity); gl.uniform1f(at.time ?? null, this.time); gl.uniform1f(at.opacity ?? null, 1); if (at.size) gl.uniform2f(at.size, w, h); return at; };
    let at = use("back"); gl.disable(gl.DEPTH_TEST); gl.uniformMatrix3fv(at.turn, false, new Float32Array([...right, ...up, ...back])); gl.uniform2f(at.lens, aspect / f, 1 / f); gl.bindVertexArray(this.empty); gl.drawArrays(gl.TRIANGLES, 0, 3); gl.enable(gl.DEPTH_TEST);
    const shown = [...this.nodes.values()].filter((n) => n.count && this.visible(n)), of = (kind) => shown.filter((n) => n.kind === kind);
    gl.disable(gl.BLEND); at = use("mesh"); const meshes = of("mesh"); for (const n of meshes.filter((m) => !m.opacity)) this.mesh(n, at);
    gl.enable(gl.BLEND); gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    at = use("points"); for (const n of of("points")) { gl.uniformMatrix4fv(at.model, false, matrix(UNIT)); gl.bindVertexArray(n.vao); gl.drawArrays(gl.POINTS, 0, n.count); }
    at = use("lines"); gl.uniform1f(at.thick, 2.2 * ratio); for (const n of of("lines")) { gl.uniform1f(at.many, n.name === "/currents" ? 1 : 0); gl.uniformMatrix4fv(at.model, false, matrix(this.world(n))); gl.uniform3fv(at.paint, n.colour.map((x) => x / 255)); gl.bindVertexArray(n.vao); gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, n.count); }
    gl.depthMask(false); at = use("fan"); for (const n of of("fan")) { gl.uniform1f(at.opacity, .8); this.mesh(n, at); }
    if (this.showSea) { at = use("sea"); gl.uniform3f(at.centre, e[0], e[1], 0); gl.uniform1f(at.spread, 500); gl.uniform4fv(at.wave, this.waves); gl.uniform1fv(at.height, this.heights); gl.uniform1i(at.count, this.waveCount); gl.bindVertexArray(this.seaMesh.vao); gl.drawElements(gl.TRIANGLES, this.seaMesh.count, gl.UNSIGNED_INT, 0); }
    at = use("mesh"); for (const n of meshes.filter((m) => m.opacity)) { gl.uniform1f(at.opacity, n.opacity); this.mesh(n, at); } gl.depthMask(true); gl.bindVertexArray(null);
    this.labels(c.clientWidth, c.clientHeight);
  }
  mesh(n, at) { const gl = this.gl; gl.uniformMatrix4fv(at.model, false, matrix(this.world(n))); if (at.paint) gl.uniform3fv(at.paint, (n.colour || [255, 255, 255]).map((x) => x / 255)); gl.uniform1f(at.own ?? null, n.buffers.colours ? 1 : 0); gl.uniform1f(at.flat_ ?? null, n.smooth ? 0 : 1); gl.uniform1f(at.plain ?? null, n.plain ? 1 : 0); gl.uniform1f(at.glow ?? null, n.path[0] === "/agents" ? .10 : 0); gl.bindVertexArray(n.vao); gl.drawElements(gl.TRIANGLES, n.count, gl.UNSIGNED_INT, 0); }
  labels(w, h) {
    const m = this.view, taken = []; for (const n of this.nodes.values()) {
      if (!n.element) continue; let [p] = this.world(n); const parent = this.poses[n.path.at(-2)]; if (parent && this.poses[n.name]) p = add(parent[0], [0, 0, this.poses[n.name][0][2]]); // upright over its vehicle
      const x = m[0] * p[0] + m[4] * p[1] + m[8] * p[2] + m[12], y = m[1] * p[0] + m[5] * p[1] + m[9] * p[2] + m[13], d = m[3] * p[0] + m[7] * p[1] + m[11] * p[2] + m[15];
      let out = d < .2 || d > (n.small ? (this.agent ? 160 : 600) : 900) || Math.abs(x) > d || Math.abs(y) > d || !this.visible(n); const sx = (.5 + .5 * x / d) * w, sy = (.5 - .5 * y / d) * h, half = 3.2 * n.text.length; // names that would lie on another wait until one comes nearer
      if (!out && n.small) { out = taken.some(([ox, oy, oh]) => Math.abs(ox - sx) < oh + half && Math.abs(oy - sy) < 14); if (!out) taken.push([sx, sy, half]); }
      n.element.style.display = out ? "none" : ""; if (!out) n.element.style.transform = `translate(-50%, -100%) translate(${sx}px, ${sy}px)`;
    }
  }
}
function normals(v, f) {
  const n = new Float32Array(v.length);
  for (let i = 0; i < f.length; i += 3) { const [a, b, c] = [3 * f[i], 3 * f[i + 1], 3 * f[i + 2]], ux = v[b] - v[a], uy = v[b + 1] - v[a + 1], uz = v[b + 2] - v[a + 2], wx = v[c] - v[a], wy = v[c + 1] - v[a + 1], wz = v[c + 2] - v[a + 2], x = uy * wz - uz * wy, y = uz * wx - ux * wz, z = ux * wy - uy * wx; for (const k of [a, b, c]) { n[k] += x; n[k + 1] += y; n[k + 2] += z; } }
  for (let i = 0; i < n.length; i += 3) { const l = Math.hypot(n[i], n[i + 1], n[i + 2]) || 1; n[i] /= l; n[i + 1] /= l; n[i + 2] /= l; }
  return n;
}
