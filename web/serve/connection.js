// The session's socket: messages there and back, one after the other, and again after the network was away.

const FINAL_CODES = new Set([1008, 1011]); // the server says why, and would say it again
const MOST_ATTEMPTS = 8;

export class Connection {
  // `handlers`: tables, state, followed(the serial number of the last that was said here and is done), picture,
  // screenshot, failed, busy(whether what was said is still to be seen), and status(text, mayRetry).
  constructor(handlers) {
    this.handlers = handlers;
    this.serial = 0;
    this.attempts = 0;
    document.addEventListener("visibilitychange", () => this.acknowledge());
  }

  open() {
    const address = new URL("socket", location.href);
    address.protocol = "ws:";
    this.socket = new WebSocket(address);
    this.socket.binaryType = "arraybuffer";
    this.shown = 0;
    this.acknowledged = 0;
    let work = Promise.resolve(); // pictures are decoded meanwhile, and shown in turn
    this.socket.onmessage = (event) => (work = work.then(() => this.take(event.data)));
    this.socket.onclose = (event) => this.closed(event);
  }

  send(type, fields = {}) {
    if (this.socket?.readyState !== WebSocket.OPEN) return 0;
    this.socket.send(JSON.stringify({ type, serial: ++this.serial, ...fields }));
    this.handlers.busy(true);
    return this.serial;
  }

  async take(message) {
    const size = new DataView(message).getUint32(0, true);
    const header = JSON.parse(new TextDecoder().decode(new Uint8Array(message, 4, size)));
    const payload = new Uint8Array(message, 4 + size);
    if (header.tables) {
      this.attempts = 0;
      this.handlers.tables(header.tables);
    }
    if (header.state) this.handlers.state(header.state);
    this.handlers.followed(header.serial);
    if (header.picture) await this.handlers.picture(header.picture, payload, header.serial);
    if (header.screenshot) this.handlers.screenshot(payload);
    if (header.failed) this.handlers.failed(header.failed);
    if (header.rests !== undefined) this.handlers.busy(!header.rests || header.serial !== this.serial);
    this.shown = header.number;
    this.acknowledge();
  }

  // The server waits for it: a page that nobody sees gets no pictures.
  acknowledge() {
    if (document.hidden || this.shown === this.acknowledged || this.socket.readyState !== WebSocket.OPEN) return;
    this.acknowledged = this.shown;
    this.socket.send(JSON.stringify({ type: "shown", number: this.shown }));
  }

  closed(event) {
    const again = !FINAL_CODES.has(event.code) && this.attempts < MOST_ATTEMPTS;
    const reason = event.reason || "the server does not answer";
    this.handlers.status(again ? `Not connected: ${reason}; trying again` : `Not connected: ${reason}`, !again);
    if (again) setTimeout(() => this.open(), Math.min(500 * 2 ** this.attempts++, 15000));
  }
}
