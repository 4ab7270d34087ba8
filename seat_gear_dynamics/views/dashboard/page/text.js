// Texts, numbers and small pieces of the page. Whatever comes from the bench is set as text, never as markup.

export const byId = (id) => document.getElementById(id);

export const LEVELS = ["OK", "WARN", "ERROR", "STALE"];
export const SIGNS = [
  "M24 3a21 21 0 1 0 0 42a21 21 0 0 0 0-42zM20.500 34.500 10.500 24.500l4-4 6 6 13.500-13.500 4 4z",
  "M24 3 47 44H1zM21.500 18v13h5V18zM21.500 34.500v5h5v-5z",
  "M15 2h18l13 13v18L33 46H15L2 33V15zM21.200 11v17h5.600V11zM21.200 31.500v5.600h5.600v-5.600z",
  "M24 3a21 21 0 1 0 0 42a21 21 0 0 0 0-42zM21.500 10h5v13.500l8.500 8-3.400 3.700L21.500 26z",
];

/** Set a text only where it differs, so that nothing is laid out or read aloud again without need. */
export function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

export const number = (value, digits = 0) => (value === null || value === undefined ? "–" : minus(value.toFixed(digits)));

export const minus = (text) => (/^-0(\.0*)?$/.test(text) ? text.slice(1) : text.replace("-", "−"));

/** A number for an axis: as short as it can be said. */
export const tick = (value) => minus(String(Number(value.toPrecision(6))));

export function make(tag, className, text) {
  const made = document.createElement(tag);
  if (className) made.className = className;
  if (text !== undefined) made.textContent = text;
  return made;
}

/** Show pairs of key and text in a <dl>, changing only what differs. */
export function showFacts(list, pairs) {
  while (list.children.length > pairs.length) list.lastElementChild.remove();
  pairs.forEach(([key, value], i) => {
    if (!list.children[i]) {
      const row = make("div");
      row.append(make("dt"), make("dd"));
      list.append(row);
    }
    setText(list.children[i].firstElementChild, key);
    setText(list.children[i].lastElementChild, value);
  });
}

const styles = () => getComputedStyle(document.documentElement);
let colours = new Map();

/** A colour of the present theme by the name of its custom property. */
export function colour(name) {
  if (!colours.has(name)) colours.set(name, styles().getPropertyValue(`--${name}`).trim());
  return colours.get(name);
}

export function forgetColours() {
  colours = new Map();
}

const labels = new Map();

/** Say in words what a picture shows, at most once a second. */
export function describe(element, text) {
  const now = performance.now();
  if (now - (labels.get(element) ?? -1e9) < 1000) return;
  labels.set(element, now);
  element.setAttribute("aria-label", text);
}
