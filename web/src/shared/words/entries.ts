type Words = Readonly<Record<string, unknown>>;

/** Every key with an example of its text, nested ones as "group.key"; for tests. */
export function entriesOf(words: Words, prefix = ""): [string, string][] {
  return Object.entries(words).flatMap(([key, value]): [string, string][] => {
    if (typeof value === "string") return [[prefix + key, value]];
    if (typeof value === "function") return [[prefix + key, String(value(7, 8))]];
    return entriesOf(value as Words, `${prefix}${key}.`);
  });
}
