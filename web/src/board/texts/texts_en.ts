/** What a stop board says. */
export const en = {
  title: (stop: string) => `Departures from ${stop}`,
  loading: "Loading the departures…",
  unknown_stop: (stop: string) =>
    `The campus map has no stop “${stop}”. Check the address of this page.`,
  timetable: "Timetable",
  leaves: "Leaves",
  towards: "To",
  expected: "Expected",
  no_departures: "No more departures by timetable today.",
  shuttles: "Shuttles for booked rides",
  shuttle: "Shuttle",
  no_shuttles: "No shuttle is on its way to this stop.",
  here: "Here now",
  any_moment: "Any moment",
  minutes: (minutes: number) => `${minutes} min`,
  minutes_between: (from: number, to: number) => `${from}–${to} min`,
  between: (from: string, to: string) => `${from}–${to}`,
  time_unknown: "Delayed",
  on_schedule: "As planned",
  missed: "Does not run",
  last: "Last departure today",
  seats: (seats: number) =>
    seats === 0 ? "Full" : seats === 1 ? "1 free seat" : `${seats} free seats`,
  book: "Book a ride from here",
  book_hint: "Scan this code with your phone. A booked shuttle waits for you.",
  holiday: (name: string) =>
    name === "" ? "Holiday service today." : `Holiday service today: ${name}.`,
  closed: "No rides can be booked at the moment.",
  closed_until: (time: string) => `No rides can be booked until ${time}.`,
  closes_soon: (time: string) => `Rides can be booked until ${time} today.`,
  stop_closed: "No shuttle serves this stop: its road is closed",
  road_closed: "The road at this stop is closed. Shuttles may be late",
  from: (time: string) => `from ${time}`,
  until: (time: string) => `until ${time}`,
  until_further_notice: "until further notice",
  as_of: (time: string) => `As of ${time}`,
  offline: (time: string) =>
    `No connection since ${time}. Only the timetable is shown; delays are not known.`,
};

export type BoardTexts = typeof en;
