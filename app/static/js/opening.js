// Whether the page gets its connection: the server may refuse it after it has sent the page. Loaded before Bokeh.

export const root = document.documentElement // as in dom.js, which comes later
const by = (id) => root.querySelector(`#${id}`)
const PATIENCE = 10_000 // ms until the visitor reads why there is nothing yet

const faults = [] // of scripts, and of files that a script needs
const note = ({ reason, message, target }) =>
  faults.push(reason?.message ?? message ?? (target.src || target.href || "main.js"))
addEventListener("error", note, true)
addEventListener("unhandledrejection", note)

const late = setTimeout(async () => {
  if ("placed" in root.dataset) {
    warn("No answer yet:", "a live experiment computes in Python. In a notebook, wait for the kernel, or run the cell "
      + "again. A saved page computes nothing: show a Stage(result) there.")
    return
  }
  const answer = await fetch(location.href, { cache: "no-store" }).catch(() => null)
  if (answer && !answer.ok) location.reload() // to the server's page that says why
  else warn("Not connected:", causeOf(answer), () => location.reload())
}, PATIENCE)

function causeOf(answer) {
  if (!answer) return "the server does not answer. "
  if (faults.length) return `a script of the page failed (${faults[0]}). `
  return "the websocket does not open. A proxy may block it. "
}

export function opened() {
  clearTimeout(late)
  removeEventListener("error", note, true)
  removeEventListener("unhandledrejection", note)
  by("lost").hidden = true
}

// A line at the top of the page; retry is what its button does from now on, if there is one
let tryNow = null
export function warn(title, text, retry) {
  if (!tryNow) by("retry").addEventListener("click", () => tryNow())
  tryNow = retry
  by("retry").hidden = !retry
  const [name, reason] = by("lost").children
  name.textContent = title
  reason.textContent = text
  by("lost").hidden = false
}
