const LAST_RIDE = "campusloop.ride";

/** The ride that this phone booked last, to find back to it when its tab was closed. */
export function lastRideToken(): string | null {
  return localStorage.getItem(LAST_RIDE);
}

export function rememberRide(token: string): void {
  localStorage.setItem(LAST_RIDE, token);
}

export function forgetRide(token: string): void {
  if (lastRideToken() === token) localStorage.removeItem(LAST_RIDE);
}

const LAST_SERIES = "campusloop.series";

/** The recurring booking that this phone made last, to find back to it. */
export function lastSeriesToken(): string | null {
  return localStorage.getItem(LAST_SERIES);
}

export function rememberSeries(token: string): void {
  localStorage.setItem(LAST_SERIES, token);
}

export function forgetSeries(token: string): void {
  if (lastSeriesToken() === token) localStorage.removeItem(LAST_SERIES);
}
