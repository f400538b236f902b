// The page "Inside the solid": asks for the picture of the increment shown, as soon as the one before is there.

const solid = { asked: null, since: 0, scale: {}, drawn: null, shown: null } // shown: [quantity, run]
const BENEATH = 0.06 // of the depth, below the picture, for the deformed surface
const LOST = 2000 // ms after which a picture that did not come is asked for again
const SOLID_PALETTES = { // black to white, and one that is as good in grey
  fringes: Array.from({ length: 256 }, (_, i) => `#${i.toString(16).padStart(2, "0").repeat(3)}`),
}

// quantity: what its colours mean: [name of the view, ramp and word for < 0, ramp and word for > 0]; blue is compression,
// as in the contact map, and the shear stress is at the surface what the traction view shows
const SOLID_KEYS = {
  fringes: ["Photoelastic fringes", "", "", "", ""],
  difference: ["Principal difference σ₁ − σ₂", "", "", "cividis", ""],
  normal: ["σ_zz", "squeezes", "compression", "stretches", "tension"],
  mean: ["Mean stress (σ_xx + σ_yy + σ_zz)/3", "squeezes", "compression", "stretches", "tension"],
  shear: ["σ_xz", "pulls", "along +x", "pushes", "against +x; at the surface this is Tₜ"],
}
const RAMPS = { squeezes: "push", stretches: "pull", pulls: "pull", pushes: "push" } // of style.css

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
    figure.solid_field.y_range.setv({ start: points ? -BENEATH * depth : 0, end: depth }, here)
    solid.shown = [quantity, run]
    shadeSolid(image)
    nameSolid(quantity)
    stateStretch()
  })
  const unit = quantity === "fringes" ? "" : `largest ${Math.max(...image.map(Math.abs)).toPrecision(3)} GPa`
  by("solid-said").textContent = [unit, points ? `mesh: displacements × ${head.factor}, the top at rest; stress over the undeformed layer` : ""].filter(Boolean).join("; ")
  askPicture()
}

// What the view shows now, and the key of its colours
function nameSolid(quantity) {
  const [name, below, less, above, more] = SOLID_KEYS[quantity]
  by("solid-name").textContent = name
  by("solid-fringes").hidden = quantity !== "fringes"
  by("solid-scale").hidden = quantity === "fringes"
  by("solid-below").textContent = less
  by("solid-above").textContent = more
  by("solid_field-low").hidden = by("solid-scale").querySelector(".bar").hidden = !below
  const bars = by("solid-scale").querySelectorAll(".bar")
  bars[0].className = `bar ${below}`
  bars[1].className = `bar ${above}`
}

// Limits grow with the run, so that colours keep their meaning while it is played
function shadeSolid(image) {
  const [quantity, run] = solid.shown
  const mapper = part.solid_field.field.glyph.color_mapper
  if (quantity === "fringes") {
    mapper.setv({ low: 0, high: 1, palette: SOLID_PALETTES.fringes }, here)
    return
  }
  const key = `${quantity} ${run}`
  const [low, high] = extent(solid.scale[key] ?? [0, 0], image)
  solid.scale = { [key]: [low, high] }
  const top = nice(Math.max(-low, high)), [, below, , above] = SOLID_KEYS[quantity]
  mapper.setv(below ? shades(-top, top, [RAMPS[below], RAMPS[above]]) : { low: 0, high: top, palette: heat() }, here)
  tellLimits("solid_field", -top, top)
}

const heat = () => SOLID_PALETTES.heat ??= sheet.palette

function forgetPicture() {
  Object.assign(solid, { asked: null, drawn: null, shown: null })
}

sheets.solid = { frame: () => askPicture(), painted: () => { if (solid.shown) shadeSolid([]) }, opened: forgetPicture, closed: forgetPicture }
for (const id of ["solid-quantity", "solid-fringe", "solid-mesh"]) by(id).addEventListener("input", () => {
  by("solid-fringe-row").hidden = by("solid-quantity").value !== "fringes"
  by("solid-fringe-value").textContent = `${Number(by("solid-fringe").value).toFixed(2)} GPa`
  solid.asked = null
  askPicture(true)
})
