"use strict";
// Pictures: taken from the page or from scripts beside it, decoded, and developed for the screen. What was not used for
// longest is forgotten.

const data = JSON.parse(document.getElementById("pictures").textContent);

const STOPS = data.error.colours;
const TOO_DARK = [70, 160, 255], TOO_BRIGHT = [255, 84, 40];
const OUTSIDE = [128, 128, 128];
const DIMMED = 0.55;
const HEAT_OVER = 1, HEAT_ALONE = 2;

const decode = (code) => {
  const c = code / 255;
  return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
};
const encode = (linear) => {
  const c = Math.min(1, Math.max(0, linear));
  return Math.round(255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055));
};
// What a code of a clip's pictures is in linear radiance; the last one is its lower bound.
const radiances = [decode, (code) => { const y = decode(Math.min(code, 254.5)); return y / (1 - y); }]
  .map((curve) => Float64Array.from({ length: 256 }, (_, code) => curve(code)));
const radianceOf = (clip) => radiances[Number(data.clips[clip].wide)];
// Views: how light, 0 and more, is brought to 0..1 before sRGB (Reinhard et al. 2002; Narkowicz 2016).
const TONES = {
  none: (light) => light,
  reinhard: (light) => light / (1 + light),
  aces: (light) => { const x = Math.min(light, 8); return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14); },
};
const errorOf = (code) => (code - data.error.steps - 1) / data.error.steps * data.error.range;

function diverging(value) { // -1 is blue, 0 white, 1 red
  const place = (Math.max(-1, Math.min(1, value)) + 1) / 2 * (STOPS.length - 1);
  const low = Math.min(Math.floor(place), STOPS.length - 2);
  return STOPS[low].map((channel, i) => Math.round(channel + (STOPS[low + 1][i] - channel) * (place - low)));
}

// [red, green, blue, opacity] of an error as a fraction of the range.
function errorColour(value, heat) {
  if (heat === HEAT_ALONE) return [...diverging(value), 1];
  return [...(value < 0 ? TOO_DARK : TOO_BRIGHT), Math.min(1, Math.sqrt(Math.abs(value)))];
}

// ---- memory
const largest = Math.max(1, ...data.clips.flatMap((item) => item.sizes.map(([w, h]) => 4 * w * h)));
const KEPT_BYTES = Math.max(400e6, 10 * largest); // what one view needs always fits
const kept = new Map(); // key -> [value, bytes], what was not used for longest first
let keptBytes = 0;

function forget(key) {
  keptBytes -= kept.get(key)?.[1] ?? 0;
  kept.delete(key);
}

function keep(key, value, bytes) {
  forget(key);
  kept.set(key, [value, bytes]);
  keptBytes += bytes;
  for (const oldest of kept.keys()) {
    if (keptBytes <= KEPT_BYTES || oldest === key) break;
    forget(oldest);
  }
}

function recall(key) {
  const found = kept.get(key);
  if (found) {
    kept.delete(key);
    kept.set(key, found);
  }
  return found?.[0] ?? null;
}

// ---- loading
const pending = new Set(), failed = new Set(); // keys
const waiting = new Map(); // name of a script -> [key, wants the error map] of what waits for it

const keyOf = (clip, technique, index, heat) => JSON.stringify([clip, technique, index, Boolean(heat)]);
const hasPicture = (clip, technique, heat) => data.clips[clip][heat ? "compared" : "techniques"].includes(technique);

// ImageData of a picture or, with heat, of an error map's codes; null where there is none or it is still being loaded.
function picture(clip, technique, index, heat) {
  if (!hasPicture(clip, technique, heat)) return null;
  const key = keyOf(clip, technique, index, heat);
  const pixels = recall(key);
  if (pixels || pending.has(key) || failed.has(key)) return pixels;
  pending.add(key);
  const item = data.clips[clip];
  if (item.folder) loadScript(`${item.folder}/${technique}.${String(item.frames[index]).padStart(4, "0")}.js`, key, heat);
  else decodePicture(key, (heat ? item.errors : item.pictures)[technique][index]);
  return null;
}

function settled(key, ok) {
  pending.delete(key);
  if (!ok) failed.add(key);
  document.dispatchEvent(new Event("decoded"));
}

function loadScript(name, key, heat) {
  if (waiting.has(name)) {
    waiting.get(name).push([key, heat]);
    return;
  }
  waiting.set(name, [[key, heat]]);
  const script = document.createElement("script");
  script.src = name.split("/").map(encodeURIComponent).join("/");
  script.onload = script.onerror = () => { // what still waits was not in it
    script.remove();
    for (const [lost] of waiting.get(name) ?? []) settled(lost, false);
    waiting.delete(name);
  };
  document.head.append(script);
}

function received(name, image, error) { // called by the scripts
  for (const [key, heat] of waiting.get(name) ?? []) decodePicture(key, heat ? error : image);
  waiting.delete(name);
}

function decodePicture(key, base64) {
  const image = new Image();
  image.onload = () => {
    const canvas = document.createElement("canvas");
    canvas.width = image.width;
    canvas.height = image.height;
    const brush = canvas.getContext("2d", { willReadFrequently: true });
    brush.drawImage(image, 0, 0);
    keep(key, brush.getImageData(0, 0, image.width, image.height), 4 * image.width * image.height);
    settled(key, true);
  };
  image.onerror = () => settled(key, false);
  image.src = "data:image/webp;base64," + base64;
}

// ---- developing

// A canvas ready to be drawn, or null as above. heat: 0 the picture, HEAT_OVER its error over it in grey, HEAT_ALONE.
function develop(clip, technique, index, heat, exposure, tone) {
  const key = JSON.stringify([clip, technique, index, heat, ...(heat === HEAT_ALONE ? [] : [exposure, tone]), "developed"]);
  const done = recall(key);
  if (done) return done;
  const pixels = heat === HEAT_ALONE ? null : picture(clip, technique, index, false);
  const errors = heat ? picture(clip, technique, index, true) : null;
  if ((heat && !errors) || (heat !== HEAT_ALONE && !pixels)) return null;
  const { width, height } = pixels ?? errors;
  const result = new ImageData(width, height);
  const table = developed(clip, exposure, tone);
  if (heat) developError(errors.data, pixels?.data, result.data, heat, table);
  else developPicture(pixels.data, result.data, table);
  const canvas = document.createElement("canvas");
  canvas.width = width;
  canvas.height = height;
  canvas.getContext("2d").putImageData(result, 0, 0);
  keep(key, canvas, 4 * width * height);
  return canvas;
}

// Codes to show of the codes of a clip's pictures.
const developed = (clip, exposure, tone) =>
  Uint8Array.from(radianceOf(clip), (radiance) => encode(TONES[tone](radiance * 2 ** exposure)));

function developPicture(from, to, table) {
  for (let i = 0; i < from.length; i += 4) {
    to[i] = table[from[i]];
    to[i + 1] = table[from[i + 1]];
    to[i + 2] = table[from[i + 2]];
    to[i + 3] = 255;
  }
}

function developError(codes, from, to, heat, table) {
  const outside = heat === HEAT_ALONE ? [...OUTSIDE, 1] : [0, 0, 0, 0];
  const colours = Array.from({ length: 256 }, (_, code) =>
    code === 0 ? outside : errorColour(errorOf(code) / data.error.range, heat));
  for (let i = 0; i < codes.length; i += 4) {
    const [red, green, blue, opacity] = colours[codes[i]];
    const grey = from ? DIMMED * (0.2126 * table[from[i]] + 0.7152 * table[from[i + 1]] + 0.0722 * table[from[i + 2]]) : 0;
    to[i] = grey + opacity * (red - grey);
    to[i + 1] = grey + opacity * (green - grey);
    to[i + 2] = grey + opacity * (blue - grey);
    to[i + 3] = 255;
  }
}
