import type { Language } from "./preference";

/** What each problem of the API means for the user, by its code. */
const PROBLEMS: Record<Language, Record<string, string>> = {
  en: {
    offline: "No connection to the server. Check your network and try again.",
    not_json: "This page cannot read the server's answer. Reload the page.",
    server_fault: "The server failed. Try again; if it happens again, contact the operators.",
    payload_invalid: "Something in the form is not valid. Check what you entered.",
    too_many_tries: "Too many tries in a short time. Wait a minute and try again.",
    ride_unknown: "There is no ride with this code or link. Check it, or book a new ride.",
    ride_already_aboard: "You are already on board.",
    ride_not_aboard: "The shuttle has not confirmed yet that you are on board.",
    ride_ended: "This ride has already ended.",
    ride_not_assigned: "No shuttle is assigned to your ride yet. Wait a moment.",
    illegal_transition: "The ride has changed in the meantime. Check its state and try again.",
    party_too_large:
      "One shuttle does not have so many seats. Book several rides for fewer people.",
    party_invalid: "A party has at least one person, and no more wheelchairs than people.",
    same_stop: "Pickup and destination are the same stop. Choose two different ones.",
    no_service:
      "The shuttles do not run at that time, or the service closes before you would arrive. Choose another time.",
    reassignment_refused: "No other shuttle can take this ride. It stays with its shuttle.",
    destination_refused:
      "The shuttle cannot take you there without delaying other passengers. Your ride stays as it was.",
    ride_refused: "No shuttle can take this ride.",
    series_unknown: "There is no recurring booking with this link. Check the link, or book again.",
    series_ended: "This recurring booking has already ended.",
    series_invalid: "There is no ride on the chosen days. Choose other days or a later last day.",
    occurrence_ended: "The ride of this day is already cancelled or over.",
    pattern_unknown: "There is no calendar for a service of this name.",
    pattern_invalid: "The days or hours contradict each other. Check dates, weekdays and times.",
    pattern_in_use:
      "Trips of the timetable use this service. Change its days instead of removing it.",
    exception_unknown: "There is no exception on that day.",
    shifts_invalid: "The shifts contradict each other. Check the times: each ends after it begins.",
    lane_unknown: "The map has no such lane. Check the ids.",
    section_unknown: "The map has no such section. Check the ids.",
    closure_invalid:
      "Choose a road to close. The end must be after the beginning and in the future.",
    closure_unknown: "There is no such closure.",
    closure_over: "This closure has already ended.",
    booking_too_far_ahead: "That is too far ahead. Choose an earlier day.",
    idempotency_mismatch: "This booking was already sent with other details. Book again.",
    no_vehicle_free: "No shuttle can take this ride. Try a later time or a smaller party.",
    campus_unknown: "The campus has no active map. An operator must load one.",
    stop_unknown: "This stop is no longer on the map. Choose another one.",
    stop_unreachable: "No road leads there from your pickup stop. Choose another stop.",
    vehicle_unknown: "No vehicle of this name is enrolled.",
    nobody_aboard: "There are no passengers in this vehicle.",
    vehicle_not_placed: "The vehicle has not reported its position yet.",
    vehicle_out_of_service: "The vehicle is out of service. Return it to service first.",
    vehicle_not_connected:
      "The server cannot reach the shuttle at the moment. Try again in a few seconds.",
    plan_changed: "The plan changed at the same time. Try again.",
    no_resting_place_free: "Every resting place that the vehicle can reach is taken.",
    sections_taken: "The vehicle stands on a road that another vehicle holds.",
    run_unknown: "This run is not stored.",
    run_map_unreadable: "The recording has no map.",
    segment_unknown: "This part of the run is not stored.",
    incident_unknown: "There is no such incident.",
    incident_closed: "This incident is already closed.",
    key_unknown: "The vehicle has no valid key.",
    name_taken: "This name is taken. Choose another one.",
    wrong_credentials: "The name or the password is wrong.",
    session_expired: "Your session has ended. Sign in again.",
    csrf_missing: "Your session could not be confirmed. Reload the page and sign in again.",
    token_unknown: "There is no such token.",
  },
  "zh-CN": {
    offline: "无法连接服务器。请检查网络后重试。",
    not_json: "服务器的回复无法识别，请刷新页面。",
    server_fault: "服务器出错。请重试；若持续出现，请联系调度员。",
    payload_invalid: "填写的内容有误，请检查后再提交。",
    too_many_tries: "尝试次数过多，请一分钟后再试。",
    ride_unknown: "没有找到对应的行程。请检查行程码或链接，或重新预约。",
    ride_already_aboard: "您已经在车上了。",
    ride_not_aboard: "车辆尚未确认您已上车。",
    ride_ended: "此行程已结束。",
    ride_not_assigned: "尚未安排车辆，请稍候。",
    illegal_transition: "行程状态刚刚发生变化，请查看最新状态后重试。",
    party_too_large: "人数超过一辆车的座位数，请分几次预约。",
    party_invalid: "至少一人乘车，且轮椅数不能多于人数。",
    same_stop: "上车站与下车站相同，请选择两个不同的站点。",
    no_service: "该时间不在运营时段内，或运营会在您到达前结束。请选择其他时间。",
    reassignment_refused: "没有这样的车辆可以接手此行程，行程仍由原车辆完成。",
    destination_refused: "改往该站会影响其他乘客，车辆无法前往。您的行程保持不变。",
    ride_refused: "没有车辆可以完成此行程。",
    series_unknown: "没有找到该定期预约。请检查链接，或重新预约。",
    series_ended: "该定期预约已经结束。",
    series_invalid: "所选日期内没有可乘的行程。请另选日期或延后截止日期。",
    occurrence_ended: "这一天的行程已取消或已结束。",
    pattern_unknown: "没有该名称的运营日历。",
    pattern_invalid: "日期或时间互相矛盾，请检查日期、星期和时间。",
    pattern_in_use: "时刻表中仍有班次使用该日历，请修改日期而不是删除。",
    exception_unknown: "该日期没有例外安排。",
    shifts_invalid: "班次相互矛盾，请检查时间：结束须晚于开始。",
    lane_unknown: "地图中没有该车道，请检查编号。",
    section_unknown: "地图中没有该路段，请检查编号。",
    closure_invalid: "请填写要封闭的道路；结束时间须晚于开始时间和当前时间。",
    closure_unknown: "没有该封路记录。",
    closure_over: "该封路已经结束。",
    booking_too_far_ahead: "预约时间太远，请选择较近的日期。",
    idempotency_mismatch: "该预约此前已以不同内容提交，请重新预约。",
    no_vehicle_free: "没有车辆可以完成此行程。请换个时间或减少人数。",
    campus_unknown: "校园尚未启用地图，请联系调度员。",
    stop_unknown: "地图中已没有该站点，请另选一个。",
    stop_unreachable: "从上车站无法到达该站点，请另选一个。",
    vehicle_unknown: "没有登记该车辆。",
    nobody_aboard: "车上没有乘客。",
    vehicle_not_placed: "车辆尚未报告所在位置。",
    vehicle_out_of_service: "车辆已召回，请先恢复运营。",
    vehicle_not_connected: "暂时联系不到车辆，请几秒后重试。",
    plan_changed: "计划刚被他人修改，请重试。",
    no_resting_place_free: "车辆可到达的停靠处均已占用。",
    sections_taken: "车辆所在路段已被另一辆车占用。",
    run_unknown: "没有保存该运行记录。",
    run_map_unreadable: "该记录没有地图。",
    segment_unknown: "没有保存该段运行记录。",
    incident_unknown: "没有该事件。",
    incident_closed: "该事件已被关闭。",
    key_unknown: "车辆没有有效密钥。",
    name_taken: "该名称已被使用，请换一个。",
    wrong_credentials: "用户名或密码不正确。",
    session_expired: "登录已过期，请重新登录。",
    csrf_missing: "无法确认登录状态，请刷新页面并重新登录。",
    token_unknown: "没有该令牌。",
  },
};

/** Adds the texts of problems that only this page's users meet. */
export function addProblemTexts(texts: Record<Language, Readonly<Record<string, string>>>): void {
  for (const language of ["en", "zh-CN"] as const)
    Object.assign(PROBLEMS[language], texts[language]);
}

/** The text for a problem's code; null for an unknown code, whose detail by the server is shown instead. */
export function problemText(code: string, language: Language): string | null {
  return PROBLEMS[language][code] ?? null;
}

export function problemCodes(language: Language): readonly string[] {
  return Object.keys(PROBLEMS[language]);
}
