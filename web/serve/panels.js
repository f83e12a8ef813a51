// What the session tells beside its pictures: values, names and times.

const figures = (value, digits = 5) => Number(value.toPrecision(digits)).toString();
const vector = (values) => values.map((value) => figures(value, 4)).join("  ");

// Pairs of a name and a text; those without a text are left out.
export function showList(list, pairs) {
  const cells = pairs
    .filter(([, text]) => text !== undefined && text !== "")
    .flatMap(([name, text]) => {
      const [term, value] = [document.createElement("dt"), document.createElement("dd")];
      term.textContent = name;
      value.textContent = text;
      return [term, value];
    });
  list.replaceChildren(...cells);
}

export function surfacePairs(surface) {
  if (!surface?.id) return [["surface", "background"]];
  return [
    ["node", surface.node],
    ["mesh", surface.mesh],
    ["primitive", String(surface.primitive)],
    ["material", surface.material],
    ["id", String(surface.id)],
    ["part", String(surface.part)],
    ["position", `${vector(surface.position)} m`],
    ["normal", vector(surface.normal)],
    ["geonormal", vector(surface.geonormal)],
    ["depth", `${figures(surface.depth)} m`],
    ["distance", `${figures(surface.distance)} m`],
    ["uv", vector(surface.uv)],
  ];
}

export function showProbe(list, probe) {
  if (!probe) return showList(list, []);
  showList(list, [["pixel", `${probe.x}, ${probe.y}`], ["color", probe.rgba.join("  ")], ...surfacePairs(probe.surface)]);
}

const SVG = "http://www.w3.org/2000/svg";

// The last pictures' milliseconds as a line, the newest at the right.
export class History {
  constructor(line, length = 120) {
    this.line = line;
    this.length = length;
    this.values = [];
  }
  add(milliseconds) {
    this.values = [...this.values, milliseconds].slice(-this.length);
    const most = Math.max(...this.values) || 1;
    const x = (i) => 240 - (240 / (this.length - 1)) * (this.values.length - 1 - i);
    this.line.setAttribute("points", this.values.map((value, i) => `${x(i).toFixed(1)},${(46 - (44 * value) / most).toFixed(1)}`).join(" "));
  }
}

// A row for each pass, with its last times as a line.
export class Passes {
  constructor(body) {
    Object.assign(this, { body, rows: new Map() });
  }
  show(passes) {
    const told = JSON.stringify(passes);
    if (told === this.told) return; // the same measurement: its picture was sent again
    this.told = told;
    this.body.replaceChildren(
      ...passes.map(([name, milliseconds]) => {
        if (!this.rows.has(name)) this.rows.set(name, this.row(name));
        const { row, time, history } = this.rows.get(name);
        time.textContent = milliseconds.toFixed(3);
        history.add(milliseconds);
        return row;
      }),
    );
  }
  row(name) {
    const row = document.createElement("tr");
    row.insertCell().textContent = name;
    const time = row.insertCell();
    const line = document.createElementNS(SVG, "polyline"), chart = document.createElementNS(SVG, "svg");
    for (const [key, value] of Object.entries({ viewBox: "0 0 240 48", preserveAspectRatio: "none", role: "img" }))
      chart.setAttribute(key, value);
    chart.setAttribute("aria-label", `Milliseconds of the last images, ${name}`);
    chart.append(line);
    row.insertCell().append(chart);
    return { row, time, history: new History(line) };
  }
}
