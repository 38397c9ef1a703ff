import type { recordingEn } from "./recording_texts_en";

export const recordingZh: typeof recordingEn = {
  recording: "记录",
  recording_always: "车辆始终在记录。标记用来指明此刻；录制则以名称保留一段，并使用单独的文件。",
  mark_note: "对此刻的说明",
  mark_now: "标记",
  marked: "已标记，车辆会写入它的文件。",
  marked_out_of_reach: "仅在服务器上标记。目前联系不到车辆，恢复后会写入它的文件。",
  recording_name: "录制名称",
  start_recording: "开始录制",
  stop_recording: "停止录制",
  recording_begun: (name, time, by) => `“${name}”，始于 ${time}（${by}）`,
  recording_out_of_reach: "目前联系不到车辆，尚未确认。恢复后会通知它。",
  recording_states: {
    waiting: "等待车辆",
    refused: "被拒绝",
    running: "录制中",
    stopping: "正在停止：等待车辆",
    ended: "已结束，文件上传中",
    kept: "完整",
  },
  recordings: "录制",
  recording_file_count: (count) => (count === 0 ? "暂无" : `${count} 个文件`),
  files: "文件",
  mark_waits: "尚未写入车辆文件",
  mark_refused: "车辆未接受",
  recording_ends: {
    "vehicle.start_recording": "开始录制",
    "vehicle.stop_recording": "停止录制",
  },
};
