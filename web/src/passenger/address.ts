/** What the passenger page shows. It is kept in the URL's fragment, which browsers do not send to servers. */
export type Address =
  | { readonly view: "book" }
  | { readonly view: "ride"; readonly token: string }
  | { readonly view: "series"; readonly token: string }
  | { readonly view: "find"; readonly code: string }
  /** A link to a ride or series that was cut off or mistyped: no request could find it. */
  | { readonly view: "broken_link" }
  | { readonly view: "timetable" };

export function addressFrom(fragment: string): Address {
  const [name, value = ""] = fragment.replace(/^#/, "").split("=", 2);
  if (name === "ride" || name === "series") {
    const is_whole = /^[A-Za-z0-9_-]{16,128}$/.test(value);
    return is_whole ? { view: name, token: value } : { view: "broken_link" };
  }
  if (name === "code") return { view: "find", code: decodeOr(value, "") };
  if (name === "timetable") return { view: "timetable" };
  return { view: "book" };
}

export function fragmentOf(address: Address): string {
  switch (address.view) {
    case "ride":
    case "series":
      return `#${address.view}=${address.token}`;
    case "find":
      return `#code=${encodeURIComponent(address.code)}`;
    case "timetable":
      return "#timetable";
    case "broken_link":
    case "book":
      return "#";
  }
}

function decodeOr(text: string, fallback: string): string {
  try {
    return decodeURIComponent(text);
  } catch (error) {
    if (error instanceof URIError) return fallback;
    throw error;
  }
}
