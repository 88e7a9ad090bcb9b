// Hands on the controls: keys, sticks on the screen, and a gamepad. All become four axes of -1 to 1.
const KEYS = { KeyW: ["surge", 1], KeyS: ["surge", -1], KeyA: ["yaw", 1], KeyD: ["yaw", -1], KeyQ: ["sway", 1], KeyE: ["sway", -1], KeyR: ["heave", 1], KeyF: ["heave", -1] };
const EVERY_MS = 100, DEAD = 0.12;
export class Hands {
  constructor(send, ask) {
    this.send = send; this.ask = ask; this.down = new Set(); this.sticks = { left: [0, 0], right: [0, 0] }; this.active = false;
    for (const side of ["left", "right"]) this.stick(document.getElementById(`stick-${side}`), side);
    addEventListener("blur", () => this.down.clear());
    setInterval(() => this.tell(), EVERY_MS);
  }
  key(e, pressed) { if (!(e.code in KEYS) || e.ctrlKey || e.metaKey || e.altKey) return false; if (pressed) { this.down.add(e.code); if (!e.repeat) this.tell(); } else this.down.delete(e.code); return true; }
  stick(element, side) {
    const knob = element.querySelector("i");
    const set = (x, y) => { this.sticks[side] = [x, y]; knob.style.transform = `translate(${x * 28}px, ${-y * 28}px)`; };
    const move = (e) => { const r = element.getBoundingClientRect(); let x = (e.clientX - r.left - r.width / 2) / 34, y = -(e.clientY - r.top - r.height / 2) / 34; const n = Math.max(Math.hypot(x, y), 1); set(x / n, y / n); };
    element.addEventListener("pointerdown", (e) => { element.setPointerCapture(e.pointerId); move(e); });
    element.addEventListener("pointermove", (e) => { if (element.hasPointerCapture(e.pointerId)) move(e); });
    for (const end of ["pointerup", "pointercancel"]) element.addEventListener(end, () => set(0, 0));
  }
  gamepad() {
    const pad = [...(navigator.getGamepads?.() || [])].find((p) => p && p.connected);
    document.getElementById("pad").textContent = pad ? "gamepad connected" : "";
    if (!pad) return [0, 0, 0, 0];
    return pad.axes.slice(0, 4).map((v) => Math.abs(v) < DEAD ? 0 : v);
  }
  axes() {
    const a = { surge: 0, sway: 0, heave: 0, yaw: 0 };
    for (const code of this.down) { const [axis, sign] = KEYS[code]; a[axis] += sign; }
    const [lx, ly] = this.sticks.left, [rx, ry] = this.sticks.right, [gx, gy, hx, hy] = this.gamepad();
    a.yaw += -lx - gx; a.heave += ly - gy; a.sway += -rx - (hx || 0); a.surge += ry - (hy || 0);
    for (const k of Object.keys(a)) a[k] = Math.max(-1, Math.min(1, a[k]));
    return a;
  }
  tell() {
    const a = this.axes(), moving = Object.values(a).some((v) => v !== 0), agent = this.ask();
    if (agent && (moving || this.active)) this.send({ do: "drive", agent, ...a });
    this.active = moving;
  }
}
