type Texts = Readonly<Record<string, unknown>>;

/** Every key with an example of its text, nested ones as "group.key"; for tests. */
export function textEntries(texts: Texts, prefix = ""): [string, string][] {
  return Object.entries(texts).flatMap(([key, value]): [string, string][] => {
    if (typeof value === "string") return [[prefix + key, value]];
    if (typeof value === "function") return [[prefix + key, String(value(7, 8))]];
    return textEntries(value as Texts, `${prefix}${key}.`);
  });
}
