// A Stage of a model of Panel. Rendered again, as by a layout that changes, it moves with all that it shows
const stages = new WeakMap()
// contents: elements and styles; makeStage(root): the modules, run for this Stage (app/bundle.py)
export const renderer = (contents, makeStage) => ({ model, data, el }) => {
  if (!stages.has(data)) stages.set(data, made(model, el, contents, makeStage))
  const { stage, root } = stages.get(data)
  el.replaceChildren(root)
  stage.connect(model)
}

function made(model, el, contents, makeStage) {
  const root = document.createElement("div")
  root.className = "root"
  root.tabIndex = -1 // keys are those of the Stage that was pressed last
  Object.assign(root.dataset, { placed: "", theme: isDark(el) ? "dark" : "light" })
  root.toggleAttribute("data-alone", !model.live)
  root.toggleAttribute("data-sized", model.height !== null || /height|both/.test(model.sizing_mode))
  root.innerHTML = contents.style + contents[model.live ? "placed" : "alone"]
  el.append(root) // so that it has a size
  const stage = makeStage(root)
  stage.start()
  follow(root, stage)
  return { stage, root }
}

// Whether the page around an element is dark: the first ground behind it that is not transparent. It is painted, as a
// colour may be given in any colour space
function isDark(element) {
  const pen = new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true })
  for (let at = element; at; at = at.parentNode ?? at.host) {
    if (!(at instanceof Element)) continue
    pen.clearRect(0, 0, 1, 1)
    pen.fillStyle = getComputedStyle(at).backgroundColor
    pen.fillRect(0, 0, 1, 1)
    const [red, green, blue, alpha] = pen.getImageData(0, 0, 1, 1).data
    if (alpha > 128) return 0.3 * red + 0.59 * green + 0.11 * blue < 128
  }
  return false
}

// Light and dark follow the page, also where it changes
function follow(root, stage) {
  const look = () => {
    const theme = root.parentNode && isDark(root.parentNode) ? "dark" : "light"
    if (theme === root.dataset.theme) return
    root.dataset.theme = theme
    stage.again()
  }
  const observer = new MutationObserver(() => setTimeout(look, 500)) // colours may change in a transition
  for (const element of [document.documentElement, document.body]) observer.observe(element, { attributes: true })
}
