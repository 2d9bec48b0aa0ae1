"use strict";
// Dark or light: as the system has it until the reader chooses; kept where the browser lets a page keep things.

const THEMES = ["auto", "light", "dark"];

function useTheme(theme) {
  document.documentElement.dataset.theme = theme;
  try {
    localStorage.setItem("swimlab-theme", theme);
  } catch { /* some browsers keep nothing for pages from files */ }
  for (const button of document.querySelectorAll("#theme")) button.textContent = `theme: ${theme}`;
}

let keptTheme = null;
try {
  keptTheme = localStorage.getItem("swimlab-theme");
} catch { /* as above */ }
useTheme(THEMES.includes(keptTheme) ? keptTheme : "auto");

document.addEventListener("DOMContentLoaded", () => {
  const now = () => document.documentElement.dataset.theme;
  useTheme(now());
  document.getElementById("theme").onclick = () => useTheme(THEMES[(THEMES.indexOf(now()) + 1) % THEMES.length]);
});
