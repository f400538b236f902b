// A class that answers: its code and its numbers on the teacher's screen, the teacher's stop on those of the students.
// Loaded where the address names a class. The questions are those of the tour, or the teacher's own.

import { originForOthers, opensElsewhere } from "../../static/js/reach.js"
import { order, take } from "../../static/js/channel.js"
import { by, keep, keepForTab, kept, make, readdress, takeFromTab } from "../../static/js/dom.js"
import { me } from "../../static/js/store.js"
import { follow } from "../tour/tour.js"
import { ASKED } from "../tour/stops.js"

const LETTERS = "ABCDEFGHJKLMNPQRSTUVWXYZ" // I and O look like figures
const SECRET = "class secret", ROLE = "role in class"

const asked = () => new URLSearchParams(location.search)
const random = (count) => [...crypto.getRandomValues(new Uint8Array(count))]

// A code that no class is likely to have
export function openClass() {
  if (me.lesson) return
  readdress((address) => address.set("class", random(4).map((byte) => LETTERS[byte % LETTERS.length]).join("")))
  join()
}

// This browser's own, with which a teacher comes back; without storage for this page only
let own = ""
function secret() {
  own ||= kept(SECRET) || random(12).map((byte) => byte.toString(16)).join("")
  keep(SECRET, own)
  return own
}

// Join the class that the address names
export function join() {
  const code = asked().get("class").toUpperCase()
  if (!by("lesson")) connect()
  if (!/^[A-Z]{4}$/.test(code)) return say(`class = ${code}: allowed: four letters A to Z. Open another address.`)
  const [of, was] = (takeFromTab(ROLE) ?? "").split(" ")
  return order("join", { code, secret: secret(), ...(of === code && { was }) })
}

function receive(lesson) {
  const first = !me.lesson, { ask, change } = ownQuestion()
  me.lesson = lesson
  keepForTab(ROLE, `${lesson.code} ${lesson.leads ? "teacher" : "student"}`)
  tell()
  if (first && lesson.leads && ask && lesson.stop === undefined) {
    if (ask in ASKED) return order("lead", { stop: 0, phase: "ask", ask, change })
    return say(`ask = ${ask}: allowed: ${Object.keys(ASKED).join(", ")}. Correct the address.`)
  }
  return follow()
}

// The teacher's own question, from the address: ask=F_s&change=phi_ratio:0.5
function ownQuestion() {
  const change = (asked().get("change") ?? "").split(",").map((part) => part.split(":")).filter(([, value]) => value)
  return { ask: asked().get("ask"), change: Object.fromEntries(change) }
}

function say(text) {
  by("lesson").hidden = false
  by("lesson").append(make("span", { role: "alert" }, text))
}

// What the strip says: texts change in place, so that nobody who hears the page loses the place
function tell() {
  const { code, leads, led, here, answered, stop } = me.lesson, [name, where, numbers] = by("lesson").children
  const link = opensElsewhere() ? `${originForOthers()}${location.pathname}?class=${code}`
    : "Only this computer opens this address. Share shows the command for a class."
  const asks = stop === undefined ? ". Press Tour to ask the first question." : `, ${answered} answered`
  by("lesson").hidden = false
  name.textContent = `Class ${code}`
  where.textContent = leads ? link : led ? "The tour follows your teacher's screen." : "Your teacher's page is closed."
  numbers.textContent = leads ? `${here} here${asks}` : ""
}

function connect() {
  by("above").append(make("section", { id: "lesson", className: "strip", "aria-label": "Class", hidden: true },
    make("b"), make("span"), make("span", { role: "status" })))
  take("lesson", receive)
}
