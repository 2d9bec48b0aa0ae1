// The view: what is shown and how, and the same in the address.

const element = (id) => document.getElementById(id);
const screen = element("screen");

const state = {
  clip: 0, a: "", b: "", frame: 0, flipped: false, split: false, heat: 0, holding: false,
  exposure: 0, tone: "none", zoom: 1, x: 0.5, y: 0.5, playing: false, fps: 60, message: "",
};

const clip = () => data.clips[state.clip];
const hasReference = () => clip().techniques.includes(data.reference);

function panels() { // [letter, technique, heat] of every picture on the screen
  const shown = state.holding ? [["", data.reference]]
    : state.split ? [["A", state.a], ["B", state.b]]
    : state.flipped ? [["B", state.b]] : [["A", state.a]];
  return shown.map(([letter, name]) => [letter, name, clip().compared.includes(name) ? state.heat : 0]);
}

// Of one panel: its width, height and the place of panel i, the picture's size and its scale, in CSS px.
function layout() {
  const count = panels().length;
  const across = screen.clientWidth < 640 ? 1 : count, down = count / across;
  const [width, height] = clip().sizes[state.frame];
  const wide = screen.clientWidth / across, high = screen.clientHeight / down;
  const fit = Math.min(wide / width, high / height);
  const place = (i) => [(i % across) * wide, Math.floor(i / across) * high];
  return { wide, high, down, place, width, height, fit, scale: fit * state.zoom };
}

const largestZoom = () => Math.max(64, 96 / layout().fit); // pixels large enough to write in

function pixelAt(point) { // [column, row] of the picture under a point of the screen, or null
  const at = layout();
  const column = Math.floor((point.x % at.wide - at.wide / 2) / at.scale + state.x * at.width);
  const row = Math.floor((point.y % at.high - at.high / 2) / at.scale + state.y * at.height);
  return column < 0 || row < 0 || column >= at.width || row >= at.height ? null : [column, row];
}

// ---- choices

function options(select, names) {
  select.replaceChildren(...names.map((name, i) => new Option(name, select.id === "clip" ? i : name)));
}

function chooseClip(index) {
  state.clip = index;
  const names = clip().techniques;
  if (!names.includes(state.a)) state.a = [data.pick, "tsl", names[0]].find((name) => names.includes(name));
  if (!names.includes(state.b)) state.b = hasReference() ? data.reference : names[names.length - 1];
  state.frame = Math.min(state.frame, clip().frames.length - 1);
  state.fps = clip().fps;
  options(element("a"), names);
  options(element("b"), names);
  element("frame").max = clip().frames.length - 1;
  document.querySelector("[data-hold]").disabled = !hasReference();
  document.querySelector("[data-action=heat]").disabled = !clip().compared.length;
}

function chooseTechnique(letter, technique) {
  state[letter] = technique;
  state.flipped = letter === "b";
}

// ---- the address

let writing = 0;
function writeAddress() { // at rest: browsers object to pages that change their address many times a second
  clearTimeout(writing);
  writing = setTimeout(() => {
    const view = new URLSearchParams({
      clip: state.clip, a: state.a, b: state.b, frame: clip().frames[state.frame], flip: Number(state.flipped),
      split: Number(state.split), heat: state.heat, ev: state.exposure, tone: state.tone,
      zoom: state.zoom.toFixed(2), x: state.x.toFixed(4), y: state.y.toFixed(4), fps: state.fps,
    });
    history.replaceState(null, "", "#" + view);
  }, 150);
}

function readAddress() {
  const view = new URLSearchParams(location.hash.slice(1));
  const value = (key, low, high, name = key) => {
    const n = parseFloat(view.get(key));
    if (Number.isFinite(n)) state[name] = Math.min(high, Math.max(low, n));
  };
  if (!view.has("clip") && !state.a) Object.assign(state, { clip: data.first, tone: data.clips[data.first].tone });
  value("clip", 0, data.clips.length - 1);
  chooseClip(Math.floor(state.clip));
  for (const key of ["a", "b"]) if (clip().techniques.includes(view.get(key))) state[key] = view.get(key);
  state.frame = Math.max(0, clip().frames.indexOf(Number(view.get("frame") ?? -1)));
  state.flipped = view.get("flip") === "1";
  state.split = view.get("split") === "1";
  state.heat = Math.max(0, ["0", "1", "2"].indexOf(view.get("heat")));
  value("ev", -8, 8, "exposure");
  if (view.get("tone") in TONES) state.tone = view.get("tone");
  value("zoom", 1, largestZoom());
  value("x", 0, 1);
  value("y", 0, 1);
  value("fps", 1, 240);
}
