/** What a passenger sees after the booking form: one file, which is loaded when the form stands. */
export { AnnouncementList } from "../announcements/announcement_list";
export { HelpButton, HelpReceipt } from "../ride/help_call";
export { RideLookupPanel } from "../ride/ride_lookup_panel";
export { RidePanel } from "../ride/ride_panel";
export { deliverKeptCancels, trackRide } from "../ride/ride_tracker";
export { SeriesPanel } from "../series/series_panel";
export { TimetablePanel } from "../timetable/timetable_panel";
