// The viewer: what is shown, the keys, zoom and pan, and the view in the address.

const element = (id) => document.getElementById(id);
const screen = element("screen");
const context = screen.getContext("2d");

const state = {
  clip: 0, a: "", b: "", frame: 0, flipped: false, split: false, heat: false, holding: false,
  exposure: 0, zoom: 1, x: 0.5, y: 0.5, playing: false, fps: 60,
};
let pointer = null; // where the mouse is, in CSS px of the screen

const clip = () => data.clips[state.clip];

// ---- drawing

function prefetch() {
  for (const technique of clip().techniques) picture(state.clip, technique, state.frame, state.heat);
  if (!state.playing) return;
  for (const technique of [state.a, state.b]) clip().frames.forEach((_, i) => picture(state.clip, technique, i, state.heat));
}

function panels() { // [letter, technique, heat] of every picture on the screen
  const shown = state.holding ? [["", data.reference]]
    : state.split ? [["A", state.a], ["B", state.b]]
    : state.flipped ? [["B", state.b]] : [["A", state.a]];
  return shown.map(([letter, name]) => [letter, name, state.heat && name in clip().errors]);
}

function layout(count) { // of one panel: its width and height, the picture's size and its scale, in CSS px
  const [width, height] = clip().sizes[state.frame];
  const wide = screen.clientWidth / count, high = screen.clientHeight;
  return { wide, high, width, height, scale: Math.min(wide / width, high / height) * state.zoom };
}

let drawing = false;
function requestDraw() {
  if (drawing) return;
  drawing = true;
  requestAnimationFrame(() => { drawing = false; draw(); });
}

function draw() {
  if (!data.clips.length) return;
  const ratio = window.devicePixelRatio || 1;
  const [width, height] = clip().sizes.reduce((most, size) => (size[0] > most[0] ? size : most));
  const wanted = Math.min(window.innerHeight * 0.75, screen.clientWidth * height / width);
  screen.style.height = wanted + "px";
  const pixelWidth = Math.round(screen.clientWidth * ratio), pixelHeight = Math.round(wanted * ratio);
  if (screen.width !== pixelWidth || screen.height !== pixelHeight) {
    screen.width = pixelWidth;
    screen.height = pixelHeight;
  }
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, screen.clientWidth, wanted);
  context.imageSmoothingEnabled = false;
  const shown = panels();
  const at = layout(shown.length);
  shown.forEach(([letter, technique, heat], i) => {
    const canvas = develop(state.clip, technique, state.frame, heat, state.exposure);
    context.save();
    context.beginPath();
    context.rect(i * at.wide, 0, at.wide - (shown.length > 1 ? 1 : 0), at.high);
    context.clip();
    if (canvas) {
      context.drawImage(canvas, i * at.wide + at.wide / 2 - state.x * at.width * at.scale,
        at.high / 2 - state.y * at.height * at.scale, at.width * at.scale, at.height * at.scale);
    }
    const text = [letter, technique, heat ? "error" : ""].filter(Boolean).join("  ");
    context.font = "600 14px system-ui, sans-serif";
    context.fillStyle = "#000a";
    context.fillRect(i * at.wide + 6, 6, context.measureText(text).width + 12, 22);
    context.fillStyle = "#fff";
    context.fillText(text, i * at.wide + 12, 22);
    context.restore();
  });
  describe();
  prefetch();
}

function describe() {
  const exposure = state.exposure ? `exposure ${state.exposure > 0 ? "+" : ""}${state.exposure} EV` : "exposure 0 EV";
  element("status").textContent = [
    `frame ${clip().frames[state.frame]}`, exposure, `zoom ${state.zoom.toFixed(1)}x`,
    state.heat && !(panels()[0][1] in clip().errors) ? `${panels()[0][1]} has no error map: picture shown` : "",
  ].filter(Boolean).join(" · ");
  element("frame-number").textContent = clip().frames[state.frame];
  element("frame").value = state.frame;
  for (const [action, on] of Object.entries({ flip: state.flipped, split: state.split, heat: state.heat, play: state.playing })) {
    document.querySelector(`[data-action=${action}]`).classList.toggle("on", on);
  }
  readout();
}

function readout() { // pixel values under the pointer, of A, B and the reference
  if (!pointer) { element("readout").textContent = ""; return; }
  const at = layout(panels().length);
  const inside = pointer.x % at.wide;
  const column = Math.floor((inside - at.wide / 2) / at.scale + state.x * at.width);
  const row = Math.floor((pointer.y - at.high / 2) / at.scale + state.y * at.height);
  if (column < 0 || row < 0 || column >= at.width || row >= at.height) { element("readout").textContent = ""; return; }
  const [x0, y0] = clip().origin;
  const lines = [`pixel (${x0 + column}, ${y0 + row})`];
  const place = 4 * (row * at.width + column);
  for (const name of new Set([state.a, state.b, data.reference])) {
    const pixels = picture(state.clip, name, state.frame, false);
    if (!pixels) continue;
    const codes = Array.from(pixels.data.slice(place, place + 3));
    const values = codes.map((code) => (code === 255 ? "≥1.000" : decode(code).toFixed(3))).join(" ");
    const errors = picture(state.clip, name, state.frame, true);
    lines.push(`${name.padEnd(16)} radiance ${values}   sRGB ${codes.join(" ")}${errors ? errorText(errors.data[place]) : ""}`);
  }
  element("readout").textContent = lines.join("\n");
}

function errorText(code) {
  if (code === 0) return "   not wholly covered";
  const value = errorOf(code);
  const bound = Math.abs(value) >= data.error.range ? (value > 0 ? "≥" : "≤") : "";
  return `   error ${bound}${value >= 0 ? "+" : ""}${value.toFixed(3)}`;
}

function drawLegend() {
  const brush = element("legend").getContext("2d");
  for (let i = 0; i < 252; i++) {
    brush.fillStyle = `rgb(${diverging(i / 125.5 - 1)})`;
    brush.fillRect(i, 0, 1, 12);
  }
  const range = data.error.range;
  for (const text of [`≤ −${range}`, "0", `≥ +${range}`]) {
    element("legend-ticks").append(Object.assign(document.createElement("span"), { textContent: text }));
  }
  element("legend").title = "error map: test minus reference, linear radiance, mean of R, G, B; grey is not wholly covered";
}

// ---- the view in the address

function writeAddress() {
  const view = new URLSearchParams({
    clip: state.clip, a: state.a, b: state.b, frame: clip().frames[state.frame], flip: Number(state.flipped),
    split: Number(state.split), heat: Number(state.heat), ev: state.exposure,
    zoom: state.zoom.toFixed(2), x: state.x.toFixed(4), y: state.y.toFixed(4),
  });
  history.replaceState(null, "", "#" + view);
}

function readAddress() {
  const view = new URLSearchParams(location.hash.slice(1));
  const value = (key, low, high) => {
    const n = parseFloat(view.get(key));
    if (Number.isFinite(n)) state[key === "ev" ? "exposure" : key] = Math.min(high, Math.max(low, n));
  };
  value("clip", 0, data.clips.length - 1);
  state.clip = Math.floor(state.clip);
  chooseClip(state.clip);
  for (const key of ["a", "b"]) if (clip().techniques.includes(view.get(key))) state[key] = view.get(key);
  state.frame = Math.max(0, clip().frames.indexOf(Number(view.get("frame") ?? -1)));
  for (const [key, name] of [["flip", "flipped"], ["split", "split"], ["heat", "heat"]]) state[name] = view.get(key) === "1";
  value("ev", -8, 8);
  value("zoom", 1, 64);
  value("x", 0, 1);
  value("y", 0, 1);
  element("a").value = state.a;
  element("b").value = state.b;
}

function changed() {
  requestDraw();
  if (!state.playing) writeAddress();
}

// ---- choices and actions

function options(select, names) {
  select.replaceChildren(...names.map((name, i) => new Option(name, select.id === "clip" ? i : name)));
}

function chooseClip(index) {
  state.clip = index;
  const names = clip().techniques;
  if (!names.includes(state.a)) state.a = names.includes("tsl") ? "tsl" : names[0];
  if (!names.includes(state.b)) state.b = names.includes(data.reference) ? data.reference : names[names.length - 1];
  state.frame = Math.min(state.frame, clip().frames.length - 1);
  state.fps = clip().fps;
  options(element("a"), names);
  options(element("b"), names);
  element("clip").value = index;
  element("a").value = state.a;
  element("b").value = state.b;
  element("frame").max = clip().frames.length - 1;
  element("fps").value = state.fps;
}

const stepFrame = (step) => { state.frame = (state.frame + step + clip().frames.length) % clip().frames.length; };

const actions = {
  flip() { state.flipped = !state.flipped; },
  split() { state.split = !state.split; },
  heat() { state.heat = !state.heat; },
  previous() { stepFrame(-1); },
  next() { stepFrame(1); },
  worst() {
    const mse = clip().mse[state.a].map((value) => value ?? -1);
    state.frame = mse.indexOf(Math.max(...mse));
  },
  brighter() { state.exposure = Math.min(8, state.exposure + 0.5); },
  darker() { state.exposure = Math.max(-8, state.exposure - 0.5); },
  reset() { Object.assign(state, { exposure: 0, zoom: 1, x: 0.5, y: 0.5 }); },
  help() { element("help").showModal(); },
  play() {
    state.playing = !state.playing;
    let shownAt = performance.now();
    const tick = (now) => {
      if (!state.playing) return;
      const due = Math.floor((now - shownAt) / 1000 * state.fps + 0.1);
      if (due > 0) {
        stepFrame(due % clip().frames.length);
        shownAt += due / state.fps * 1000;
        requestDraw();
      }
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  },
};

const KEYS = {
  " ": "flip", s: "split", h: "heat", ArrowLeft: "previous", ArrowRight: "next", w: "worst", p: "play",
  "+": "brighter", "=": "brighter", "-": "darker", 0: "reset", "?": "help",
};

function onKey(event) {
  const at = event.target.tagName;
  if (event.ctrlKey || event.metaKey || event.altKey || element("help").open || at === "SELECT") return;
  if (at === "INPUT" && (event.target.type === "number" || event.key.startsWith("Arrow"))) return;
  if ((at === "BUTTON" || at === "SUMMARY") && event.key === " ") return;
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  const technique = clip().techniques[Number(key) - 1];
  if (key === "r") state.holding = clip().techniques.includes(data.reference);
  else if (/^[1-9]$/.test(key) && technique) { state.a = technique; element("a").value = technique; state.flipped = false; }
  else if (key in KEYS) actions[KEYS[key]]();
  else return;
  event.preventDefault();
  changed();
}

function zoomAt(x, y, factor) { // keep what lies under (x, y) where it is
  const before = layout(panels().length);
  const dx = x % before.wide - before.wide / 2, dy = y - before.high / 2;
  state.zoom = Math.min(64, Math.max(1, state.zoom * factor));
  const after = layout(panels().length);
  pan(dx * (1 / after.scale - 1 / before.scale), dy * (1 / after.scale - 1 / before.scale), after);
}

function pan(dx, dy, at) { // by picture px
  state.x = Math.min(1, Math.max(0, state.x - dx / at.width));
  state.y = Math.min(1, Math.max(0, state.y - dy / at.height));
  changed();
}

const touching = new Map(); // pointers that are down: id -> place
function onPointer(event) {
  const box = screen.getBoundingClientRect();
  const here = { x: event.clientX - box.left, y: event.clientY - box.top };
  pointer = here;
  const before = touching.get(event.pointerId);
  if (before && touching.size === 1) {
    const at = layout(panels().length);
    pan((here.x - before.x) / at.scale, (here.y - before.y) / at.scale, at);
  } else if (before) {
    const other = [...touching].find(([id]) => id !== event.pointerId)[1];
    const apart = (p) => Math.hypot(p.x - other.x, p.y - other.y) || 1;
    zoomAt((here.x + other.x) / 2, (here.y + other.y) / 2, apart(here) / apart(before));
  }
  if (before) touching.set(event.pointerId, here);
  requestDraw();
}

function listen() {
  element("clip").onchange = (event) => { chooseClip(Number(event.target.value)); changed(); };
  for (const key of ["a", "b"]) {
    element(key).onchange = (event) => { state[key] = event.target.value; state.flipped = key === "b"; changed(); };
  }
  element("frame").oninput = (event) => { state.frame = Number(event.target.value); changed(); };
  element("fps").onchange = (event) => { state.fps = Math.max(1, Number(event.target.value) || clip().fps); };
  for (const button of document.querySelectorAll("[data-action]")) {
    button.onclick = (event) => {
      actions[button.dataset.action]();
      if (event.detail > 0) button.blur(); // after a click of the mouse, space is for flipping again
      changed();
    };
  }
  document.addEventListener("decoded", requestDraw);
  document.addEventListener("keydown", onKey);
  document.addEventListener("keyup", (event) => { if (event.key.toLowerCase() === "r") { state.holding = false; requestDraw(); } });
  window.addEventListener("blur", () => { state.holding = false; requestDraw(); });
  window.addEventListener("resize", requestDraw);
  window.addEventListener("hashchange", () => { readAddress(); requestDraw(); });
  screen.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoomAt(event.offsetX, event.offsetY, 2 ** (-Math.sign(event.deltaY) / 4));
  }, { passive: false });
  screen.addEventListener("pointerdown", (event) => {
    screen.setPointerCapture(event.pointerId);
    touching.set(event.pointerId, { x: event.offsetX, y: event.offsetY });
  });
  screen.addEventListener("pointermove", onPointer);
  for (const name of ["pointerup", "pointercancel"]) screen.addEventListener(name, (event) => touching.delete(event.pointerId));
  screen.addEventListener("pointerleave", () => { pointer = null; requestDraw(); });
}

if (data.clips.length) {
  options(element("clip"), data.clips.map((item) => item.name));
  drawLegend();
  readAddress();
  listen();
  draw();
} else {
  element("viewer").hidden = true;
}
