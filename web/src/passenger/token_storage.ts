const LAST_RIDE = "campusloop.ride";

/** The ride that this phone booked last, so that the passenger finds it after closing the tab. */
export function lastRideToken(): string | null {
  return localStorage.getItem(LAST_RIDE);
}

export function storeRideToken(token: string): void {
  localStorage.setItem(LAST_RIDE, token);
}

export function removeRideToken(token: string): void {
  if (lastRideToken() === token) localStorage.removeItem(LAST_RIDE);
}

const LAST_SERIES = "campusloop.series";

/** The recurring booking that this phone made last. */
export function lastSeriesToken(): string | null {
  return localStorage.getItem(LAST_SERIES);
}

export function storeSeriesToken(token: string): void {
  localStorage.setItem(LAST_SERIES, token);
}

export function removeSeriesToken(token: string): void {
  if (lastSeriesToken() === token) localStorage.removeItem(LAST_SERIES);
}
