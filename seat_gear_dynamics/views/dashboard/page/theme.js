// Light and dark: the system's wish, or the person's, which is kept on this device.

import { byId, forgetColours } from "./text.js";

const KEY = "seat-gear-theme";
const NAMES = ["auto", "light", "dark"];

function kept() {
  try {
    return localStorage.getItem(KEY);
  } catch {
    return null; // a browser that keeps nothing
  }
}

function keep(name) {
  try {
    localStorage.setItem(KEY, name);
  } catch {
    // then it holds until the page is closed
  }
}

export function startTheme(changed) {
  const button = byId("theme");
  const dark = byId("dark");
  const system = dark.media;
  let name = NAMES.includes(kept()) ? kept() : "auto";
  const show = () => {
    dark.media = { auto: system, light: "not all", dark: "all" }[name];
    button.textContent = `Theme: ${name}`;
    forgetColours();
    changed();
  };
  button.addEventListener("click", () => {
    name = NAMES[(NAMES.indexOf(name) + 1) % NAMES.length];
    keep(name);
    show();
  });
  matchMedia(system).addEventListener("change", show);
  dark.addEventListener("load", show);
  show();
}
