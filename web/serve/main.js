// Latelight in a browser: the session's pictures, and controls for all that it takes.

import { Connection } from "./connection.js";
import { Handles, Sun } from "./lights.js";
import { Options } from "./options.js";
import { History, Passes, showList, showProbe, surfacePairs } from "./panels.js";
import { Stage } from "./stage.js";

const $ = (id) => document.getElementById(id);
const state = {};
let tables = null;
let options = null;
const sent = new Map(); // when each message left, until a picture follows it
let optionSent = 0; // the serial number of the last option that was set here; what is told before it is older
let followed = 0;
let lost = null; // what a session showed whose connection was lost, until the next one has followed all of it
let restored = 0; // the serial number of the last message that restores it
const history = new History($("history").querySelector("polyline"));
const passes = new Passes($("passes"));

const connection = new Connection({
  tables: begin,
  state: (changed) => {
    Object.assign(state, changed);
    show(changed);
  },
  followed: (serial) => {
    const waited = followed < optionSent;
    followed = serial;
    if (serial >= restored) lost = null;
    if (waited) showOptions();
  },
  picture: showPicture,
  screenshot: download,
  failed: (sentence) => {
    $("saved").textContent = ""; // it may have been a screenshot
    say(sentence);
  },
  busy: (is) => $("stage").setAttribute("aria-busy", is),
  status: (text, mayRetry) => {
    $("status").textContent = text;
    $("retry").hidden = !mayRetry;
    $("waiting").hidden = true;
  },
});
const stage = new Stage($("picture"), connection);
const send = (type, fields) => {
  const serial = connection.send(type, fields);
  if (serial) sent.set(serial, performance.now());
  return serial;
};
const setOption = (name, value) => (optionSent = send("option", { name, value, side: side() }));
const sun = new Sun((value) => setOption("sun", value));
const handles = new Handles(
  $("handles"),
  () => stage.size,
  (light, x, y) => send("dragLight", { light, x, y }),
  (light, dx, dy) => send("nudgeLight", { light, dx, dy }),
);
let sentFile = null; // the environment that was sent from here
// The name of an environment that was sent: the server reserves that of its --hdri.
const sentName = ({ name }) => (tables.environments.includes(name) ? `sent-${name}` : name);
const side = () => (state.split?.mode !== "off" && document.querySelector("[name=side]:checked").value) || "left";

// --- a session begins; after a lost connection it is told what the last one showed ---

function begin(told) {
  tables = told;
  $("status").textContent = "Connected";
  $("retry").hidden = true;
  options = new Options($("options"), tables.options, setOption);
  stage.resize();
  if (state.left) {
    lost ??= structuredClone(state);
    restored = restore(lost) || Infinity; // 0: this connection is lost already, too
  }
}

// Sends every option, because the new session begins with those of the command line, and its right side with those of
// the left one. The session rejects an option that conflicts with an option, the environment or the camera that is
// replaced only later, so the second pass sets those that the first one could not.
function restore(last) {
  const tell = (which) => {
    const { options, output } = last[which];
    for (const { key } of tables.options) send("option", { name: key, value: options[key] ?? "", side: which });
    send("output", { name: output, side: which });
  };
  const tellBoth = () => {
    tell("left");
    if (last.split.mode !== "off") send("split", last.split), tell("right");
  };
  tellBoth();
  if (last.variants.length) send("variant", { name: last.variant });
  send("camera", { name: last.camera });
  if (sentFile && sentName(sentFile) === last.environment) sendEnvironment(sentFile).then(tellBoth);
  else send("environment", { name: last.environment });
  tellBoth();
  if ($("lights").getAttribute("aria-pressed") === "true") send("lights", { on: true });
  return send("navigation", { mode: last.navigation });
}

// --- what the session says ---

async function showPicture(picture, payload, serial) {
  await stage.draw(picture, payload);
  $("waiting").hidden = true;
  history.add(picture.milliseconds);
  const answered = sent.get(serial);
  for (const each of [...sent.keys()]) if (each <= serial) sent.delete(each);
  showList($("times"), [
    ["picture", `${picture.milliseconds.toFixed(1)} ms`],
    ["encoding", `${picture.encoding.toFixed(1)} ms`],
    ["until shown", answered && `${(performance.now() - answered).toFixed(0)} ms`],
    ["pixels", `${picture.width} × ${picture.height}${picture.final ? "" : ", draft"}`],
    ["sent", `${(payload.length / 1000).toFixed(0)} kB, quality ${picture.quality}`],
    ["G-buffer", `${state.bytesPerPixel} bytes per pixel`],
  ]);
  if (picture.final) passes.show(picture.passes);
}

const shows = {
  scene: () => {
    $("scene").textContent = state.scene;
    document.title = `${state.scene} · Latelight`;
  },
  device: () => ($("status").textContent = state.device),
  error: () => {
    $("error").textContent = state.error;
    $("error").hidden = !state.error;
    if (state.error) $("waiting").hidden = true;
  },
  left: showSide,
  right: showSide,
  targets: showOutputs,
  split: showSplit,
  environment: showEnvironment,
  variants: showVariants,
  variant: showVariants,
  lights: () => handles.show(state.lights),
  cameras: showCameras,
  cameraIndex: showCameras,
  steered: showCameras,
  navigation: () => ($("navigation").value = state.navigation),
  animations: showTime,
  duration: showTime,
  time: showTime,
  playing: showTime,
  crosshair: () => {
    $("crosshair").hidden = !state.crosshair;
    if (!state.crosshair) return;
    const [x, y] = state.crosshair, { width, height } = stage.size;
    $("crosshair").style.left = `${(100 * (x + 0.5)) / width}%`;
    $("crosshair").style.top = `${(100 * (y + 0.5)) / height}%`;
  },
  probe: () => showProbe($("probe"), state.probe),
  selected: () => {
    $("selection").hidden = !state.selected;
    if (state.selected) showList($("selected"), surfacePairs(state.selected));
  },
  leftCommand: showCommand,
  rightCommand: showCommand,
  lightsMoved: () => ($("command-note").hidden = !state.lightsMoved),
};

function show(changed) {
  for (const act of new Set(Object.keys(changed).map((key) => shows[key]))) act?.();
}

function fill(list, pairs) {
  const before = list.value;
  list.replaceChildren(...pairs.map(([value, text]) => new Option(text, value)));
  list.value = before;
}

function showOutputs() {
  const targets = state.targets.map((name) => [`target:${name}`, `target ${name}`]);
  fill($("output"), [...tables.outputs.map(({ name }) => [name, name]), ...targets]);
  $("output").value = state[side()].output;
}

function showEnvironment() {
  const sent = sentFile ? [[sentName(sentFile), `${sentFile.name} (sent)`]] : [];
  fill($("environment"), [...tables.environments.map((name) => [name, name || "the scene's"]), ...sent]);
  $("environment").value = state.environment;
}

function showVariants() {
  $("variant-row").hidden = !state.variants.length;
  fill($("variant"), ["", ...state.variants].map((name) => [name, name || "the default"]));
  $("variant").value = state.variant;
}

// Not while one that was set here is pending: the control would jump back and forth.
function showOptions() {
  if (followed < optionSent) return;
  options.show(state[side()].options);
  sun.show(state[side()].options.sun ?? "");
}

function showSide() {
  showOptions();
  showOutputs();
  showCommand();
}

function showSplit() {
  const { mode, at, amplification } = state.split;
  $("split").value = mode;
  $("side").hidden = mode === "off";
  $("amplification-row").hidden = mode !== "difference";
  if (document.activeElement !== $("amplification")) $("amplification").value = amplification;
  $("divider").hidden = mode !== "slider";
  $("divider").style.left = `${100 * at}%`;
  $("divider").setAttribute("aria-valuenow", Math.round(100 * at));
  showSide();
}

function showCameras() {
  // Names may be empty, numbers or equal, so indices select the cameras.
  const isUnique = (name) => state.cameras.indexOf(name) === state.cameras.lastIndexOf(name);
  const label = (name, i) => (!name ? `camera ${i}` : isUnique(name) ? name : `${name} (#${i})`);
  const own = state.cameras.map((name, i) => [`#${i}`, label(name, i)]);
  const begins = state.cameras.length ? "the scene's first" : "whole scene";
  fill($("camera"), [...(state.steered ? [["*", "moved by hand"]] : []), ["", begins], ...own]);
  $("camera").value = state.steered ? "*" : state.cameraIndex === null ? "" : `#${state.cameraIndex}`;
}

function showTime() {
  $("timeline").hidden = !state.animations?.length;
  $("play").setAttribute("aria-pressed", state.playing);
  $("play").textContent = state.playing ? "Pause" : "Play";
  $("time").max = state.duration;
  if (document.activeElement !== $("time") || state.playing) $("time").value = state.time ?? 0;
  $("time-text").textContent = state.time === null ? "at rest" : `${state.time.toFixed(2)} s`;
}

function showCommand() {
  $("command").textContent = side() === "right" ? state.rightCommand : state.leftCommand;
}

function download(bytes) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([bytes], { type: "image/png" }));
  link.download = "picture.png";
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  $("saved").textContent = "The image was downloaded.";
}

// --- what people do ---

$("retry").onclick = () => {
  connection.attempts = 0;
  connection.open();
};
$("output").onchange = () => send("output", { name: $("output").value, side: side() });
$("camera").onchange = () => $("camera").value !== "*" && send("camera", { name: $("camera").value });
$("environment").onchange = () => {
  if (sentFile && sentName(sentFile) === $("environment").value) sendEnvironment(sentFile);
  else send("environment", { name: $("environment").value });
};
$("variant").onchange = () => send("variant", { name: $("variant").value });
$("lights").onclick = () => {
  const on = $("lights").getAttribute("aria-pressed") !== "true";
  $("lights").setAttribute("aria-pressed", on);
  send("lights", { on });
};
$("send-environment").onclick = () => $("environment-file").click();
$("environment-file").onchange = () => {
  const [file] = $("environment-file").files;
  if (file) sendEnvironment(file);
  $("environment-file").value = ""; // the same one may be chosen again
};
$("stage").ondragover = (event) => event.preventDefault();
$("stage").ondrop = (event) => {
  event.preventDefault();
  const [file] = event.dataTransfer.files;
  if (file) sendEnvironment(file);
};

// What the server would close the connection for is said here.
async function sendEnvironment(file) {
  const { most, piece } = tables.file;
  if (!/\.(hdr|exr)$/i.test(file.name)) return say(`${file.name} is not a .hdr or .exr file`);
  if (file.size === 0 || file.size > most) return say(`${file.name} has ${file.size} bytes; 1 to ${most} can be sent`);
  const bytes = await file.arrayBuffer();
  sentFile = file;
  send("file", { name: file.name, bytes: bytes.byteLength });
  for (let at = 0; at < bytes.byteLength; at += piece) connection.socket.send(bytes.slice(at, at + piece));
}

function say(sentence) {
  $("error").textContent = sentence;
  $("error").hidden = false;
}
$("navigation").onchange = () => send("navigation", { mode: $("navigation").value });
$("frame").onclick = () => send("key", { name: "Home", down: true });
$("reload").onclick = () => send("reload");
$("split").onchange = () => send("split", { ...state.split, mode: $("split").value });
$("amplification").onchange = () => send("split", { ...state.split, amplification: Number($("amplification").value) || 1 });
$("side").onchange = showSide;
$("find").oninput = () => options?.find($("find").value);
$("play").onclick = () => send("play", { on: !state.playing });
$("time").oninput = () => {
  for (const each of ["left", "right"]) send("option", { name: "time", value: $("time").value, side: each });
};
$("screenshot").onclick = () => {
  $("saved").textContent = "Rendering";
  send("screenshot", { side: side() });
};
$("copy").onclick = async () => {
  try {
    await navigator.clipboard.writeText($("command").textContent);
    $("saved").textContent = "The command was copied.";
  } catch {
    getSelection().selectAllChildren($("command"));
    $("saved").textContent = "The browser denied access to the clipboard; the command is selected.";
  }
};

function moveDivider(wanted) {
  const at = Math.min(Math.max(wanted, 0), 1);
  $("divider").style.left = `${100 * at}%`; // at once, before the picture
  send("split", { ...state.split, at });
}
$("divider").onpointerdown = (event) => $("divider").setPointerCapture(event.pointerId);
$("divider").onpointermove = (event) => {
  if (!$("divider").hasPointerCapture(event.pointerId)) return;
  const box = $("picture").getBoundingClientRect();
  moveDivider((event.clientX - box.left) / box.width);
};
$("divider").onkeydown = (event) => {
  const step = { ArrowLeft: -0.02, ArrowRight: 0.02 }[event.key];
  if (!step) return;
  event.preventDefault();
  moveDivider(state.split.at + step);
};

function showPanel(open) {
  document.body.classList.toggle("without-panel", !open);
  $("panel-toggle").setAttribute("aria-expanded", open);
}
$("panel-toggle").onclick = () => showPanel(document.body.classList.contains("without-panel"));
showPanel(!matchMedia("(max-width: 720px)").matches);

$("waiting").hidden = false;
connection.open();
