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

/** The server sends a message at least every 5 s; a connection that is silent for longer than this is lost. */
const SILENT_MS = 12_000;
const WATCHDOG_EVERY_MS = 1_000;

/**
 * The one owner of the live websocket and the one writer of the scene. It reconnects after every loss: after a
 * delay, or at once when the network returns or the page becomes visible.
 */
export class LiveLink {
  readonly scene: Signal<Scene | null> = signal(null);
  readonly state: Signal<LinkState> = signal("connecting");
  readonly refusal: Signal<Refusal | null> = signal(null);
  /** The newest attempt to connect failed, or the connection was lost and is not back. */
  readonly is_failing: Signal<boolean> = signal(false);
  /** When the last message arrived, by performance.now; null before the first one. */
  readonly last_message_ms: Signal<number | null> = signal(null);

  private socket: WebSocket | null = null;
  private attempt = 0;
  private timer = 0;
  private watchdog = 0;
  private last_activity_ms = 0;
  private readonly closing = new AbortController();

  /** ride_token: watches one ride; "" watches the whole campus, for operators who are signed in. */
  constructor(private readonly ride_token: string) {
    const on = { signal: this.closing.signal };
    window.addEventListener("online", () => this.reconnectNow(), on);
    window.addEventListener("offline", () => this.connectionLost(), on);
    document.addEventListener("visibilitychange", () => this.visibilityChanged(), on);
    this.watchdog = window.setInterval(() => this.checkSilence(), WATCHDOG_EVERY_MS);
    this.connect();
  }

  close(): void {
    this.closing.abort();
    clearTimeout(this.timer);
    clearInterval(this.watchdog);
    this.discardSocket();
  }

  /** The server's clock now: the time of the last message plus what has passed since. */
  now_ms(): number | null {
    const [scene, message_ms] = [this.scene.value, this.last_message_ms.value];
    return scene === null || message_ms === null
      ? null
      : scene.at_ms + performance.now() - message_ms;
  }

  private connect(): void {
    this.discardSocket();
    this.last_activity_ms = performance.now();
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(`${scheme}//${location.host}/ws/live`);
    this.socket = socket;
    socket.onopen = () => {
      const watch = this.ride_token === "" ? {} : { ride_token: this.ride_token };
      socket.send(JSON.stringify({ type: "watch", ...watch }));
    };
    socket.onmessage = (event: MessageEvent<string>) => this.receive(event.data);
    socket.onclose = () => this.connectionLost();
  }

  private receive(data: string): void {
    const message = JSON.parse(data) as SceneMessage | Refusal;
    if (message.type === "refused") {
      this.refusal.value = message;
      this.state.value = "refused";
      this.discardSocket();
      return;
    }
    this.attempt = 0;
    this.is_failing.value = false;
    this.last_activity_ms = performance.now();
    this.last_message_ms.value = this.last_activity_ms;
    this.scene.value = nextScene(this.scene.value, message);
    this.state.value = "open";
  }

  private connectionLost(): void {
    if (this.state.value === "refused") return;
    this.discardSocket();
    this.is_failing.value = true;
    this.state.value = this.last_message_ms.value === null ? "connecting" : "lost";
    clearTimeout(this.timer);
    this.timer = window.setTimeout(
      () => this.connect(),
      retryDelay_ms(this.attempt, Math.random()),
    );
    this.attempt += 1;
  }

  private reconnectNow(): void {
    if (this.state.value === "open" || this.state.value === "refused") return;
    clearTimeout(this.timer);
    this.attempt = 0;
    this.connect();
  }

  private visibilityChanged(): void {
    if (document.visibilityState === "visible") this.reconnectNow();
  }

  private checkSilence(): void {
    const is_silent = performance.now() - this.last_activity_ms > SILENT_MS;
    if (this.socket !== null && is_silent) this.connectionLost();
  }

  private discardSocket(): void {
    const socket = this.socket;
    this.socket = null;
    if (socket === null) return;
    socket.onopen = socket.onmessage = socket.onclose = null;
    socket.close();
  }
}
