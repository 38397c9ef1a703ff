interface Hours {
  readonly opens: string;
  readonly closes: string;
}

/** "07:30-12:00, 13:30-22:00" */
export function formatHours(hours: readonly Hours[]): string {
  return hours.map(({ opens, closes }) => `${opens}-${closes}`).join(", ");
}

/** The pairs of times in such a text. It checks nothing: the server refuses invalid times. */
export function parseHours(text: string): { opens: string; closes: string }[] {
  return text
    .split(",")
    .map((part) => part.trim())
    .filter((part) => part !== "")
    .map((part) => {
      const [opens = "", closes = ""] = part.split(/\s*-\s*/);
      return { opens, closes };
    });
}
