import { expect, test } from "vitest";
import { noticeFrom, openTicket } from "./notices";

const notice = {
  title: "Shuttle 1 is here",
  body: "It stands at Main Library.",
  tag: "one",
  language: "en",
  address: `/#ride=${"t".repeat(32)}`,
};

test("a notice is what the server sends, and leads to a ticket of this site", () => {
  expect(noticeFrom(JSON.stringify(notice))).toEqual(notice);
  for (const message of [
    undefined,
    "here",
    "null",
    JSON.stringify({ ...notice, title: 1 }),
    JSON.stringify({ ...notice, address: "https://elsewhere.example/" }),
  ])
    expect(noticeFrom(message)).toBeNull();
});

function pages(...urls: readonly string[]) {
  const done: string[] = [];
  const open = urls.map((url) => ({
    url,
    focus: async () => done.push(`focus ${url}`),
    navigate: async (address: string) => done.push(`show ${address}`),
  }));
  const openWindow = async (address: string) => done.push(`open ${address}`);
  return { done, matchAll: async () => open, openWindow };
}

test("a tap shows the ticket in the passenger page that is open", async () => {
  const open = pages("https://campus.example/console", "https://campus.example/#timetable");
  await openTicket(open, notice.address);
  expect(open.done).toEqual(["focus https://campus.example/#timetable", `show ${notice.address}`]);
});

test("a tap opens a page where none is open", async () => {
  const closed = pages("https://campus.example/console");
  await openTicket(closed, notice.address);
  expect(closed.done).toEqual([`open ${notice.address}`]);
});
