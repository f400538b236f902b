// ?check: loaded where the address asks for it.

export function connect() {
  if (new URLSearchParams(location.search).has("check")) import("./check.js").then(({ check }) => check())
}
