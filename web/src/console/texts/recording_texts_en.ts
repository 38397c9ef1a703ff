import type { Schemas } from "../../shared/api/client";

type RecordingState = Schemas["RecordingView"]["state"];

/** What the console says of marks and recordings. */
export const recordingEn = {
  recording: "Recording",
  recording_always:
    "The shuttle records always. A mark names this moment. A recording keeps a stretch under a name, in files of its own.",
  mark_note: "Note on this moment",
  mark_now: "Mark",
  marked: "Marked. The shuttle writes it into its file.",
  marked_out_of_reach:
    "Marked on the server only. The shuttle is out of reach: its file gets the mark when it is back.",
  recording_name: "Name of the recording",
  start_recording: "Start recording",
  stop_recording: "Stop recording",
  recording_begun: (name: string, time: string, by: string) => `“${name}”, since ${time} (${by})`,
  recording_out_of_reach:
    "The shuttle is out of reach and has not confirmed this. It hears of it when it is back.",
  recording_states: {
    waiting: "waiting for the shuttle",
    refused: "refused",
    running: "recording",
    stopping: "stopping: waiting for the shuttle",
    ended: "ended, files on their way",
    kept: "complete",
  } satisfies Readonly<Record<RecordingState, string>> as Record<RecordingState, string>,
  recordings: "Recordings",
  recording_file_count: (count: number) =>
    count === 0 ? "none yet" : count === 1 ? "1 file" : `${count} files`,
  files: "Files",
  mark_waits: "not in its file yet",
  mark_refused: "the shuttle did not take it",
  recording_ends: {
    "vehicle.start_recording": "recording begins",
    "vehicle.stop_recording": "recording ends",
  } as Record<string, string>,
};
