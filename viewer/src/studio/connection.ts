// The web socket to the server, in the messages' types.

import type { Reply, Request } from "./messages";

export class Connection {
  private readonly socket: WebSocket;
  private asked = 0;
  private waiting = false; // for the answer to a point
  private next: [number, number] | null = null;

  constructor(onReply: (reply: Reply) => void, onEnd: (why: string) => void) {
    const address = new URL("session", location.href);
    address.protocol = "ws:";
    address.hash = "";
    this.socket = new WebSocket(address);
    let last = "";
    this.socket.addEventListener("message", (event) => {
      const reply = JSON.parse(event.data as string) as Reply;
      if (reply.kind === "refused") last = reply.says;
      if (reply.kind === "pointed") this.#answered();
      if (reply.kind === "refused" && this.waiting) this.#answered();
      onReply(reply);
    });
    this.socket.addEventListener("close", (event) => onEnd(event.code === 4008 ? last : ""));
  }

  ask(request: Request): void {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(request));
  }

  // Ask about a point; while an answer is on its way only the last one that was pointed at is kept.
  point(at: [number, number] | null): void {
    this.next = at;
    if (!this.waiting) this.#send();
  }

  // Whether an answer is about the last point that was asked about.
  isLast(id: number): boolean {
    return id === this.asked && !this.next;
  }

  #send(): void {
    if (!this.next) return;
    this.asked += 1;
    this.waiting = true;
    this.ask({ kind: "point", id: this.asked, at: this.next });
    this.next = null;
  }

  #answered(): void {
    this.waiting = false;
    this.#send();
  }
}
