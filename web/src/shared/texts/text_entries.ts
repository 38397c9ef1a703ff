type Texts = Readonly<Record<string, unknown>>;

/** Words that make a sentence hard for readers of English as a second language. */
const HARD = /\b(nobody|somebody|whoever|whatever|anew|aboard)\b/i;
const WORDS_MAX = 25;

/** The English texts with a long sentence or a hard word; for tests. */
export function hardTexts(texts: Texts): string[] {
  return textEntries(texts)
    .filter(([, text]) => {
      const sentences = text.split(/[.:;!?](?:\s|$)/);
      return HARD.test(text) || sentences.some((each) => each.split(/\s+/).length > WORDS_MAX);
    })
    .map(([key, text]) => `${key}: ${text}`);
}

/** Every key with an example of its text, nested ones as "group.key"; for tests. */
export function textEntries(texts: Texts, prefix = ""): [string, string][] {
  return Object.entries(texts).flatMap(([key, value]): [string, string][] => {
    if (typeof value === "string") return [[prefix + key, value]];
    if (typeof value === "function") return [[prefix + key, String(value(7, 8))]];
    return textEntries(value as Texts, `${prefix}${key}.`);
  });
}
