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
  showList(list, [["pixel", `${probe.x}, ${probe.y}`], ["colour", probe.rgba.join("  ")], ...surfacePairs(probe.surface)]);
}

// The last pictures' milliseconds as a line, the newest at the right.
export class History {
  constructor(line, length = 120) {
    this.line = line;
    this.length = length;
    this.values = [];
  }
  add(milliseconds) {
    this.values = [...this.values, milliseconds].slice(-this.length);
    const most = Math.max(...this.values, 1);
    const x = (i) => 240 - (240 / (this.length - 1)) * (this.values.length - 1 - i);
    this.line.setAttribute("points", this.values.map((value, i) => `${x(i).toFixed(1)},${(46 - (44 * value) / most).toFixed(1)}`).join(" "));
  }
}

export function showPasses(body, passes) {
  const rows = passes.map(([name, milliseconds]) => {
    const row = document.createElement("tr");
    for (const text of [name, milliseconds.toFixed(3)]) row.insertCell().textContent = text;
    return row;
  });
  body.replaceChildren(...rows);
}
