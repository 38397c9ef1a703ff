import { addProblemTexts } from "../../shared/texts/problem_texts";

// Passengers never meet these: their page is to stay small.
addProblemTexts({
  en: {
    ride_not_ended: "This ride has not ended yet.",
    segment_store_unavailable: "Recorded runs cannot be read now. Try again later.",
    role_missing: "Your roles do not allow this. An admin can change them.",
    operator_unknown: "There is no such operator.",
    last_admin: "This is the last admin. Make another operator admin first.",
    password_change_needed: "Choose your own password first.",
    password_in_settings: "This password is a setting of the server. Change it there.",
    second_factor_needed: "Enter a code of your authenticator first.",
    second_factor_missing: "Set up a second factor on the page Access first.",
    second_factor_locked: "Too many wrong codes. Use a recovery code, or ask another admin.",
    wrong_code: "This code is wrong or was used already.",
    audit_entry_unknown: "There is no such entry.",
    ticket_key_missing: "The server does not have the key of this second factor.",
  },
  "zh-CN": {
    ride_not_ended: "该行程尚未结束。",
    segment_store_unavailable: "暂时无法读取运行记录，请稍后再试。",
    role_missing: "您的角色不允许此操作，可由管理员更改。",
    operator_unknown: "没有该操作员。",
    last_admin: "这是最后一位管理员，请先指定另一位管理员。",
    password_change_needed: "请先设置自己的密码。",
    password_in_settings: "该密码由服务器设置决定，请在那里修改。",
    second_factor_needed: "请先输入验证器的验证码。",
    second_factor_missing: "请先在“接入”页面设置第二因素。",
    second_factor_locked: "验证码错误次数过多，请使用恢复码或联系其他管理员。",
    wrong_code: "验证码错误或已被使用。",
    audit_entry_unknown: "没有该记录。",
    ticket_key_missing: "服务器缺少该第二因素的密钥。",
  },
});
