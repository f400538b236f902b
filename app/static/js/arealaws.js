// The page "Area laws": tables of the fits, and what can be chosen in them.

const small = (value, digits = 3) => (value === undefined || value === null ? "–" : value.toFixed(digits).replace("-", "−"))
const MARKER = ["●", "■", "▲", "◆", "★"] // in the order of MARKS

function cells(row, texts) {
  row.replaceChildren(...texts.map((text) => {
    const cell = document.createElement("td")
    text instanceof Node ? cell.append(text) : (cell.textContent = text)
    return cell
  }))
  return row
}

sheets.arealaws = {
  told(news) {
    by("arealaws-add").hidden = !news.addable
    by("arealaws-cancel").hidden = (news.busy ?? null) === null
    by("arealaws-failures").hidden = !news.failures?.length
    by("arealaws-failures").textContent = news.failures?.join(" ") ?? ""
    const thousand = (value, error) => (value === undefined ? "–" : `${small(1000 * value)} ± ${small(1000 * error)}`)
    by("arealaws-series").replaceChildren(...(news.series ?? []).map((s, k) => {
      const pick = Object.assign(document.createElement("button"), { type: "button", textContent: s.name })
      pick.setAttribute("aria-pressed", s.shown)
      pick.addEventListener("click", () => ask({ what: "show", series: k }))
      const fit = s.done < s.of ? `${s.done} of ${s.of} runs` : s.bend === undefined ? "–" : `${small(-100 * s.bend, 1)} %, ${small(s.r2_beyond, 3)}`
      return cells(document.createElement("tr"), [MARKER[s.mark], pick, thousand(s.tau_c, s.tau_c_error), thousand(s.F_nc, s.F_nc_error), small(s.r2, 4), fit])
    }))
    by("arealaws-rows").replaceChildren(...(news.rows ?? []).map((r) => cells(document.createElement("tr"), [
      small(r.delta_bar, 2), small(1000 * r.L_0), small(1000 * r.A_0, 1), r.zeta === undefined ? "–" : r.zeta.toPrecision(4),
      small(r.r2, 4), small(r.worst, 3), small(r.rise, 2)])))
  },
}
by("arealaws-add").addEventListener("click", () => ask({ what: "add" }))
by("arealaws-cancel").addEventListener("click", () => ask({ what: "cancel" }))
