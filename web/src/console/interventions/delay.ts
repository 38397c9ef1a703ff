/** How much later something comes, in seconds, as whole minutes; less than half a minute is none. */
export function shiftMinutes(later_s: number): number {
  const minutes = Math.round(Math.abs(later_s) / 60);
  return minutes === 0 ? 0 : Math.sign(later_s) * minutes;
}
