export type Page = "live" | "rides" | "service" | "incidents" | "runs" | "access";

export interface Place {
  readonly page: Page;
  /** What is looked at within the page: a vehicle, or a vehicle and a boot. */
  readonly parts: readonly string[];
}

const PAGES: readonly Page[] = ["live", "rides", "service", "incidents", "runs", "access"];

export function placeFrom(fragment: string): Place {
  const [name, ...parts] = fragment.replace(/^#\/?/, "").split("/").map(decodeURIComponent);
  const page = PAGES.find((candidate) => candidate === name);
  return page === undefined ? { page: "live", parts: [] } : { page, parts };
}

export function fragmentOf(page: Page, ...parts: string[]): string {
  return `#/${[page, ...parts].map(encodeURIComponent).join("/")}`;
}
