// Zoom and pan by wheel, mouse, fingers and buttons: all panels together.

const clamp = (value) => Math.min(1, Math.max(0, value));

function zoomAt(x, y, factor) { // keep what lies under (x, y) where it is
  const before = layout();
  const dx = x % before.wide - before.wide / 2, dy = y % before.high - before.high / 2;
  state.zoom = Math.min(largestZoom(), Math.max(1, state.zoom * factor));
  const after = layout();
  pan(dx / after.scale - dx / before.scale, dy / after.scale - dy / before.scale);
}

function zoomMiddle(factor) {
  const at = layout();
  zoomAt(at.wide / 2, at.high / 2, factor);
}

function pan(dx, dy) { // by picture px
  const at = layout();
  state.x = clamp(state.x - dx / at.width);
  state.y = clamp(state.y - dy / at.height);
}

const touching = new Map(); // pointers that are down: id -> place
function onMove(event) {
  const here = { x: event.offsetX, y: event.offsetY };
  const before = touching.get(event.pointerId);
  pointer = here;
  if (before && touching.size === 1) {
    const at = layout();
    if (state.zoom > 1) pan((here.x - before.x) / at.scale, (here.y - before.y) / at.scale);
  } else if (before) {
    const other = [...touching].find(([id]) => id !== event.pointerId)[1];
    const apart = (p) => Math.hypot(p.x - other.x, p.y - other.y) || 1;
    zoomAt((here.x + other.x) / 2, (here.y + other.y) / 2, apart(here) / apart(before));
  }
  if (before) {
    touching.set(event.pointerId, here);
    changed();
  }
  requestDraw();
}

function listenToPointer() {
  screen.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoomAt(event.offsetX, event.offsetY, 2 ** (-Math.sign(event.deltaY) / 4));
    changed();
  }, { passive: false });
  screen.addEventListener("pointerdown", (event) => {
    screen.setPointerCapture(event.pointerId);
    pointer = { x: event.offsetX, y: event.offsetY };
    touching.set(event.pointerId, pointer);
    requestDraw();
  });
  screen.addEventListener("pointermove", onMove);
  for (const name of ["pointerup", "pointercancel"]) screen.addEventListener(name, (event) => touching.delete(event.pointerId));
  screen.addEventListener("pointerleave", (event) => { // the values under a finger stay to be read
    if (event.pointerType === "mouse") pointer = null;
    requestDraw();
  });
}
