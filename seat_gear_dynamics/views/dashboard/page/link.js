// The conversation with the server: greeting, frames, presses; what is lost is tried again until it is back.

const SILENCE = 2000; // ms without a frame after which the connection counts as lost; frames come every 50 ms
const FIRST_PAUSE = 500; // ms before the first new attempt, doubled up to the longest
const LONGEST_PAUSE = 4000;
const TOKEN_WANTED = 4401;
const KEY = "seat-gear-token";

/** The token of the address (taken out of it, so that it is not shown or copied along), or of this tab. */
function givenToken() {
  const found = new URLSearchParams(location.hash.slice(1)).get("token");
  try {
    if (found) sessionStorage.setItem(KEY, found);
    if (found) history.replaceState(null, "", location.pathname);
    return found ?? sessionStorage.getItem(KEY) ?? "";
  } catch {
    return found ?? "";
  }
}

export class Link {
  /** `on` has hello(message), frame(message), answer(message), lost(since, reason) and refused(). */
  constructor(on) {
    this.on = on;
    this.token = givenToken();
    this.pause = FIRST_PAUSE;
    this.lostAt = null;
    addEventListener("hashchange", () => this.useToken(givenToken()));
    setInterval(() => this.watch(), 250);
    this.open();
  }

  open() {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(`${scheme}//${location.host}/live`);
    this.socket = socket;
    this.heardAt = performance.now();
    socket.onopen = () => socket.send(JSON.stringify({ token: this.token }));
    socket.onmessage = (event) => this.socket === socket && this.hear(JSON.parse(event.data));
    socket.onclose = (event) => this.socket === socket && this.close(event.code, event.reason);
  }

  hear(message) {
    this.heardAt = performance.now();
    this.heardTime = new Date();
    this.pause = FIRST_PAUSE;
    if (message.kind === "frame") this.lostAt = null;
    this.on[message.kind]?.(message);
  }

  /** A connection that stands but says nothing is lost as well: a sleeping machine, a pulled cable. */
  watch() {
    if (this.socket && performance.now() - this.heardAt > SILENCE) this.close(0, "no word came");
  }

  close(code, reason) {
    const socket = this.socket;
    this.socket = null;
    if (socket) socket.onclose = socket.onmessage = null;
    socket?.close();
    if (code === TOKEN_WANTED) {
      this.on.refused();
      return;
    }
    this.lostAt ??= this.heardTime ?? new Date();
    this.on.lost(this.lostAt, reason);
    setTimeout(() => this.socket ?? this.open(), this.pause);
    this.pause = Math.min(this.pause * 2, LONGEST_PAUSE);
  }

  useToken(token) {
    this.token = token;
    try {
      sessionStorage.setItem(KEY, token);
    } catch {
      // then it holds until the page is loaded anew
    }
    const old = this.socket;
    this.socket = null;
    if (old) old.onclose = old.onmessage = null;
    old?.close();
    this.open();
  }

  press(action) {
    this.socket?.send(JSON.stringify({ press: action }));
  }
}
