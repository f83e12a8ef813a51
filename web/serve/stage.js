// The picture, and what pointer, wheel, touch and keys do to it.

const MOST_PIXELS = 3840 * 2160;
const KEYS = /^(Arrow(Left|Right|Up|Down)|Home|PageUp|PageDown|Enter|Escape|[ +=\-wasdqefop137[\]])$/;
const BUTTONS = [ // by PointerEvent.button; `bit` is that of PointerEvent.buttons
  { name: "left", bit: 1 },
  { name: "middle", bit: 4 },
  { name: "right", bit: 2 },
];

export class Stage {
  constructor(canvas, connection) {
    this.canvas = canvas;
    this.connection = connection;
    this.size = { width: 1, height: 1 }; // that the session was told
    this.touches = new Map();
    this.pending = null; // a move, until the next frame of the display
    this.pressed = null; // the one of BUTTONS that the session was told is pressed
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.listen();
  }

  resize() {
    const box = this.canvas.getBoundingClientRect();
    if (box.width < 1 || box.height < 1) return;
    const wanted = window.devicePixelRatio || 1;
    const ratio = Math.min(wanted, Math.sqrt(MOST_PIXELS / (box.width * box.height)));
    this.size = { width: Math.max(1, Math.round(box.width * ratio)), height: Math.max(1, Math.round(box.height * ratio)) };
    this.connection.send("resize", this.size);
  }

  // Strips are decoded at once, and drawn together.
  async draw(picture, payload) {
    let at = 0;
    const strips = picture.strips.map(({ y, bytes }) => {
      const blob = new Blob([payload.subarray(at, at + bytes)], { type: "image/jpeg" });
      at += bytes;
      return createImageBitmap(blob).then((bitmap) => ({ y, bitmap }));
    });
    const drawn = await Promise.all(strips);
    if (this.canvas.width !== picture.width || this.canvas.height !== picture.height) {
      this.canvas.width = picture.width;
      this.canvas.height = picture.height;
    }
    const context = this.canvas.getContext("2d", { alpha: false });
    for (const { y, bitmap } of drawn) {
      context.drawImage(bitmap, 0, y);
      bitmap.close();
    }
  }

  // Pixels of the session's picture.
  place(x, y) {
    const box = this.canvas.getBoundingClientRect();
    return { x: ((x - box.left) / box.width) * this.size.width, y: ((y - box.top) / box.height) * this.size.height };
  }

  move(x, y) {
    if (!this.pending) requestAnimationFrame(() => this.flush());
    this.pending = { ...this.pending, ...this.place(x, y) };
  }
  zoom(steps) {
    if (!this.pending) requestAnimationFrame(() => this.flush());
    this.pending = { ...this.pending, steps: (this.pending?.steps ?? 0) + steps };
  }
  flush() {
    const pending = this.pending;
    this.pending = null;
    if (!pending) return;
    if (pending.x !== undefined) this.connection.send("move", { x: pending.x, y: pending.y });
    if (pending.steps) this.connection.send("wheel", { steps: pending.steps });
  }
  button(button, down, shift) {
    this.flush(); // where the pointer is by now
    this.connection.send("button", { button, down, shift });
  }

  listen() {
    const on = (type, act) => this.canvas.addEventListener(type, act);
    on("pointerdown", (event) => this.down(event));
    on("pointermove", (event) => (event.pointerType === "touch" ? this.touchMove(event) : this.drag(event)));
    on("pointerup", (event) => this.up(event));
    on("pointercancel", (event) => this.cancel(event));
    on("pointerleave", (event) => event.pointerType !== "touch" && this.connection.send("leave"));
    on("contextmenu", (event) => event.preventDefault());
    this.canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    on("keydown", (event) => this.key(event, true));
    on("keyup", (event) => this.key(event, false));
    on("blur", () => this.connection.send("blur"));
  }

  down(event) {
    this.canvas.focus({ preventScroll: true });
    this.canvas.setPointerCapture(event.pointerId);
    if (event.pointerType === "touch") return this.touchDown(event);
    this.move(event.clientX, event.clientY);
    this.pressed = BUTTONS[event.button];
    if (this.pressed) this.button(this.pressed.name, true, event.shiftKey);
  }
  // While a button is held, the browser reports other ones only as moves, and `pointerup` names the one that was
  // released last (Pointer Events, 11.3), so the button that began the drag is tracked here.
  drag(event) {
    this.move(event.clientX, event.clientY);
    if (this.pressed && !(event.buttons & this.pressed.bit)) this.release(event.shiftKey);
  }
  release(shift) {
    if (this.pressed) this.button(this.pressed.name, false, shift);
    this.pressed = null;
  }
  up(event) {
    if (event.pointerType === "touch") return this.touchUp(event);
    this.move(event.clientX, event.clientY);
    this.release(event.shiftKey);
  }
  cancel(event) {
    this.touches.delete(event.pointerId);
    this.pressed = null;
    this.connection.send("blur");
  }

  // One finger turns, two move and pinch. Once there were two, the one that stays does nothing.
  touchDown(event) {
    this.touches.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (this.touches.size === 1) {
      this.move(event.clientX, event.clientY);
      this.button("left", true, false);
    } else if (this.touches.size === 2) {
      this.connection.send("blur"); // a finger that is followed by another one does not click
      const { x, y, span } = this.fingers();
      this.span = span;
      this.move(x, y);
      this.button("middle", true, false);
    }
  }
  touchMove(event) {
    if (!this.touches.has(event.pointerId)) return;
    this.touches.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (this.touches.size === 1 && this.span) return;
    const { x, y, span } = this.fingers();
    this.move(x, y);
    if (this.touches.size !== 2) return;
    this.zoom(Math.log2(span / this.span) * 6);
    this.span = span;
  }
  touchUp(event) {
    if (!this.touches.delete(event.pointerId)) return;
    if (this.span) this.connection.send("blur");
    else if (this.touches.size === 0) this.button("left", false, false);
    if (this.touches.size === 0) this.span = 0;
  }
  fingers() {
    const all = [...this.touches.values()];
    const middle = (axis) => all.reduce((sum, touch) => sum + touch[axis], 0) / all.length;
    const span = all.length > 1 ? Math.hypot(all[0].x - all[1].x, all[0].y - all[1].y) : 0;
    return { x: middle("x"), y: middle("y"), span: Math.max(span, 1) };
  }

  wheel(event) {
    event.preventDefault();
    const pixels = event.deltaY * [1, 40, 400][event.deltaMode];
    this.move(event.clientX, event.clientY);
    this.zoom(-pixels / 100);
  }

  key(event, down) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const name = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    if (!KEYS.test(name)) return;
    event.preventDefault();
    if (event.repeat && /^([ opfwasdqe]|Enter)$/.test(name)) return;
    this.connection.send("key", { name, down, shift: event.shiftKey });
  }
}
