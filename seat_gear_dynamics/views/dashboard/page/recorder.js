// The recorder: state, counts, and the buttons where this page may press them.

import { byId, setText, showFacts } from "./text.js";

const BUSY_MS = 12000; // the server answers within 10 s

let busy = null;
let last = { can: [] };

export function startRecorder(press) {
  for (const button of document.querySelectorAll("[data-press]")) {
    button.addEventListener("click", () => {
      if (button.getAttribute("aria-disabled") === "true") return;
      if (button.dataset.press === "stop") byId("sure").showModal();
      else ask(button.dataset.press, press);
    });
  }
  byId("sure").addEventListener("close", () => {
    if (byId("sure").returnValue === "stop") ask("stop", press);
    byId("sure").returnValue = "";
  });
}

function ask(action, press) {
  clearTimeout(busy);
  busy = setTimeout(() => settle("No answer came."), BUSY_MS);
  setText(byId("answer"), `${action} …`);
  showButtons();
  press(action);
}

function settle(text) {
  clearTimeout(busy);
  busy = null;
  setText(byId("answer"), text);
  showButtons();
}

export function showAnswer(message) {
  settle(`${message.press}: ${message.done ? "" : "not done, "}${message.text}`);
}

export function forgetPress() {
  if (busy !== null) settle("The connection was lost before an answer came.");
}

export function showRole(role) {
  byId("buttons").hidden = role !== "control";
  byId("read-only").hidden = role === "control";
}

export function showRecorder(recorder) {
  last = recorder;
  byId("recorder-state").dataset.state = recorder.state;
  byId("recorder-state").dataset.level = recorder.level;
  setText(byId("recorder-word"), recorder.state);
  setText(byId("recorder-text"), recorder.text === recorder.state ? "" : recorder.text);
  showFacts(byId("recorder-facts"), recorder.facts);
  showButtons();
}

// Not `disabled`, which would take the focus away from under a person who works with keys.
function showButtons() {
  for (const button of document.querySelectorAll("[data-press]")) {
    const off = busy !== null || !last.can.includes(button.dataset.press);
    if (button.getAttribute("aria-disabled") !== String(off)) button.setAttribute("aria-disabled", String(off));
  }
}
