import type { Signal } from "@preact/signals";
import { signal } from "@preact/signals";
import { nextScene } from "../scene/reducer";
import type { Scene, SceneMessage } from "../scene/scene";
import { retryDelay_ms } from "./backoff";

/** The server's last message before it closes the socket; another attempt would be refused too. */
export interface Refusal {
  readonly type: "refused";
  readonly code: string;
  readonly detail: string;
}

export type LinkState = "connecting" | "open" | "lost" | "refused";

/** The server speaks at least every 5 s; a link that is silent for longer than this is dead. */
const SILENT_MS = 12_000;
const WATCHDOG_EVERY_MS = 1_000;

/**
 * The one owner of the live websocket and the one writer of the scene. It dials again after every loss, at
 * once when the network comes back or the page is looked at again.
 */
export class LiveLink {
  readonly scene: Signal<Scene | null> = signal(null);
  readonly state: Signal<LinkState> = signal("connecting");
  readonly refusal: Signal<Refusal | null> = signal(null);
  /** Screen time (performance.now) at which the server was heard last; null for never. */
  readonly heard_ms: Signal<number | null> = signal(null);

  private socket: WebSocket | null = null;
  private attempt = 0;
  private timer = 0;
  private watchdog = 0;
  private spoken_ms = 0;
  private readonly leaving = new AbortController();

  /** ride_token: watch one's own ride; "" watches everything, for signed-in operators. */
  constructor(private readonly ride_token: string) {
    const on = { signal: this.leaving.signal };
    window.addEventListener("online", () => this.dialNow(), on);
    window.addEventListener("offline", () => this.dropped(), on);
    document.addEventListener("visibilitychange", () => this.looked(), on);
    this.watchdog = window.setInterval(() => this.watch(), WATCHDOG_EVERY_MS);
    this.dial();
  }

  leave(): void {
    this.leaving.abort();
    clearTimeout(this.timer);
    clearInterval(this.watchdog);
    this.forget();
  }

  /** The server's clock now, as far as this screen knows it. */
  now_ms(): number | null {
    const [scene, heard_ms] = [this.scene.value, this.heard_ms.value];
    return scene === null || heard_ms === null ? null : scene.at_ms + performance.now() - heard_ms;
  }

  private dial(): void {
    this.forget();
    this.spoken_ms = performance.now();
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(`${scheme}//${location.host}/ws/live`);
    this.socket = socket;
    socket.onopen = () => {
      const watch = this.ride_token === "" ? {} : { ride_token: this.ride_token };
      socket.send(JSON.stringify({ type: "watch", ...watch }));
    };
    socket.onmessage = (event: MessageEvent<string>) => this.received(event.data);
    socket.onclose = () => this.dropped();
  }

  private received(data: string): void {
    const message = JSON.parse(data) as SceneMessage | Refusal;
    if (message.type === "refused") {
      this.refusal.value = message;
      this.state.value = "refused";
      this.forget();
      return;
    }
    this.attempt = 0;
    this.spoken_ms = performance.now();
    this.heard_ms.value = this.spoken_ms;
    this.scene.value = nextScene(this.scene.value, message);
    this.state.value = "open";
  }

  private dropped(): void {
    if (this.state.value === "refused") return;
    this.forget();
    this.state.value = this.heard_ms.value === null ? "connecting" : "lost";
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => this.dial(), retryDelay_ms(this.attempt, Math.random()));
    this.attempt += 1;
  }

  private dialNow(): void {
    if (this.state.value === "open" || this.state.value === "refused") return;
    clearTimeout(this.timer);
    this.attempt = 0;
    this.dial();
  }

  private looked(): void {
    if (document.visibilityState === "visible") this.dialNow();
  }

  private watch(): void {
    const is_silent = performance.now() - this.spoken_ms > SILENT_MS;
    if (this.socket !== null && is_silent) this.dropped();
  }

  private forget(): void {
    const socket = this.socket;
    this.socket = null;
    if (socket === null) return;
    socket.onopen = socket.onmessage = socket.onclose = null;
    socket.close();
  }
}
