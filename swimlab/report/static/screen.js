// Drawing: the pictures, numbers within large pixels, the values under the pointer, and what the view is.

const context = screen.getContext("2d");
const READABLE = 40; // CSS px of a pixel from which on its values are written into it
const HEAT_NAMES = ["", "error over grey", "error"];
let pointer = null; // where the mouse is, or a finger was, in CSS px of the screen

let drawing = false;
function requestDraw() {
  if (drawing) return;
  drawing = true;
  requestAnimationFrame(() => { drawing = false; draw(); });
}

function draw() {
  showBeside();
  fitScreen();
  drawBeside();
  context.imageSmoothingEnabled = false;
  panels().forEach(([letter, technique, heat], i) => drawPanel(i, letter, technique, heat));
  describe();
  readout();
  prefetch();
}

function fitScreen() {
  const ratio = window.devicePixelRatio || 1;
  const [width, height] = clip().sizes.reduce((most, size) => (size[0] > most[0] ? size : most));
  const wanted = Math.min(window.innerHeight * 0.75, screen.clientWidth * height / width * layout().down);
  screen.style.height = wanted + "px";
  screen.style.touchAction = state.zoom > 1 ? "none" : "pan-y"; // a finger scrolls the page past a whole picture
  const pixelWidth = Math.round(screen.clientWidth * ratio), pixelHeight = Math.round(wanted * ratio);
  if (screen.width !== pixelWidth || screen.height !== pixelHeight) {
    screen.width = pixelWidth;
    screen.height = pixelHeight;
  }
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, screen.clientWidth, wanted);
}

function drawPanel(i, letter, technique, heat) {
  const at = layout();
  const [left, top] = at.place(i);
  const canvas = develop(state.clip, technique, state.frame, heat, state.exposure, state.tone);
  context.save();
  context.beginPath();
  const gap = panels().length > 1 ? 1 : 0;
  context.rect(left, top, at.wide - gap, at.high - gap);
  context.clip();
  const x = left + at.wide / 2 - state.x * at.width * at.scale, y = top + at.high / 2 - state.y * at.height * at.scale;
  if (canvas) {
    context.drawImage(canvas, x, y, at.width * at.scale, at.height * at.scale);
    if (at.scale >= READABLE) drawNumbers(at, technique, heat, x, y);
    outlineDetail(at, x, y);
    markPixel(at, x, y);
  }
  const lost = !canvas && [false, true].some((map) => failed.has(keyOf(state.clip, technique, state.frame, map)));
  label(context, [letter, technique, HEAT_NAMES[heat], lost ? "cannot be loaded" : canvas ? "" : "loading…"], left, top);
  context.restore();
}

function label(brush, parts, left, top) {
  const text = parts.filter(Boolean).join("  ");
  brush.font = "600 14px system-ui, sans-serif";
  brush.textAlign = "left";
  brush.textBaseline = "alphabetic";
  brush.fillStyle = "#000a";
  brush.fillRect(left + 6, top + 6, brush.measureText(text).width + 12, 22);
  brush.fillStyle = "#fff";
  brush.fillText(text, left + 12, top + 22);
}

function outlineDetail(at, x, y) {
  const detail = detailBeside();
  if (!detail) return;
  const [left, top, width, height] = detail.region.map((px) => px / clip().shrunk * at.scale);
  context.lineWidth = 2;
  context.strokeStyle = "#ffaa00";
  context.strokeRect(x + left, y + top, width, height);
}

function markPixel(at, x, y) { // the same pixel in every panel
  const pixel = pointer && at.scale >= 4 ? pixelAt(pointer) : null;
  if (!pixel) return;
  const edge = [x + pixel[0] * at.scale, y + pixel[1] * at.scale, at.scale, at.scale];
  context.lineWidth = 3;
  context.strokeStyle = "#000";
  context.strokeRect(...edge);
  context.lineWidth = 1;
  context.strokeStyle = "#fff";
  context.strokeRect(...edge);
}

function drawNumbers(at, technique, heat, x, y) { // radiance R, G, B, or the error
  const values = picture(state.clip, technique, state.frame, heat > 0);
  if (!values) return;
  const size = Math.min(15, at.scale / 4.2);
  context.font = `${size}px ui-monospace, monospace`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  const table = developed(state.clip, state.exposure, state.tone);
  const isBright = (code) => (heat === HEAT_ALONE ? Math.abs(errorOf(code)) < 0.6 * data.error.range
    : heat === 0 && table[code] > 137); // sRGB of a quarter
  const range = (start, end, count) => [Math.max(0, Math.floor(start)), Math.min(count, Math.ceil(end))];
  const [first, last] = range(-x / at.scale, (screen.clientWidth - x) / at.scale, at.width);
  const [upper, lower] = range(-y / at.scale, (screen.clientHeight - y) / at.scale, at.height);
  for (let row = upper; row < lower; row++) {
    for (let column = first; column < last; column++) {
      const place = 4 * (row * at.width + column);
      const lines = heat ? [errorText(values.data[place])]
        : [0, 1, 2].map((c) => radianceText(values.data[place + c]));
      context.fillStyle = isBright(values.data[place + 1]) ? "#000" : "#fff";
      lines.forEach((line, i) => context.fillText(line,
        x + (column + 0.5) * at.scale, y + (row + 0.5) * at.scale + (i - (lines.length - 1) / 2) * 1.15 * size));
    }
  }
}

// ---- words

function radianceText(code) { // of the pictures of this clip
  const radiance = radianceOf(state.clip)[code];
  return code === 255 ? `≥${radiance.toPrecision(3).replace(/\.0*$/, "")}` : radiance.toFixed(radiance < 10 ? 3 : 0);
}

function errorText(code) {
  if (code === 0) return "–";
  const value = errorOf(code);
  const bound = Math.abs(value) >= data.error.range ? (value > 0 ? "≥" : "≤") : "";
  return `${bound}${value >= 0 ? "+" : "−"}${Math.abs(value).toFixed(3)}`;
}

function describe() {
  const shown = panels()[0][1];
  element("status").textContent = [
    `frame ${clip().frames[state.frame]}`,
    `exposure ${state.exposure > 0 ? "+" : ""}${state.exposure} EV`,
    `zoom ${state.zoom.toFixed(1)}x`,
    state.playing ? `playing at ${state.fps} fps` : "",
    state.heat && !clip().compared.includes(shown) ? `${shown} has no error map: picture shown` : "",
    state.message,
  ].filter(Boolean).join(" · ");
  element("frame-number").textContent = clip().frames[state.frame];
  for (const [id, key] of [["clip", "clip"], ["a", "a"], ["b", "b"], ["frame", "frame"], ["fps", "fps"], ["tone", "tone"]]) {
    if (document.activeElement !== element(id) || id !== "fps") element(id).value = state[key];
  }
  const pressed = { flip: state.flipped, split: state.split, heat: state.heat > 0, play: state.playing };
  for (const [action, on] of Object.entries(pressed)) {
    const button = document.querySelector(`[data-action=${action}]`);
    button.classList.toggle("on", on);
    button.setAttribute("aria-pressed", on);
  }
  drawLegend();
}

function readout() { // values of the pixel under the pointer, of A, B and the reference
  const pixel = pointer && pixelAt(pointer);
  element("readout").textContent = pixel ? pixelLines(...pixel).join("\n") : "";
}

function pixelLines(column, row) {
  const [x0, y0] = clip().region ?? [0, 0], by = clip().shrunk;
  const place = 4 * (row * layout().width + column);
  const lines = [`pixel (${x0 + by * column}, ${y0 + by * row})` + (by > 1 ? `, mean of ${by}x${by}` : "")];
  for (const name of new Set([state.a, state.b, data.reference])) {
    const pixels = picture(state.clip, name, state.frame, false);
    if (!pixels) continue;
    const codes = Array.from(pixels.data.slice(place, place + 3));
    const errors = picture(state.clip, name, state.frame, true);
    lines.push([
      name.padEnd(16), `radiance ${codes.map(radianceText).join(" ")}`,
      `sRGB ${codes.map((code) => encode(radianceOf(state.clip)[code])).join(" ")}`,
      errors ? `error ${errorText(errors.data[place])}` : "",
    ].join("  ").trimEnd());
  }
  return lines;
}

function drawLegend() { // the colours of the error map as it is shown, over a middle grey where it lies over a picture
  element("legend-box").hidden = !state.heat;
  element("uncovered").textContent = state.heat === HEAT_ALONE ? "grey" : "left grey";
  if (!state.heat) return;
  const canvas = element("legend"), brush = canvas.getContext("2d");
  const grey = DIMMED * 128;
  for (let i = 0; i < canvas.width; i++) {
    const [red, green, blue, opacity] = errorColour(2 * i / (canvas.width - 1) - 1, state.heat);
    brush.fillStyle = `rgb(${[red, green, blue].map((channel) => Math.round(grey + opacity * (channel - grey)))})`;
    brush.fillRect(i, 0, 1, canvas.height);
  }
}

// ---- ahead of need

function prefetch() { // what is likely to be wanted next, soonest first, within a quarter of the memory
  const count = clip().frames.length;
  const wanted = [state.a, state.b, data.reference].map((name) => [name, state.frame]);
  const ahead = state.playing ? clip().frames.map((_, i) => i) : [1, count - 1];
  for (const step of ahead) for (const name of [state.a, state.b]) wanted.push([name, (state.frame + step) % count]);
  if (!state.playing) for (const name of clip().techniques) wanted.push([name, state.frame]);
  for (const [name, index] of wanted.slice(0, KEPT_BYTES / 4 / largest / (state.heat ? 2 : 1))) {
    if (state.heat !== HEAT_ALONE) picture(state.clip, name, index, false);
    if (state.heat) picture(state.clip, name, index, true);
  }
}
