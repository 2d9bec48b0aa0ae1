"use strict";
// Pictures out of the page: decoded once, developed on demand into sRGB at an exposure or into the colours of an error map.

const data = JSON.parse(document.getElementById("pictures").textContent);

const STOPS = [[5, 48, 97], [67, 147, 195], [247, 247, 247], [214, 96, 77], [103, 0, 31]];
const OUTSIDE = [128, 128, 128];

function diverging(value) { // -1 is blue, 0 white, 1 red
  const place = (Math.max(-1, Math.min(1, value)) + 1) / 2 * (STOPS.length - 1);
  const low = Math.min(Math.floor(place), STOPS.length - 2);
  return STOPS[low].map((channel, i) => Math.round(channel + (STOPS[low + 1][i] - channel) * (place - low)));
}

const decode = (code) => {
  const c = code / 255;
  return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
};
const encode = (linear) => {
  const c = Math.min(1, Math.max(0, linear));
  return Math.round(255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055));
};
const errorOf = (code) => (code - data.error.steps - 1) / data.error.steps * data.error.range;

// ---- pictures
const decoded = new Map();
const developed = new Map();

// ImageData of a picture or, with heat, of an error map's codes; null where there is none or it is still being decoded.
function picture(clip, technique, index, heat) {
  const source = heat ? data.clips[clip].errors[technique] : data.clips[clip].pictures[technique];
  if (!source) return null;
  const key = [clip, technique, index, heat].join("|");
  if (!decoded.has(key)) {
    decoded.set(key, null);
    const image = new Image();
    image.onload = () => {
      const canvas = document.createElement("canvas");
      canvas.width = image.width;
      canvas.height = image.height;
      const brush = canvas.getContext("2d", { willReadFrequently: true });
      brush.drawImage(image, 0, 0);
      decoded.set(key, brush.getImageData(0, 0, image.width, image.height));
      document.dispatchEvent(new Event("decoded"));
    };
    image.src = "data:image/webp;base64," + source[index];
  }
  return decoded.get(key);
}

// A canvas ready to be drawn, or null as above. An error map has no exposure.
function develop(clip, technique, index, heat, exposure) {
  const pixels = picture(clip, technique, index, heat);
  if (!pixels) return null;
  const key = [clip, technique, index, heat, heat ? 0 : exposure].join("|");
  if (!developed.has(key)) {
    if (developed.size > 300) developed.clear();
    const canvas = document.createElement("canvas");
    canvas.width = pixels.width;
    canvas.height = pixels.height;
    const result = new ImageData(pixels.width, pixels.height);
    const from = pixels.data, to = result.data;
    const gain = 2 ** exposure;
    const table = Array.from({ length: 256 }, (_, code) =>
      heat ? (code === 0 ? OUTSIDE : diverging(errorOf(code) / data.error.range)) : encode(decode(code) * gain));
    for (let i = 0; i < from.length; i += 4) {
      for (let c = 0; c < 3; c++) to[i + c] = heat ? table[from[i]][c] : table[from[i + c]];
      to[i + 3] = 255;
    }
    canvas.getContext("2d").putImageData(result, 0, 0);
    developed.set(key, canvas);
  }
  return developed.get(key);
}
