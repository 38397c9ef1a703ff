/** A delay in whole minutes, negative if earlier; less than half a minute counts as none. */
export function delayMinutes(later_s: number): number {
  const minutes = Math.round(Math.abs(later_s) / 60);
  return minutes === 0 ? 0 : Math.sign(later_s) * minutes;
}
