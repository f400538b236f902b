// What a browser keeps of this page, in the tab or for good. It may forbid that, as for pages in frames of other sites:
// then nothing is kept, and each visit begins as the first one.

function attempt(call) {
  try {
    return call()
  } catch {
    return null
  }
}

export const kept = (name) => attempt(() => localStorage.getItem(name))
export const keep = (name, value) => attempt(() => localStorage.setItem(name, value))

// Of the tab, for once
export const keepForTab = (name, value) => attempt(() => sessionStorage.setItem(name, value))
export const takeFromTab = (name) => attempt(() => {
  const value = sessionStorage.getItem(name)
  sessionStorage.removeItem(name)
  return value
})
