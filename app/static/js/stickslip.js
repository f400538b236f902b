// The page "Stick-slip": a click on the map of regimes loads that scene.

sheets.stickslip = {
  told: (news) => { by("stickslip-cancel").hidden = (news.busy ?? null) === null },
  opened() {
    figure.stickslip_map.on_event("tap", ({ x, y }) => {
      if (me.anchor === null) me.anchor = me.run
      ask({ E: 10 ** x, phi_t: 10 ** y })
    })
  },
}
by("stickslip-cancel").addEventListener("click", () => ask({ what: "cancel" }))
