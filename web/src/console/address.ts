export type Page =
  "live" | "rides" | "service" | "maps" | "incidents" | "runs" | "statistics" | "audit" | "access";

export interface Address {
  readonly page: Page;
  /** What the page shows: a vehicle, or a vehicle and a boot. */
  readonly ids: readonly string[];
}

export const PAGES: readonly Page[] = [
  "live",
  "rides",
  "service",
  "maps",
  "incidents",
  "runs",
  "statistics",
  "audit",
  "access",
];

export function addressFrom(fragment: string): Address {
  const [name, ...ids] = fragment.replace(/^#\/?/, "").split("/").map(decodeURIComponent);
  const page = PAGES.find((candidate) => candidate === name);
  return page === undefined ? { page: "live", ids: [] } : { page, ids };
}

export function fragmentOf(page: Page, ...ids: string[]): string {
  return `#/${[page, ...ids].map(encodeURIComponent).join("/")}`;
}
