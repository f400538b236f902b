// A class that answers: its code and its numbers on the teacher's screen, the teacher's stop on those of the students.
// Loaded where the address names a class. The questions are those of the tour, or the teacher's own.

import { order, take } from "../channel.js"
import { by, keepForTab, make, readdress, takeFromTab } from "../dom.js"
import { opensElsewhere } from "../address.js"
import { me, view } from "../store.js"
import { follow } from "../tour.js"

const LETTERS = "ABCDEFGHJKLMNPQRSTUVWXYZ" // I and O look like figures
const SECRET = "teacher of "

const asked = () => new URLSearchParams(location.search)

// A code that no class is likely to have
export function openClass() {
  const code = [...crypto.getRandomValues(new Uint8Array(4))].map((byte) => LETTERS[byte % LETTERS.length]).join("")
  readdress((address) => address.set("class", code))
  join()
}

// Join the class that the address names
export function join() {
  const code = asked().get("class").toUpperCase()
  if (!by("lesson")) connect()
  const secret = takeFromTab(SECRET + code)
  order("join", { code, ...(secret && { secret }) })
}

function receive(lesson) {
  const first = !me.lesson
  if (lesson.secret) keepForTab(SECRET + lesson.code, lesson.secret)
  me.lesson = lesson
  const { ask, change } = ownQuestion()
  if (first && lesson.leads && ask && lesson.stop === undefined) order("lead", { stop: 0, phase: "ask", ask, change })
  follow()
}

// The teacher's own question, from the address: ask=F_s&change=phi_ratio:0.5
function ownQuestion() {
  const change = (asked().get("change") ?? "").split(",").map((part) => part.split(":")).filter(([, value]) => value)
  return { ask: asked().get("ask"), change: Object.fromEntries(change) }
}

function tell() {
  const { code, leads, here, answered, stop } = me.lesson
  const link = `${location.origin}${location.pathname}?class=${code}`
  by("lesson").hidden = false
  by("lesson").replaceChildren(make("b", {}, `Class ${code}`), ...(leads ? [
    make("span", {}, opensElsewhere() ? link : "Only this computer opens this address: see Share."),
    make("span", { role: "status" }, `${here} here${stop === undefined ? ". Open the tour to ask"
      : `, ${answered} answered`}`)] : [make("span", {}, "The tour follows your teacher's screen.")]))
}

function connect() {
  by("pins").after(make("section", { id: "lesson", className: "pins", "aria-label": "Class", hidden: true }))
  take("class", receive)
  view(["lesson"], () => { if (me.lesson) tell() })
}
