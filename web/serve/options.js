// A control for each option, made from the server's table.

const element = (name, properties = {}, ...children) => {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
};

// Each gives the elements to show, the one that the label names first, and how to read and write its text.
function flag() {
  const box = element("input", { type: "checkbox" });
  return { shown: [box], input: box, read: () => (box.checked ? "true" : ""), write: (text) => (box.checked = text === "true") };
}

function choice(option) {
  const list = element("select");
  for (const { name, help } of option.names) list.append(element("option", { value: name, textContent: name, title: help }));
  return { shown: [list], input: list, read: () => list.value, write: (text) => (list.value = text || option.default) };
}

function text(option) {
  const input = element("input", { type: "text", placeholder: option.default || option.without || "", spellcheck: false });
  const shown = [input];
  if (option.names.length) {
    const list = element("datalist", { id: `names-${option.key}` });
    for (const { name } of option.names) list.append(element("option", { value: name }));
    input.setAttribute("list", list.id);
    shown.push(list);
  }
  return { shown, input, read: () => input.value.trim(), write: (value) => (input.value = value) };
}

// With a slider where both ends are near enough to tell values apart.
function number(option) {
  const step = option.kind === "integer" ? 1 : "any";
  const limits = { min: option.least ?? "", max: option.most ?? "", step };
  const input = element("input", { type: "number", placeholder: option.default || option.without || "", ...limits });
  const field = { shown: [input], input, read: () => input.value, write: (value) => (input.value = value) };
  if (!(option.most - option.least <= 400)) return field;
  const slider = element("input", { type: "range", ...limits, step: step === 1 ? 1 : (option.most - option.least) / 400 });
  slider.setAttribute("aria-label", `${option.key}, slider`);
  slider.oninput = () => {
    input.value = slider.value;
    input.dispatchEvent(new Event("change"));
  };
  field.shown = [element("div", { className: "pair" }, slider, input)];
  field.write = (value) => {
    input.value = value;
    slider.value = value === "" ? option.default || option.least : value;
  };
  return field;
}

// A press takes the focus from another row, whose help then goes: not before it is let go of, or what was pressed would
// have moved away below the pointer.
const letGo = () => document.querySelectorAll(".row.held").forEach((row) => row.classList.remove("held"));
addEventListener("pointerdown", () => document.activeElement?.closest(".row")?.classList.add("held"));
for (const end of ["pointerup", "pointercancel"]) addEventListener(end, () => setTimeout(letGo)); // after the click

const KINDS = { flag, choice, text, integer: number, number };

export class Options {
  // `change(key, text)` is called for what people set; an empty text is the default.
  constructor(container, table, change) {
    this.fields = new Map();
    container.replaceChildren();
    for (const group of new Set(table.map((option) => option.group))) {
      const section = element("details", {}, element("summary", { textContent: group }));
      for (const option of table.filter((each) => each.group === group)) section.append(this.row(option, change));
      container.append(section);
    }
    this.container = container;
  }

  row(option, change) {
    const field = (KINDS[option.kind] ?? text)(option);
    field.input.id = `option-${option.key}`;
    field.input.addEventListener("change", () => change(option.key, field.read()));
    field.input.title = option.help + (option.unit ? ` (${option.unit})` : "");
    const label = element("label", { htmlFor: field.input.id, textContent: option.key });
    const row = element("div", { className: "row" }, label, ...field.shown);
    row.dataset.words = `${option.key} ${option.help} ${option.names.map((each) => each.name).join(" ")}`.toLowerCase();
    this.fields.set(option.key, { ...field, option, row });
    return row;
  }

  // Leaves alone what somebody is typing in.
  show(values) {
    for (const [key, field] of this.fields) {
      const value = values[key] ?? "";
      const chosen = field.option.names.find(({ name }) => name === (value || field.option.default));
      field.row.classList.toggle("changed", value !== "");
      field.row.dataset.help = field.input.title + (chosen?.help ? `. ${chosen.name}: ${chosen.help}` : "");
      if (document.activeElement !== field.input || field.input.tagName === "SELECT") field.write(value);
    }
  }

  find(words) {
    const wanted = words.toLowerCase().split(/\s+/).filter(Boolean);
    for (const section of this.container.children) {
      const rows = [...section.querySelectorAll(".row")];
      for (const row of rows) row.hidden = !wanted.every((word) => row.dataset.words.includes(word));
      section.hidden = rows.every((row) => row.hidden);
      if (wanted.length) section.open = true;
    }
  }
}
