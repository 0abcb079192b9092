// What partners are asked for, how far they are, and what they offer.

import { get, number } from "../data";
import type { AskPartner, Proposal, Request, TellLook, TellOpened, TellPartner, TellProposals } from "./messages";

type Task = AskPartner["task"];

export class Partners {
  running = false;
  offers: Proposal[] = [];
  looked: number | null = null;
  private task = "";

  constructor(
    private readonly ask: (request: Request) => void,
    private readonly region: () => [number, number][],
    private readonly onLook: (proposal: Proposal | null) => void,
  ) {
    for (const button of document.querySelectorAll<HTMLButtonElement>("[data-task]")) {
      button.addEventListener("click", () => this.begin(button.dataset.task as Task));
    }
    get("measure").addEventListener("click", () => this.begin("measure"));
    get("certify").addEventListener("click", () => this.begin("certify"));
    get("stop").addEventListener("click", () => ask({ kind: "stop" }));
    get("take").addEventListener("click", () => this.looked !== null && ask({ kind: "take", number: this.looked }));
    get("leaveIt").addEventListener("click", () => ask({ kind: "leave" }));
  }

  open(game: TellOpened): void {
    const choose = get<HTMLSelectElement>("searcher");
    choose.replaceChildren(...game.searchers.map((name) => new Option(name, name)));
    get("offgrid").hidden = !game.polishes;
    this.offers = [];
    this.#list();
    this.told({ kind: "partner", task: "", running: false, says: "", interactions: 0, best: null });
  }

  begin(task: Task): void {
    const searcher = get<HTMLSelectElement>("searcher").value;
    const budget = Number(get<HTMLSelectElement>("budget").value);
    this.ask({ kind: "partner", task, searcher, budget, region: task === "repair" ? this.region() : [] });
  }

  told(reply: TellPartner): void {
    this.running = reply.running;
    get("stop").hidden = !reply.running;
    for (const button of document.querySelectorAll<HTMLButtonElement>("[data-task], #measure, #certify, #save, #export")) {
      button.disabled = reply.running;
    }
    const played = reply.interactions ? ` · ${reply.interactions.toLocaleString("en")} ${reply.task === "polish" ? "designs" : "interactions"}` : "";
    const best = reply.best === null || reply.best === undefined ? "" : ` · best ${number(reply.best, 4)}`;
    get("working").textContent = reply.task ? `${reply.task}: ${reply.says}${played}${reply.running ? best : ""}` : "";
  }

  proposed(reply: TellProposals): void {
    const before = this.offers.length;
    this.offers = reply.proposals;
    this.task = reply.task;
    if (!this.offers.length) {
      this.looked = null;
      this.onLook(null);
    } else if (this.task !== "suggest" || !before || this.looked === null) {
      this.look(0); // the best, as it comes
    }
    this.#list();
  }

  look(k: number): void {
    this.looked = k;
    this.onLook(this.offers[k]);
    this.ask({ kind: "look", number: k });
    this.#list();
  }

  title(reply: TellLook): string {
    const worth = reply.worth ? `return ${number(reply.worth.value, 4)} at ${number(reply.worth.angle, 0)}°` : "";
    return this.task === "suggest" ? `${this.offers[reply.number]?.says ?? ""}: leads to ${worth}` : `${this.task}: ${worth}`;
  }

  #list(): void {
    const list = get("proposals");
    const shown = this.task === "suggest" ? this.offers : [];
    list.replaceChildren(
      ...shown.map((offer) => {
        const button = document.createElement("button");
        button.type = "button";
        button.textContent = `${offer.says}${offer.worth ? ` → ${number(offer.worth.value, 4)}` : ""}`;
        button.setAttribute("aria-pressed", String(offer.number === this.looked));
        button.addEventListener("click", () => this.look(offer.number));
        button.addEventListener("pointerenter", () => this.onLook(offer));
        const item = document.createElement("li");
        item.append(button);
        return item;
      }),
    );
  }
}
