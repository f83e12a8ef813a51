"use strict";
// What the page does beyond its HTML: it compares pictures pixel by pixel, turns spheres, and copies commands. Each
// part is there only where its elements are.

const data = JSON.parse(document.getElementById("data").textContent);
const byId = (id) => document.getElementById(id);

function element(name, text, properties = {}) {
  return Object.assign(document.createElement(name), {textContent: text}, properties);
}

// --- values of every pixel (src/report/planes.cpp) ---------------------------------------------------------------------

const planes = new Map();

async function readPlane(number) {
  const packed = Uint8Array.from(atob(byId(`plane-${number}`).textContent), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  const words = new Uint32Array(bytes.length / 4);
  for (let b = 0; b < 4; ++b) {
    let value = 0;
    for (let i = 0; i < words.length; ++i) {
      value = (value + bytes[b * words.length + i]) & 255;
      words[i] |= value << (8 * b);
    }
  }
  const count = words[0], pixels = words.subarray(1 + count);
  return count ? pixels.map((i) => words[1 + i]) : pixels;
}

function plane(number) {
  if (!planes.has(number)) planes.set(number, readPlane(number));
  return planes.get(number);
}

// The shortest decimal number that is this float.
function floatText(value) {
  if (!Number.isFinite(value)) return Number.isNaN(value) ? "nan" : value > 0 ? "inf" : "-inf";
  for (let digits = 1; digits < 9; ++digits) {
    const text = Number(value.toPrecision(digits));
    if (Math.fround(text) === value) return Object.is(value, -0) ? "-0" : String(text);
  }
  return String(Number(value.toPrecision(9)));
}

const asFloat = (word) => new Float32Array(new Uint32Array([word]).buffer)[0];

const textOf = {
  float: (word) => floatText(asFloat(word)),
  integer: (word) => String(word),
  bytes: (word) => [0, 8, 16, 24].map((shift) => (word >>> shift) & 255).join(" "),
};

// --- comparing ----------------------------------------------------------------------------------------------------------

const compare = {
  sides: ["left", "right"],
  zoom: 1,         // screen pixels a picture pixel, in units of the whole picture's
  center: [0, 0],  // of what is shown, in picture pixels
  pixel: [0, 0],

  start() {
    this.center = [data.width / 2, data.height / 2];
    this.point(data.width >> 1, data.height >> 1);
    for (const side of this.sides) this.fillChoices(byId(side));
    byId("right").value = 1;
    for (const side of this.sides) byId(side).addEventListener("change", () => this.show());
    byId("divider").addEventListener("input", () => this.draw());
    byId("zoom").addEventListener("input", () => this.zoomTo(Number(byId("zoom").value)));
    for (const axis of [0, 1]) this.followNumber(axis);
    this.followKeys();
    this.followPointer();
    new ResizeObserver(() => this.draw()).observe(byId("stage"));
    this.show();
  },

  fillChoices(select) {
    let group = null;
    data.views.forEach((view, i) => {
      if (group?.label !== view.group) group = select.appendChild(Object.assign(document.createElement("optgroup"), {label: view.group}));
      group.append(element("option", `${view.name} (${view.group})`, {value: i}));
    });
  },

  view(side) { return data.views[byId(side).value]; },

  async show() {
    await Promise.all(this.sides.map((side) => byId(this.view(side).image).decode()));
    this.draw();
    await this.tell();
  },

  // Where the picture lies in the canvas: the size of its pixels, and its corner.
  frame(canvas) {
    const size = canvas.width / data.width * this.zoom;
    return {size, x: canvas.width / 2 - this.center[0] * size, y: canvas.height / 2 - this.center[1] * size};
  },

  draw() {
    const canvas = byId("canvas"), context = canvas.getContext("2d");
    const width = Math.round(byId("stage").clientWidth * devicePixelRatio);
    if (width === 0) return;
    const height = Math.round(width * data.height / data.width);
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, {width, height});
    const {size, x, y} = this.frame(canvas), split = Math.round(width * byId("divider").value / 100);
    context.clearRect(0, 0, width, height);
    context.imageSmoothingEnabled = size < 1;
    for (const side of this.sides) {
      context.save();
      context.beginPath();
      if (side === "left") context.rect(0, 0, split, height);
      else context.rect(split, 0, width - split, height);
      context.clip();
      context.drawImage(byId(this.view(side).image), x, y, data.width * size, data.height * size);
      context.restore();
    }
    this.mark(context, split, size, x, y);
  },

  // The divider and the pixel, in black and white, to be seen on anything.
  mark(context, split, size, x, y) {
    for (const [color, width] of [["#000", 3], ["#fff", 1]]) {
      context.strokeStyle = color;
      context.lineWidth = width * devicePixelRatio;
      context.beginPath();
      context.moveTo(split, 0);
      context.lineTo(split, context.canvas.height);
      context.stroke();
      context.strokeRect(x + this.pixel[0] * size, y + this.pixel[1] * size, size, size);
    }
  },

  async tell() {
    const [x, y] = this.pixel, index = y * data.width + x, views = this.sides.map((side) => this.view(side));
    const words = {};
    for (const [i, side] of this.sides.entries())
      words[side] = await Promise.all(views[i].values.map(async (value) => (await plane(value.plane))[index]));
    // Moved on meanwhile, or another picture was chosen, which is told by itself.
    if (this.pixel[0] !== x || this.pixel[1] !== y || this.sides.some((side, i) => this.view(side) !== views[i])) return;
    for (const side of this.sides) this.fillValues(side, words[side]);
  },

  fillValues(side, words) {
    const view = this.view(side), [x, y] = this.pixel;
    const rows = view.values.map((value, i) => {
      const row = document.createElement("tr");
      row.append(element("th", value.name, {scope: "row"}),
                 element("td", textOf[value.kind](words[i]), {className: "number"}));
      return row;
    });
    byId(`${side}-values`).replaceChildren(
      element("caption", `${side === "left" ? "Left" : "Right"}: ${view.name} (${view.group}) at ${x}, ${y}`), ...rows);
  },

  // Nothing else writes to the fields: what is being typed there stays while pictures and values arrive.
  point(x, y) {
    this.pixel = [Math.min(Math.max(x, 0), data.width - 1), Math.min(Math.max(y, 0), data.height - 1)];
    byId("x").value = this.pixel[0], byId("y").value = this.pixel[1];
  },

  select(x, y) {
    this.point(x, y);
    this.draw();
    this.tell();
  },

  // Moves the picture so that the pixel can be seen.
  follow() {
    const half = [data.width / this.zoom / 2, data.height / this.zoom / 2];
    for (const axis of [0, 1])
      this.center[axis] = Math.min(Math.max(this.center[axis], this.pixel[axis] + 1 - half[axis]), this.pixel[axis] + half[axis]);
  },

  zoomTo(step) {
    const input = byId("zoom");
    input.value = step;
    this.zoom = 2 ** Number(input.value);
    byId("zoom-text").value = `${this.zoom}x`;
    if (this.zoom === 1) this.center = [data.width / 2, data.height / 2];
    else this.follow();
    this.draw();
  },

  followNumber(axis) {
    const input = byId(axis === 0 ? "x" : "y");
    input.max = (axis === 0 ? data.width : data.height) - 1;
    input.addEventListener("change", () => {
      this.select(Math.round(byId("x").valueAsNumber || 0), Math.round(byId("y").valueAsNumber || 0));
      this.follow();
      this.draw();
    });
  },

  followKeys() {
    const moves = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]};
    byId("stage").addEventListener("keydown", (event) => {
      const move = moves[event.key], step = event.shiftKey ? 10 : 1, divider = byId("divider");
      if (move) {
        this.select(this.pixel[0] + step * move[0], this.pixel[1] + step * move[1]);
        this.follow();
      } else if (event.key === "+" || event.key === "-") {
        this.zoomTo(Number(byId("zoom").value) + (event.key === "+" ? 1 : -1));
      } else if (event.key === "[" || event.key === "]") {
        divider.value = Number(divider.value) + (event.key === "]" ? 2 : -2);
      } else {
        return;
      }
      event.preventDefault();
      this.draw();
    });
  },

  // Moving reads the pixel below; dragging moves the divider where it begins there, else the picture.
  followPointer() {
    const stage = byId("stage");
    let drag = null;
    const place = (event) => {
      const box = stage.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top, box.width];
    };
    stage.addEventListener("pointerdown", (event) => {
      const [x, , width] = place(event);
      drag = Math.abs(x / width * 100 - byId("divider").value) < 1.5 ? "divider" : "picture";
      stage.setPointerCapture(event.pointerId);
    });
    stage.addEventListener("pointerup", () => { drag = null; });
    stage.addEventListener("pointercancel", () => { drag = null; });
    stage.addEventListener("pointermove", (event) => {
      const [x, y, width] = place(event), size = width / data.width * this.zoom;
      if (drag === "divider") byId("divider").value = x / width * 100;
      if (drag === "picture") this.center = [this.center[0] - event.movementX / size, this.center[1] - event.movementY / size];
      const {x: left, y: top} = this.frame({width, height: width * data.height / data.width});
      if (!drag) this.select(Math.floor((x - left) / size), Math.floor((y - top) / size));
      this.draw();
    });
    stage.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoomTo(Number(byId("zoom").value) - Math.sign(event.deltaY));
    }, {passive: false});
  },
};

// --- spheres ------------------------------------------------------------------------------------------------------------

const spheres = {
  start() {
    for (const id of ["sphere-turn", "sphere-tilt"]) byId(id).addEventListener("input", () => this.draw());
    byId("sphere-bits").addEventListener("change", () => this.show());
    this.canvases = [...document.querySelectorAll(".sphere")];
    for (const canvas of this.canvases) this.followPointer(canvas);
    this.show();
  },

  async show() {
    const budget = data.spheres.budgets[byId("sphere-bits").value];
    this.maps = await Promise.all(budget.spheres.map((sphere) => plane(sphere.plane)));
    this.canvases.forEach((canvas, i) => {
      canvas.parentElement.querySelector("span").textContent = budget.spheres[i].caption;
    });
    byId("sphere-top").textContent = budget.top;
    this.drawScale();
    this.draw();
  },

  drawScale() {
    const canvas = byId("sphere-scale"), context = canvas.getContext("2d");
    data.spheres.palette.forEach((color, i) => {
      context.fillStyle = `rgb(${color})`;
      context.fillRect(i, 0, 1, canvas.height);
    });
  },

  // Columns: where the picture's right, up and front point in the frame of the normals.
  rotation() {
    const turn = byId("sphere-turn").value * Math.PI / 180, tilt = byId("sphere-tilt").value * Math.PI / 180;
    const [ct, st, ci, si] = [Math.cos(turn), Math.sin(turn), Math.cos(tilt), Math.sin(tilt)];
    return [[ct, 0, -st], [-si * st, ci, -si * ct], [ci * st, si, ci * ct]];
  },

  draw() {
    const [right, up, front] = this.rotation();
    this.canvases.forEach((canvas, i) => this.drawOne(canvas, this.maps[i], right, up, front));
  },

  drawOne(canvas, map, right, up, front) {
    const context = canvas.getContext("2d"), {width} = canvas, image = context.createImageData(width, width);
    for (let row = 0; row < width; ++row)
      for (let column = 0; column < width; ++column) {
        const x = (column + 0.5) / width * 2 - 1, y = 1 - (row + 0.5) / width * 2, rest = 1 - x * x - y * y;
        if (rest < 0) continue;
        const z = Math.sqrt(rest);
        const color = this.colorAt(map, right[0] * x + up[0] * y + front[0] * z, right[1] * x + up[1] * y + front[1] * z,
                                   right[2] * x + up[2] * y + front[2] * z);
        image.data.set([...color, 255], (row * width + column) * 4);
      }
    context.putImageData(image, 0, 0);
    this.drawAxes(context, right, up, front);
  },

  // Two equal-area discs side by side: src/study/picture.h.
  colorAt(map, x, y, z) {
    const {width, height, palette} = data.spheres, radius = height / 2 - 4, scale = radius / Math.sqrt(1 + Math.abs(z));
    const level = (shrink) => {
      const column = Math.floor((z < 0 ? height : 0) + height / 2 + x * scale * shrink);
      return map[Math.floor(height / 2 - y * scale * shrink) * width + column];
    };
    return palette[(level(1) || level(0.98)) - 1];
  },

  drawAxes(context, right, up, front) {
    const half = context.canvas.width / 2;
    context.font = "bold 14px sans-serif";
    context.textAlign = "center";
    context.textBaseline = "middle";
    ["X", "Y", "Z"].forEach((name, axis) => {
      for (const sign of [1, -1]) {
        if (sign * front[axis] < 0.1) continue;
        const place = [half + sign * right[axis] * half * 0.94, half - sign * up[axis] * half * 0.94];
        context.lineWidth = 3;
        context.strokeStyle = "#000";
        context.strokeText((sign > 0 ? "+" : "-") + name, ...place);
        context.fillStyle = "#fff";
        context.fillText((sign > 0 ? "+" : "-") + name, ...place);
      }
    });
  },

  followPointer(canvas) {
    canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
    canvas.addEventListener("pointermove", (event) => {
      if (!event.buttons) return;
      const turn = byId("sphere-turn"), tilt = byId("sphere-tilt");
      turn.value = (Number(turn.value) - event.movementX + 540) % 360 - 180;
      tilt.value = Number(tilt.value) + event.movementY;
      this.draw();
    });
  },
};

// --- commands -----------------------------------------------------------------------------------------------------------

function addCopyButton(command) {
  const code = command.querySelector("code"), button = element("button", "Copy", {type: "button"});
  button.setAttribute("aria-label", `Copy: ${code.textContent}`);
  button.addEventListener("click", async () => {
    try {
      await navigator.clipboard.writeText(code.textContent);
      button.textContent = "Copied";
    } catch {  // without that right the text is at least selected
      getSelection().selectAllChildren(code);
      button.textContent = "Selected";
    }
    setTimeout(() => { button.textContent = "Copy"; }, 2000);
  });
  command.append(button);
}

for (const command of document.querySelectorAll(".command")) addCopyButton(command);
if (byId("stage")) compare.start();
if (document.querySelector(".sphere")) spheres.start();
