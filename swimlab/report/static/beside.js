// The detail beside the whole picture: where pictures differ most, of A, B and what errs most, as a loop.

const inset = element("inset");
const insetBrush = inset.getContext("2d");
const loop = { frame: 0, of: -1, run: 0, running: !matchMedia("(prefers-reduced-motion: reduce)").matches };

function detailPlace() { // of the detail of the whole pictures that are shown, or -1
  return clip().region || state.split ? -1
    : data.clips.findIndex((item) => item.region && item.sequence === clip().sequence);
}

const detailBeside = () => data.clips[detailPlace()] ?? null;
const namesBeside = () => [...new Set([state.a, state.b, clip().farthest])].filter((name) => clip().techniques.includes(name));

const LOWEST = 0.35; // of the window: how high it is below the whole picture, where there is no room beside it
const isBelow = () => inset.getBoundingClientRect().top > screen.getBoundingClientRect().top + 1;

function panelsBeside() { // [name, left, top] of each in as many columns as make them largest, in CSS px
  const names = namesBeside();
  const [width, height] = detailBeside().sizes[0];
  const room = isBelow() ? LOWEST * window.innerHeight : screen.clientHeight;
  const grids = names.map((_, i) => {
    const across = i + 1, down = Math.ceil(names.length / across);
    return { across, down, scale: Math.min(inset.clientWidth / across / width, room / down / height) };
  });
  const { across, down, scale } = grids.reduce((best, grid) => (grid.scale > best.scale ? grid : best));
  const wide = inset.clientWidth / across, high = isBelow() ? scale * height : room / down;
  const places = names.map((name, i) => [name,
    (i % across + 0.5) * wide - scale * width / 2, (Math.floor(i / across) + 0.5) * high - scale * height / 2]);
  return { places, across, width, height, wide, high, scale, down };
}

function showBeside() { // before the screen is laid out, whose width this decides
  element("beside").hidden = !detailBeside();
}

function drawBeside() {
  const detail = detailBeside();
  if (!detail) return;
  if (loop.of !== detailPlace()) Object.assign(loop, { of: detailPlace(), frame: 0 });
  const at = panelsBeside(), ratio = window.devicePixelRatio || 1;
  const room = at.down * at.high;
  inset.style.height = room + "px";
  inset.width = Math.round(inset.clientWidth * ratio);
  inset.height = Math.round(room * ratio);
  insetBrush.setTransform(ratio, 0, 0, ratio, 0, 0);
  insetBrush.imageSmoothingEnabled = false;
  for (const [name, left, top] of at.places) {
    const canvas = develop(loop.of, name, loop.frame, detail.compared.includes(name) ? state.heat : 0,
      state.exposure, state.tone);
    if (canvas) insetBrush.drawImage(canvas, left, top, at.width * at.scale, at.height * at.scale);
    label(insetBrush, [name, name === clip().farthest && at.places.length > 2 ? "(farthest)" : ""], left, top);
  }
  const [x, y] = detail.region;
  element("inset-says").textContent = `the outlined ${at.width}x${at.height} px at (${x}, ${y}), ` +
    `frame ${detail.frames[loop.frame]} of frames ${detail.frames[0]} to ${detail.frames.at(-1)}, at ${detail.fps} fps`;
  document.querySelector("[data-action=loop]").textContent = loop.running ? "pause" : "play";
}

function loopBeside() {
  const run = ++loop.run;
  playFrames({
    running: () => loop.running && run === loop.run,
    next: (due) => detailBeside() && (loop.frame + due) % detailBeside().frames.length,
    fps: () => detailBeside()?.fps ?? 1,
    isReady: (index) => namesBeside().every((name) => isLoaded(detailPlace(), name, index,
      detailBeside().compared.includes(name) ? state.heat : 0)),
    show: (index) => {
      loop.frame = index;
      drawBeside();
    },
  });
}

function listenBeside() {
  inset.onclick = (event) => { // the detail itself, of what was pointed at
    const at = panelsBeside();
    const [name] = at.places[at.across * Math.floor(event.offsetY / at.high) + Math.floor(event.offsetX / at.wide)] ?? [];
    if (!name) return;
    chooseClip(detailPlace());
    chooseTechnique("a", name);
    changed();
  };
  if (loop.running) loopBeside();
}
