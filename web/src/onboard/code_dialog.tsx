import { useLayoutEffect, useState } from "preact/hooks";
import { Dialog } from "../shared/ui/dialog";
import { texts } from "./texts/texts";

const DIGITS_MAX = 8;
const KEYS = ["1", "2", "3", "4", "5", "6", "7", "8", "9"];

interface CodeDialogProps {
  readonly title: string;
  readonly lead: string;
  readonly onCode: (code: string) => void;
  readonly onClose: () => void;
}

/** A keypad for a boarding code; the digits of a keyboard work too. */
export function CodeDialog({ title, lead, onCode, onClose }: CodeDialogProps) {
  const t = texts.value;
  const [code, setCode] = useState("");
  const add = (digit: string) => setCode((before) => (before + digit).slice(0, DIGITS_MAX));
  const drop = () => setCode((before) => before.slice(0, -1));
  // Before the next key can come.
  useLayoutEffect(() => {
    const keyPressed = ({ key }: KeyboardEvent) => {
      if (/^\d$/.test(key)) add(key);
      else if (key === "Backspace") drop();
    };
    document.addEventListener("keydown", keyPressed);
    return () => document.removeEventListener("keydown", keyPressed);
  }, []);
  return (
    <Dialog title={title} onClose={onClose}>
      <div class="code-pad">
        <p>{lead}</p>
        <output aria-live="polite">{code || "····"}</output>
        <div class="keys">
          {KEYS.map((digit) => (
            <button key={digit} type="button" class="button" onClick={() => add(digit)}>
              {digit}
            </button>
          ))}
          <button type="button" class="button" onClick={drop}>
            {t.delete_digit}
          </button>
          <button type="button" class="button" onClick={() => add("0")}>
            0
          </button>
          <button
            type="button"
            class="button main"
            disabled={code === ""}
            onClick={() => onCode(code)}
          >
            {t.confirm}
          </button>
        </div>
        <button type="button" class="button" onClick={onClose}>
          {t.close}
        </button>
      </div>
    </Dialog>
  );
}
