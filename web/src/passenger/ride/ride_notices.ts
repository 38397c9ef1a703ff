import { signal } from "@preact/signals";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { language } from "../../shared/texts/language";

/**
 * off  the passenger has not asked; denied: the browser lets this page show none; failed: the browser's push
 * service gave no subscription
 */
export type NoticesState = "unavailable" | "off" | "asking" | "on" | "denied" | "failed";

const STORED_AS = "campusloop.notices";

/** Browsers have them on secure origins only; an iPhone only once the page is on its home screen. */
const is_supported =
  window.isSecureContext &&
  "serviceWorker" in navigator &&
  "PushManager" in window &&
  "Notification" in window;

/** Messages of the browser's push service about one ride, which come with the page closed too. */
export class RideNotices {
  readonly state = signal<NoticesState>("unavailable");
  readonly problem = signal<Problem | null>(null);
  private key = "";
  private subscription_id = "";

  constructor(private readonly token: string) {
    if (is_supported) void this.load();
  }

  /** Asks the passenger by the browser's own question, then subscribes. */
  async ask(): Promise<void> {
    this.state.value = "asking";
    if ((await Notification.requestPermission()) !== "granted") {
      this.state.value = Notification.permission === "denied" ? "denied" : "off";
      return;
    }
    try {
      await this.tell(await subscription(this.key));
    } catch (failure) {
      if (!(failure instanceof DOMException)) throw failure;
      console.info("the push service gave no subscription", failure);
      this.state.value = "failed";
    }
  }

  async stop(): Promise<void> {
    const path = { token: this.token, subscription_id: this.subscription_id };
    const result = await resultOf(
      api.DELETE("/api/v1/rides/{token}/notices/{subscription_id}", { params: { path } }),
    );
    this.problem.value = result.ok ? null : result.problem;
    if (!result.ok) return;
    localStorage.removeItem(STORED_AS);
    this.state.value = "off";
  }

  private async load(): Promise<void> {
    const key = await resultOf(api.GET("/api/v1/campus/notices"));
    if (!key.ok || key.value.public_key === "") return;
    this.key = key.value.public_key;
    if (Notification.permission === "denied") {
      this.state.value = "denied";
      return;
    }
    const kept = localStorage.getItem(STORED_AS) === this.token ? await keptSubscription() : null;
    // Told again: the server may have forgotten a browser that its push service said was gone.
    if (kept === null) this.state.value = "off";
    else await this.tell(kept);
  }

  private async tell(subscription: PushSubscription): Promise<void> {
    const { endpoint, keys } = subscription.toJSON();
    const result = await resultOf(
      api.PUT("/api/v1/rides/{token}/notices", {
        params: { path: { token: this.token } },
        body: {
          endpoint: endpoint ?? "",
          p256dh: keys?.p256dh ?? "",
          auth: keys?.auth ?? "",
          language: language.peek() === "en" ? "en" : "zh",
        },
      }),
    );
    this.problem.value = result.ok ? null : result.problem;
    this.state.value = result.ok ? "on" : "off";
    if (!result.ok) return;
    this.subscription_id = result.value.subscription_id;
    localStorage.setItem(STORED_AS, this.token);
  }
}

async function keptSubscription(): Promise<PushSubscription | null> {
  const registration = await navigator.serviceWorker.ready;
  return registration.pushManager.getSubscription();
}

/** One that was made with another server's key does not serve for this one. */
async function subscription(key: string): Promise<PushSubscription> {
  const { pushManager } = await navigator.serviceWorker.ready;
  const options = { userVisibleOnly: true, applicationServerKey: key };
  try {
    return await pushManager.subscribe(options);
  } catch (failure) {
    const other = await pushManager.getSubscription();
    if (other === null) throw failure;
    await other.unsubscribe();
    return pushManager.subscribe(options);
  }
}
