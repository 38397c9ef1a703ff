/** One thing that can be done from the palette. */
export interface PaletteEntry {
  readonly name: string;
  readonly run: () => void;
}

/** Entries that have every term of the query, those that begin with it first. */
export function matchingEntries(
  entries: readonly PaletteEntry[],
  query: string,
): readonly PaletteEntry[] {
  const wanted = query.trim().toLocaleLowerCase();
  const terms = wanted.split(/\s+/).filter(Boolean);
  const found = entries.filter(({ name }) => {
    const text = name.toLocaleLowerCase();
    return terms.every((term) => text.includes(term));
  });
  const rank = ({ name }: PaletteEntry) =>
    wanted !== "" && name.toLocaleLowerCase().startsWith(wanted) ? 0 : 1;
  return [...found].sort((a, b) => rank(a) - rank(b));
}

/** A ride's code has six letters and digits; people write it in groups. */
export function rideCodeIn(query: string): string | null {
  const code = query.replace(/[\s-]/g, "").toUpperCase();
  return /^[A-Z0-9]{6}$/.test(code) ? code : null;
}
