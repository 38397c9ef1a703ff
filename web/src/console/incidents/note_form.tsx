import { useSignal } from "@preact/signals";
import { useId } from "preact/hooks";
import { texts } from "../texts/texts";

interface NoteFormProps {
  readonly label: string;
  /** Whether the note is stored; the text stays if it is not. */
  readonly onWrite: (text: string) => Promise<boolean>;
}

export function NoteForm({ label, onWrite }: NoteFormProps) {
  const text = useSignal("");
  const id = useId();
  const submit = async (event: Event) => {
    event.preventDefault();
    if (await onWrite(text.value)) text.value = "";
  };
  return (
    <form class="line" onSubmit={(event) => void submit(event)}>
      <label class="visually-hidden" for={id}>
        {label}
      </label>
      <input
        id={id}
        class="input"
        placeholder={label}
        maxLength={500}
        required
        value={text.value}
        onInput={(event) => {
          text.value = event.currentTarget.value;
        }}
      />
      <button class="button">{texts.value.save_note}</button>
    </form>
  );
}
