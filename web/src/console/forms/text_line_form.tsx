import { useSignal } from "@preact/signals";
import { useId } from "preact/hooks";

interface TextLineFormProps {
  readonly label: string;
  readonly button: string;
  /** Returns whether it was taken: only then is the text cleared. */
  readonly onSubmit: (text: string) => Promise<boolean>;
}

/** One line of text and a button. */
export function TextLineForm({ label, button, onSubmit }: TextLineFormProps) {
  const text = useSignal("");
  const id = useId();
  const submit = async (event: Event) => {
    event.preventDefault();
    if (await onSubmit(text.value)) text.value = "";
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
      <button class="button">{button}</button>
    </form>
  );
}
