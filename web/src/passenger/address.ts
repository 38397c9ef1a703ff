/** What the passenger page shows, kept in the URL's fragment, which no server or log ever sees. */
export type Address =
  | { readonly view: "book" }
  | { readonly view: "ride"; readonly token: string }
  | { readonly view: "find"; readonly code: string };

export function addressFrom(fragment: string): Address {
  const [name, value = ""] = fragment.replace(/^#/, "").split("=", 2);
  if (name === "ride" && /^[A-Za-z0-9_-]{16,128}$/.test(value))
    return { view: "ride", token: value };
  if (name === "code") return { view: "find", code: decodedOr(value, "") };
  return { view: "book" };
}

export function fragmentOf(address: Address): string {
  if (address.view === "ride") return `#ride=${address.token}`;
  return address.view === "find" ? `#code=${encodeURIComponent(address.code)}` : "#";
}

function decodedOr(text: string, otherwise: string): string {
  try {
    return decodeURIComponent(text);
  } catch (error) {
    if (error instanceof URIError) return otherwise;
    throw error;
  }
}
