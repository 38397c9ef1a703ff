/** A notice about a ride, as the server sends it (server/usecases/rides/notices.py). */
export interface RideNotice {
  readonly title: string;
  readonly body: string;
  /** A notice takes the place of an earlier one with its tag. */
  readonly tag: string;
  readonly language: string;
  /** Of the ticket, on this site. */
  readonly address: string;
}

/** The part of a window that a tap on a notice needs. */
interface OpenPage {
  readonly url: string;
  focus(): Promise<unknown>;
  navigate(address: string): Promise<unknown>;
}

interface OpenPages {
  matchAll(options: { type: "window" }): Promise<readonly OpenPage[]>;
  openWindow(address: string): Promise<unknown>;
}

const TICKET = /^\/#ride=[A-Za-z0-9_-]{16,128}$/;

/** The notice in a push message; null for anything else, which no server of ours has sent. */
export function noticeFrom(message: string | undefined): RideNotice | null {
  if (message === undefined) return null;
  let content: unknown;
  try {
    content = JSON.parse(message);
  } catch (failure) {
    if (failure instanceof SyntaxError) return null;
    throw failure;
  }
  if (typeof content !== "object" || content === null) return null;
  const { title, body, tag, language, address } = content as Record<string, unknown>;
  const parts = [title, body, tag, language, address];
  if (!parts.every((part) => typeof part === "string") || !TICKET.test(address as string))
    return null;
  return content as RideNotice;
}

/** Shows the ticket in the passenger page that is open, or in a new one. */
export async function openTicket(pages: OpenPages, address: string): Promise<void> {
  const open = await pages.matchAll({ type: "window" });
  const page = open.find(({ url }) => new URL(url).pathname === "/");
  if (page === undefined) {
    await pages.openWindow(address);
    return;
  }
  await page.focus();
  await page.navigate(address);
}
