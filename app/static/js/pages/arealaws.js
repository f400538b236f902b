// The page "Area laws": tables of the fits, and what can be chosen in them.

import { ask } from "../channel.js"
import { by, makeButton, makeRow, minus, say } from "../dom.js"

const known = (value) => value !== undefined && value !== null
const small = (value, digits = 3) => (known(value) ? minus(value.toFixed(digits)) : "–")
const thousand = (value, error) => (known(value) ? `${small(1000 * value)} ± ${small(1000 * error)}` : "–")

function seriesRow(s, k) {
  const pick = makeButton({ "aria-pressed": s.shown, onclick: () => ask({ what: "show", series: k }) }, s.name)
  const bend = known(s.bend) ? `${small(-100 * s.bend, 1)} %, ${small(s.r2_beyond, 3)}` : "–"
  return makeRow([s.mark, pick, thousand(s.tau_c, s.tau_c_error), thousand(s.F_nc, s.F_nc_error), small(s.r2, 4),
    s.done < s.of ? `${s.done} of ${s.of} runs` : bend])
}

const fitRow = (r) => makeRow([small(r.delta_bar, 2), small(1000 * r.L_0), small(1000 * r.A_0, 1),
  known(r.zeta) ? r.zeta.toPrecision(4) : "–", small(r.r2, 4), small(r.worst, 3), small(r.rise, 2)])

export function told(news) {
  by("arealaws-add").hidden = !news.addable
  say("arealaws-failures", news.failures?.join(" "))
  by("arealaws-series").replaceChildren(...(news.series ?? []).map(seriesRow))
  by("arealaws-rows").replaceChildren(...(news.rows ?? []).map(fitRow))
}
