import type { Schemas } from "../../shared/api/client";
import { formatTimeOrDateTime } from "../texts/times";

type Note = Schemas["NoteView"];

interface NoteListProps {
  readonly notes: readonly Note[];
  readonly titleOf: (note: Note) => string;
  readonly textOf: (note: Note) => string;
}

export function NoteList({ notes, titleOf, textOf }: NoteListProps) {
  return (
    <ol class="history">
      {notes.map((note, index) => (
        <li key={index}>
          <time>{formatTimeOrDateTime(note.happened_at)}</time>
          <span>
            <strong>{titleOf(note)}</strong> {note.by}
          </span>
          <span>{textOf(note)}</span>
        </li>
      ))}
    </ol>
  );
}
