// The sun's sliders, and handles of the lights that have a place.

const $ = (id) => document.getElementById(id);
const NOON = [30, 40]; // degrees, where a sun that is not there yet begins
const STEP = 8; // pixels that an arrow key moves a light; with shift one

export class Sun {
  // `change(text)` is called with the option's text; an empty one is none.
  constructor(change) {
    for (const id of ["sun-azimuth", "sun-elevation"])
      $(id).oninput = () => change([$("sun-azimuth").value, $("sun-elevation").value, ...this.rest].join(","));
    $("sun-off").onclick = () => change("");
    this.show("");
  }

  show(text) {
    const [azimuth, elevation, ...rest] = text ? text.split(",") : NOON;
    this.rest = rest;
    $("sun-off").disabled = !text;
    for (const [id, value] of [["sun-azimuth", azimuth], ["sun-elevation", elevation]])
      if (document.activeElement !== $(id)) $(id).value = value;
  }
}

export class Handles {
  // `size()`: of the session's picture; `drag(light, x, y)` and `nudge(light, dx, dy)` are called with its pixels.
  constructor(layer, size, drag, nudge) {
    Object.assign(this, { layer, size, drag, nudge, held: null });
  }

  show(lights) {
    while (this.layer.children.length > lights.length) this.layer.lastChild.remove();
    while (this.layer.children.length < lights.length) this.layer.append(this.handle(this.layer.children.length));
    const { width, height } = this.size();
    lights.forEach(({ name, type, at }, i) => {
      const handle = this.layer.children[i];
      handle.hidden = !at || at[0] < 0 || at[1] < 0 || at[0] > width || at[1] > height;
      handle.setAttribute("aria-label", `Light ${name || i}, ${type}`);
      handle.title = `${name || i} (${type})`;
      if (handle.hidden || this.held === i) return;
      this.place(handle, at);
    });
  }

  place(handle, [x, y]) {
    const { width, height } = this.size();
    handle.style.left = `${(100 * x) / width}%`;
    handle.style.top = `${(100 * y) / height}%`;
  }

  handle(light) {
    const handle = document.createElement("button");
    handle.className = "handle";
    handle.onpointerdown = (event) => {
      handle.setPointerCapture(event.pointerId);
      this.held = light;
    };
    handle.onpointermove = (event) => {
      if (this.held !== light) return;
      const box = this.layer.getBoundingClientRect(), { width, height } = this.size();
      const x = ((event.clientX - box.left) / box.width) * width, y = ((event.clientY - box.top) / box.height) * height;
      this.place(handle, [x, y]); // at once, before the picture
      this.drag(light, x, y);
    };
    handle.onpointerup = handle.onpointercancel = () => (this.held = null);
    handle.onkeydown = (event) => {
      const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
      if (!way) return;
      event.preventDefault();
      const step = event.shiftKey ? 1 : STEP;
      this.nudge(light, step * way[0], step * way[1]);
    };
    return handle;
  }
}
