import type { ComponentChildren } from "preact";
import { useEffect, useLayoutEffect, useRef, useState } from "preact/hooks";

/** Rows above and below what is on the screen, so that a quick scroll shows no gap. */
const SPARE = 6;
/** Fewer rows than this are all drawn: nothing is gained by leaving some out. */
const VIRTUAL_FROM = 60;

interface VirtualRowsProps<T> {
  readonly items: readonly T[];
  readonly keyOf: (item: T) => string;
  readonly children: (item: T) => ComponentChildren;
}

/**
 * A list of rows of one height. Only those on the screen exist; the others are empty space of their height. It
 * does not matter which element scrolls. Screen readers are told each row's place among all.
 */
export function VirtualRows<T>({ items, keyOf, children }: VirtualRowsProps<T>) {
  const list = useRef<HTMLUListElement>(null);
  const row = useRef<HTMLLIElement>(null);
  const [height_px, setHeight] = useState(64);
  const [range, setRange] = useState({ first: 0, last: 30 });
  const is_virtual = items.length >= VIRTUAL_FROM;

  useLayoutEffect(() => {
    const measured_px = row.current?.getBoundingClientRect().height ?? 0;
    if (measured_px > 0 && Math.abs(measured_px - height_px) > 0.5) setHeight(measured_px);
  });

  useEffect(() => {
    if (!is_virtual) return undefined;
    let frame = 0;
    const look = () => {
      frame = 0;
      const box = list.current?.getBoundingClientRect();
      if (box === undefined) return;
      const first = Math.max(0, Math.floor(-box.top / height_px) - SPARE);
      const last = Math.ceil((window.innerHeight - box.top) / height_px) + SPARE;
      setRange((now) => (now.first === first && now.last === last ? now : { first, last }));
    };
    const request = () => {
      if (frame === 0) frame = requestAnimationFrame(look);
    };
    const closing = new AbortController();
    // In the capture phase, because scrolling of an element does not bubble.
    document.addEventListener("scroll", request, { capture: true, signal: closing.signal });
    window.addEventListener("resize", request, { signal: closing.signal });
    look();
    return () => {
      closing.abort();
      cancelAnimationFrame(frame);
    };
  }, [is_virtual, height_px, items.length]);

  const [first, last] = is_virtual
    ? [Math.min(range.first, items.length), Math.min(range.last, items.length)]
    : [0, items.length];
  return (
    <ul
      ref={list}
      class={is_virtual ? "rows virtual" : "rows"}
      style={
        is_virtual
          ? {
              paddingTop: `${first * height_px}px`,
              paddingBottom: `${(items.length - last) * height_px}px`,
            }
          : undefined
      }
    >
      {items.slice(first, last).map((item, index) => (
        <li
          key={keyOf(item)}
          ref={index === 0 ? row : null}
          aria-setsize={items.length}
          aria-posinset={first + index + 1}
        >
          {children(item)}
        </li>
      ))}
    </ul>
  );
}
