// What can be done: actions, the keys for them, playing, and the start.

const PAN = 48; // CSS px

function stepFrame(step) {
  state.frame = (state.frame + step + clip().frames.length) % clip().frames.length;
  if (clip().frames.length === 1) state.message = "this clip has one frame; choose another to see motion";
}

function stepTechnique(letter, step) {
  const names = clip().techniques;
  chooseTechnique(letter, names[(names.indexOf(state[letter]) + step + names.length) % names.length]);
}

function moveView(dx, dy) {
  const { scale } = layout();
  pan(dx * PAN / scale, dy * PAN / scale);
}

function worstIn(clips) { // [clip, frame] where A errs most, by place, or changes most without a reference
  let most = null, largest = -1;
  for (const i of clips) {
    (data.clips[i].squared[state.a] ?? []).forEach((squared, frame) => {
      if (squared !== null && squared > largest) [most, largest] = [[i, frame], squared];
    });
  }
  return most;
}

function goToWorst(clips) {
  const found = worstIn(clips);
  if (!found) {
    state.message = `the ${clip().is} of ${state.a} by frame is not known here`;
    return;
  }
  if (found[0] !== state.clip) chooseClip(found[0]);
  state.frame = found[1];
  state.flipped = false;
  const here = clip().frames[state.frame], worst = clip().worst[state.a];
  const rms = Math.sqrt(clip().squared[state.a][state.frame]).toPrecision(3);
  state.message = `${state.a}: rms ${clip().is} ${rms}, ` +
    (here === worst ? "its worst frame" : `the worst in here; its worst of all is frame ${worst}`);
}

const actions = {
  flip() { state.flipped = !state.flipped; },
  split() { state.split = !state.split; },
  heat() { state.heat = clip().compared.length ? (state.heat + 1) % 3 : 0; },
  previous() { stepFrame(-1); },
  next() { stepFrame(1); },
  worst() { goToWorst([state.clip]); },
  worstOfAll() {
    const others = data.clips.flatMap((item, i) => (item.sequence === clip().sequence && i !== state.clip ? [i] : []));
    goToWorst([state.clip, ...others]);
  },
  brighter() { state.exposure = Math.min(8, state.exposure + 0.5); },
  darker() { state.exposure = Math.max(-8, state.exposure - 0.5); },
  closer() { zoomMiddle(2 ** 0.5); },
  farther() { zoomMiddle(0.5 ** 0.5); },
  reset() { Object.assign(state, { exposure: 0, tone: clip().tone, zoom: 1, x: 0.5, y: 0.5 }); },
  nextA() { stepTechnique("a", 1); },
  previousA() { stepTechnique("a", -1); },
  nextB() { stepTechnique("b", 1); },
  previousB() { stepTechnique("b", -1); },
  left() { moveView(1, 0); },
  right() { moveView(-1, 0); },
  up() { moveView(0, 1); },
  down() { moveView(0, -1); },
  help() {
    element("help").showModal();
    element("help").scrollTop = 0;
  },
  loop() {
    loop.running = !loop.running;
    if (loop.running) loopBeside();
  },
  play() {
    state.playing = !state.playing && clip().frames.length > 1;
    if (state.playing) play();
    else stepFrame(0);
  },
};

const KEYS = {
  " ": "flip", s: "split", h: "heat", ArrowLeft: "previous", ArrowRight: "next", w: "worst", "shift w": "worstOfAll",
  p: "play", d: "loop", "+": "brighter", "shift +": "brighter", "=": "brighter", "-": "darker", z: "closer", x: "farther",
  0: "reset", n: "nextA", "shift n": "previousA", m: "nextB", "shift m": "previousB", "?": "help", "shift ?": "help",
  "shift ArrowLeft": "left", "shift ArrowRight": "right", "shift ArrowUp": "up", "shift ArrowDown": "down",
};

// ---- playing: the frame that is due by the clock; it waits for pictures that are still being loaded

function playFrames({ running, next, fps, isReady, show }) { // next: how many are due -> the frame to show
  let shownAt = performance.now();
  const tick = (now) => {
    if (!running()) return;
    const due = Math.floor((now - shownAt) / 1000 * fps() + 0.1);
    const index = due > 0 ? next(due) : null;
    if (due > 0 && index !== null && isReady(index)) {
      shownAt += due / fps() * 1000;
      show(index);
    } else if (due > 0) shownAt = now - 1000 / fps();
    requestAnimationFrame(tick);
  };
  requestAnimationFrame(tick);
}

let runs = 0;
function play() {
  const run = ++runs;
  playFrames({
    running: () => state.playing && run === runs,
    next: (due) => (state.frame + due) % clip().frames.length,
    fps: () => state.fps,
    isReady,
    show: (index) => {
      state.frame = index;
      requestDraw();
    },
  });
}

const isReady = (index) => panels().every(([, name, heat]) => isLoaded(state.clip, name, index, heat));

function isLoaded(place, name, index, heat) { // or cannot be
  return [heat < HEAT_ALONE, heat > 0].every((wanted, map) =>
    !wanted || picture(place, name, index, map > 0) || failed.has(keyOf(place, name, index, map > 0)));
}

// ---- listening

function changed() {
  requestDraw();
  if (!state.playing) writeAddress();
}

function act(action) {
  state.message = "";
  actions[action]();
  changed();
}

function hold(on) {
  state.holding = on && hasReference();
  document.querySelector("[data-hold]").classList.toggle("on", state.holding);
  requestDraw();
}

function onKey(event) {
  const at = event.target.tagName;
  if (event.ctrlKey || event.metaKey || event.altKey || element("help").open || at === "SELECT") return;
  if (at === "INPUT" && (event.target.type === "number" || event.key.startsWith("Arrow"))) return;
  if ((at === "BUTTON" || at === "SUMMARY") && event.key === " ") return;
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  const action = KEYS[(event.shiftKey ? "shift " : "") + key];
  const technique = clip().techniques[Number(key) - 1];
  if (key === "r") hold(true);
  else if (/^[1-9]$/.test(key) && technique) {
    chooseTechnique("a", technique);
    changed();
  } else if (action) act(action);
  else return;
  event.preventDefault();
}

function listen() {
  let typedInto = null; // after a choice by other than keys, keys are for the viewer again
  document.addEventListener("pointerdown", () => { typedInto = null; }, true);
  document.addEventListener("keydown", (event) => { typedInto = event.target; }, true);
  const leave = (control) => { if (typedInto !== control) control.blur(); };

  const chosen = (choose) => ({ target }) => {
    state.message = "";
    choose(target.value);
    leave(target);
    changed();
  };
  element("clip").onchange = chosen((value) => {
    chooseClip(Number(value));
    screen.scrollIntoView({ block: "nearest" }); // all of it: the upper part of a whole picture is often sky
  });
  element("tone").onchange = chosen((value) => { state.tone = value; });
  for (const letter of ["a", "b"]) element(letter).onchange = chosen((value) => chooseTechnique(letter, value));
  element("frame").oninput = chosen((value) => { state.frame = Number(value); });
  element("fps").onchange = chosen((value) => {
    state.fps = Math.min(240, Math.max(1, Number(value) || clip().fps));
    element("fps").value = state.fps;
  });
  for (const button of document.querySelectorAll("[data-action]")) {
    button.onclick = () => { act(button.dataset.action); leave(button); };
  }
  const holder = document.querySelector("[data-hold]");
  holder.onpointerdown = (event) => { holder.setPointerCapture(event.pointerId); hold(true); };
  holder.onpointerup = holder.onpointercancel = () => { hold(false); leave(holder); };
  holder.oncontextmenu = (event) => event.preventDefault();
  document.addEventListener("decoded", requestDraw);
  document.addEventListener("keydown", onKey);
  document.addEventListener("keyup", (event) => { if (event.key.toLowerCase() === "r") hold(false); });
  window.addEventListener("blur", () => hold(false));
  window.addEventListener("resize", requestDraw);
  window.addEventListener("hashchange", () => {
    if (!location.hash.includes("=")) return; // a place on the page, not a view
    readAddress();
    screen.scrollIntoView({ block: "nearest" });
    requestDraw();
  });
  listenToPointer();
  listenBeside();
}

if (data.clips.length) {
  options(element("clip"), data.clips.map((item) => item.name));
  const views = { none: "clipped", reinhard: "Reinhard", aces: "ACES fit" };
  element("tone").replaceChildren(...Object.entries(views).map(([tone, name]) => new Option(name, tone)));
  for (const text of ["≤ −1", "−½", "0", "+½", "≥ +1"]) {
    const tick = text.replace("1", data.error.range).replace("½", data.error.range / 2);
    element("legend-ticks").append(Object.assign(document.createElement("span"), { textContent: tick }));
  }
  readAddress();
  listen();
  draw();
} else {
  element("viewer").hidden = true;
}
