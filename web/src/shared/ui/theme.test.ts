import { readFileSync } from "node:fs";
import { expect, test } from "vitest";

const css = readFileSync(new URL("./theme.css", import.meta.url), "utf8");
const [light_css, dark_css] = css.split("@media (prefers-color-scheme: dark)") as [string, string];

type Theme = ReadonlyMap<string, string>;

function colours(text: string): [string, string][] {
  return [...text.matchAll(/--([a-z-]+):\s*(#[0-9a-f]{6});/g)].map((match) => [
    match[1]!,
    match[2]!,
  ]);
}

const light: Theme = new Map(colours(light_css));
const dark: Theme = new Map([...light, ...colours(dark_css)]);

/** Relative luminance, WCAG 2.2. */
function luminance(hex: string): number {
  const [red, green, blue] = [1, 3, 5].map((at) => {
    const share = parseInt(hex.slice(at, at + 2), 16) / 255;
    return share <= 0.04045 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4;
  }) as [number, number, number];
  return 0.2126 * red + 0.7152 * green + 0.0722 * blue;
}

function contrast(theme: Theme, ink: string, ground: string): number {
  const [a, b] = [luminance(theme.get(ink)!), luminance(theme.get(ground)!)];
  return (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
}

const pairs = [
  ["ink", "paper"],
  ["ink", "surface"],
  ["ink", "sunken"],
  ["ink-soft", "paper"],
  ["ink-soft", "surface"],
  ["ink-soft", "sunken"],
  ["ink-soft", "danger-soft"],
  ["accent", "surface"],
  ["accent", "paper"],
  ["accent", "accent-soft"],
  ["on-accent", "accent"],
  ["on-accent", "accent-deep"],
  ["on-sun", "sun"],
  ["warning", "warning-soft"],
  ["ink", "warning-soft"],
  ["danger", "surface"],
  ["danger", "danger-soft"],
  ["ink", "danger-soft"],
  ["on-danger", "danger"],
  ["on-alarm", "alarm"],
  ["ink", "map-ground"],
] as const;

test.each([
  ["light", light],
  ["dark", dark],
] as const)("every text of the %s theme has the contrast of WCAG AA", (_, theme) => {
  const faint = pairs
    .map(([ink, ground]) => [ink, ground, contrast(theme, ink, ground)] as const)
    .filter(([, , ratio]) => !(ratio >= 4.5));
  expect(faint).toEqual([]);
});
