// Links to the research pages: each opens with the scene on screen, and the link back from there with what it had.

import { theme } from "../../static/js/colours.js"
import { all } from "../../static/js/dom.js"
import { declared, me } from "../../static/js/store.js"

export function connect() {
  for (const link of all("nav a[data-lab]")) link.addEventListener("click", bringScene)
}

// Of the address, but for the increment and the page that is open beside it
const carried = ([name]) => declared.viewed.includes(name) && !["k", "page"].includes(name)

function bringScene({ currentTarget: link }) {
  const { lab } = link.dataset, own = [...new URLSearchParams(location.search)].filter(carried)
  link.search = new URLSearchParams({ ...Object.fromEntries(own), lab, theme: theme(), ...me.status.address })
}
