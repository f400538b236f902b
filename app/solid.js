// The page "Inside the solid": asks for the picture of the increment shown, as soon as the one before is there.

const solid = { asked: null, since: 0, scale: {}, drawn: null }
const LOST = 2000 // ms after which a picture that did not come is asked for again
const SOLID_PALETTES = { // black to white, and one that is as good in grey
  fringes: Array.from({ length: 256 }, (_, i) => `#${i.toString(16).padStart(2, "0").repeat(3)}`),
}

function askPicture(again = false) {
  if (sheet.open !== "solid" || !me.run?.length || me.drawn < 0) return
  const wanted = { run: me.run.number, frame: Math.min(me.drawn, me.run.length - 1), half: figure.punch.x_range.end,
    quantity: by("solid-quantity").value, per_fringe: Number(by("solid-fringe").value), mesh: by("solid-mesh").checked }
  const key = JSON.stringify(wanted), now = performance.now()
  if ((solid.asked && now - solid.since < LOST) || (key === solid.drawn && !again)) return
  Object.assign(solid, { asked: key, since: now })
  ask(wanted)
}

function pictured() {
  if (sheet.open !== "solid" || !wire.picture) return
  const buffer = wire.picture, length = new DataView(buffer).getUint32(0, true)
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)))
  const { rows, columns, scale, half, depth, points, quantity, run } = head
  const start = 4 + length, size = rows * columns
  const raw = new Int16Array(buffer.slice(start, start + 2 * size)), lines = buffer.slice(start + 2 * size)
  const image = Float32Array.from(raw, (v) => v * scale)
  solid.drawn = solid.asked
  solid.asked = null
  painted(() => {
    const source = part.solid_field.field.data_source, array = plainData(source).image[0].constructor
    fill("solid_field", "field", { image: [new array(image, [rows, columns])], x: [-half], y: [0], dw: [2 * half], dh: [depth] })
    fill("solid_field", "mesh", { x: new Float32Array(lines, 0, points), z: new Float32Array(lines, 4 * points, points) })
    figure.solid_field.x_range.setv({ start: -half, end: half }, here)
    figure.solid_field.y_range.setv({ start: points ? -0.06 * depth : 0, end: depth }, here)
    shadeSolid(quantity, run, image)
  })
  const unit = quantity === "fringes" ? "" : `largest ${Math.max(...image.map(Math.abs)).toPrecision(3)} GPa`
  by("solid-said").textContent = [unit, points ? `mesh: displacements × ${head.factor}` : ""].filter(Boolean).join("; ")
  askPicture()
}

// Limits grow with the run, so that colours keep their meaning while it is played
function shadeSolid(quantity, run, image) {
  const mapper = part.solid_field.field.glyph.color_mapper
  if (quantity === "fringes") {
    mapper.setv({ low: 0, high: 1, palette: SOLID_PALETTES.fringes }, here)
    return
  }
  const key = `${quantity} ${run}`
  const [low, high] = extent(solid.scale[key] ?? [0, 0], image)
  solid.scale = { [key]: [low, high] }
  const top = quantity === "difference" ? high : Math.max(-low, high)
  const limits = [quantity === "difference" ? 0 : -nice(top), nice(top)]
  mapper.setv({ low: limits[0], high: limits[1], palette: limits[0] < 0 ? shades(...limits) : heat() }, here)
}

const heat = () => SOLID_PALETTES.heat ??= sheet.palette

sheets.solid = { frame: () => askPicture(), opened: () => Object.assign(solid, { asked: null, drawn: null }), closed: () => Object.assign(solid, { asked: null, drawn: null }) }
for (const id of ["solid-quantity", "solid-fringe", "solid-mesh"]) by(id).addEventListener("input", () => {
  by("solid-fringe-row").hidden = by("solid-quantity").value !== "fringes"
  by("solid-fringe-value").textContent = `${Number(by("solid-fringe").value).toFixed(2)} GPa per fringe`
  solid.asked = null
  askPicture(true)
})
