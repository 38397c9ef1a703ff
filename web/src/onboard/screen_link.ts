import { signal } from "@preact/signals";
import { retryDelay_ms } from "../shared/live/backoff";
import type { ScreenRequest, ScreenScene } from "./screen_scene";

/** The vehicle sends at least once a second. */
const SILENT_MS = 5_000;
const WATCHDOG_EVERY_MS = 500;
/** RFC 6455's "service restart": the vehicle drives by another map. */
const ANOTHER_MAP = 1012;

/** The one owner of the screen's websocket. It reconnects for ever: the screen has nobody who reloads it. */
export class ScreenLink {
  readonly scene = signal<ScreenScene | null>(null);
  readonly is_open = signal(false);
  /** Milliseconds since the last message, updated twice a second. */
  readonly silent_ms = signal(Infinity);
  /** The vehicle did not take the last request: too many came. */
  readonly refused = signal(false);

  /** Counts the maps that the vehicle has changed to since the page was opened. */
  readonly map_number = signal(0);

  private socket: WebSocket | null = null;
  private attempt = 0;
  private heard_ms = performance.now();

  constructor(private readonly url: string) {
    this.connect();
    setInterval(() => this.checkSilence(), WATCHDOG_EVERY_MS);
  }

  /** Whether the request was sent; the vehicle's answer is in the next scenes. */
  send(request: ScreenRequest): boolean {
    this.refused.value = false;
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(request));
    return true;
  }

  private connect(): void {
    const socket = new WebSocket(this.url);
    this.socket = socket;
    this.heard_ms = performance.now();
    socket.onopen = () => {
      this.attempt = 0;
      this.is_open.value = true;
    };
    socket.onmessage = ({ data }) => this.received(JSON.parse(String(data)));
    socket.onclose = ({ code }) => {
      if (code === ANOTHER_MAP) this.map_number.value++;
      if (this.socket === socket) this.lost();
    };
  }

  private received(message: ScreenScene | { readonly refused: string }): void {
    this.heard_ms = performance.now();
    this.silent_ms.value = 0;
    if ("refused" in message) this.refused.value = true;
    else this.scene.value = message;
  }

  private checkSilence(): void {
    if (!this.is_open.value) return;
    this.silent_ms.value = performance.now() - this.heard_ms;
    if (this.silent_ms.value > SILENT_MS) this.lost();
  }

  private lost(): void {
    this.is_open.value = false;
    this.silent_ms.value = Infinity;
    const socket = this.socket;
    this.socket = null;
    socket?.close();
    setTimeout(() => this.connect(), retryDelay_ms(this.attempt++, Math.random()));
  }
}
