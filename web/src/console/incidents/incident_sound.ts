import { effect, signal } from "@preact/signals";

const KEY = "campusloop.console.incident_sound";
const TONES_HZ = [880, 660];
const TONE_S = 0.18;
const LOUDNESS = 0.15;

/** Off until an operator turns it on; kept on this computer. */
export const is_sound_on = signal(localStorage.getItem(KEY) === "on");

effect(() => {
  localStorage.setItem(KEY, is_sound_on.value ? "on" : "off");
});

let context: AudioContext | null = null;

/** Two tones. Browsers allow them after the first click or key on the page. */
export function playIncidentSound(): void {
  context ??= new AudioContext();
  const begin_s = context.currentTime;
  const gain = context.createGain();
  gain.gain.value = LOUDNESS;
  gain.connect(context.destination);
  TONES_HZ.forEach((frequency_hz, number) => {
    const tone = context!.createOscillator();
    tone.frequency.value = frequency_hz;
    tone.connect(gain);
    tone.start(begin_s + number * TONE_S);
    tone.stop(begin_s + (number + 1) * TONE_S);
  });
}

let known: number | null = null;

/** Plays when more incidents wait for an operator than before; not for those that wait when the page opens. */
export function noteUnacknowledged(count: number): void {
  const is_more = known !== null && count > known;
  known = count;
  if (is_more && is_sound_on.peek()) playIncidentSound();
}
