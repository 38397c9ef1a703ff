import { useSignal } from "@preact/signals";
import { texts } from "../texts/texts";

/** Copies a link to what is shown. Without a clipboard (a page without TLS) the link is there to be copied. */
export function CopyLink({ href }: { readonly href: string }) {
  const t = texts.value;
  const copied = useSignal("");
  const copy = async (event: Event) => {
    if (navigator.clipboard === undefined) return;
    event.preventDefault();
    await navigator.clipboard.writeText(new URL(href, location.href).href);
    copied.value = href;
  };
  return (
    <a class="button quiet small" href={href} onClick={(event) => void copy(event)}>
      {copied.value === href ? t.link_copied : t.link_to_moment}
    </a>
  );
}
