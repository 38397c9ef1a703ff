/** What the page of figures says. */
export const statisticsEn = {
  statistics: "Statistics",
  figures_until: "Last day",
  stretch: "Show",
  days_shown: (days: number) => (days === 1 ? "this day" : `${days} days`),
  demand: "Demand and service",
  driving: "Driving",
  driving_is_of_a_day: "Driving is shown for the last day alone.",
  figures_cut: "There were more rides than are counted here. Choose fewer days.",
  events_cut:
    "There were more events than are counted here. Takeovers, stops and brakings are at least so many.",
  no_rides_wanted: "No rides were wanted in this time.",
  nothing_driven: "No shuttle drove on this day.",
  rides_and_passengers: (rides: number, passengers: number) =>
    `Rides wanted: ${rides}. Passengers who arrived: ${passengers}.`,
  waited: (half: string, most: string, nearly_all: string) =>
    `Half of the parties waited at most ${half} minutes; 90 %: ${most}; 99 %: ${nearly_all}.`,
  promises_kept: (percent: string) => `${percent} % were picked up in the promised time.`,
  rides_by_hour: "Rides by the hour of the day",
  ride_outcomes: {
    completed: "Completed",
    under_way: "Under way",
    refused: "Refused",
    cancelled: "Cancelled",
    no_show: "Party did not come",
    failed: "Failed",
  },
  hour: "Hour",
  passengers: "Passengers",
  way_from: "From",
  way_to: "To",
  busiest_ways: "Busiest ways",
  numbers_of: (title: string) => `${title}: the numbers`,
  download_csv: "Download as CSV",
  driven: (km: string) => `About ${km} km.`,
  interruptions: (takeovers: number, stops: number, brakings: number) =>
    `Takeovers: ${takeovers}. Minimal-risk stops: ${stops}. Brakings of the gate: ${brakings}.`,
  km_per_takeover: (km: string) => `${km} km for each takeover.`,
  speed_shares: "Speeds while driving, km/h",
  speed_from: "From km/h",
  share_percent: "Share in %",
};
