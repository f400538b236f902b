// The stops of the tour. preset and values: the scene; to: nm of the path at which a stop ends; curve: the one that is
// asked about; shows: the part of *More* that this stop brings; answers: the right one first, shown in `order`;
// springs: whether a picture of them argues the reason; turn: the slider to play with, ask: what to try with it;
// unseen: scenes that nobody has seen, the right answer taken from the run, with why; of: what of its first slip is
// asked, same: what is no difference from a value

export const STOPS = [
  {
    name: "First", preset: "fig6", values: {}, to: 10, order: [1, 0, 2], curve: "forces",
    shows: "lens", springs: true,
    question: "The top is pulled sideways, slowly. What will the friction force do first?",
    answers: ["grow in proportion to the pull", "stay zero until the punch slides", "jump to its full value at once"],
    why: "Nothing slides yet: the punch leans over, and its surface clings to the lattice sites. "
      + "The force is that of a spring.",
    turn: "E", ask: "Move the stiffness: how does the slope change?",
  },
  {
    name: "The edges", preset: "fig7-case2", values: {}, to: 12.5, order: [1, 0, 2], curve: "map",
    shows: "edges",
    question: "Still no slip, but the edges of the contact begin to let go. Which one more?",
    answers: ["the trailing edge, behind", "the leading edge, in front", "both the same"],
    why: "The lean lifts the punch behind and presses it down in front, while the pull weakens the grip of both edges: "
      + "both let go, the trailing edge more.",
    turn: "delta_bar", ask: "Pull instead of pushing (press depth below zero): are the edges more alike?",
  },
  {
    name: "The slip", preset: "fig6", values: {}, to: 20, order: [2, 0, 1], curve: "area",
    question: "The pull goes on until the punch slips. What will the contact area do at the slip?",
    answers: ["grow: contact comes back", "fall", "stay as it is"],
    why: "A slip by one lattice site releases most of the lean that had peeled the edges: they close again, "
      + "and the next stick begins.",
    turn: "phi_ratio", ask: "Weaken the grip: how far does the area come back then?",
  },
  {
    name: "Upwards", preset: "fig7-case1", values: {}, to: 9.1, order: [1, 2, 0], curve: "forces",
    shows: "lens", springs: true,
    question: "The top is held above the surface, so that the punch hangs on its adhesion. Will there be friction?",
    answers: ["yes, even when nothing is repelled any more", "no: friction needs a load",
      "only as long as the area is not zero"],
    why: "Attraction holds each node at its site as well: "
      + "every spring drawn here leans back against the pull, pressed or not.",
    turn: "delta_bar", ask: "Pull farther: when does it let go for good?",
  },
  {
    name: "Oil", preset: "fig7-case3", values: {}, to: 12, order: [0, 2, 1], curve: "area",
    shows: "bands",
    question: "A lubricant leaves a tenth of the grip. What will the slips be like?",
    answers: ["early, and nearly all of the area comes back", "late and large", "there will be none"],
    why: "Little lean is stored before the grip gives way, so little has been peeled, and all of it can come back.",
    turn: "phi_ratio", ask: "Where do the slips disappear altogether?",
  },
  {
    name: "Stiffness", preset: "fig6", values: { E: 700 }, to: 20, order: [2, 1, 0], curve: "forces",
    question: "A punch ten times stiffer. How large is the force at which it slips, in newtons per metre?",
    answers: ["larger", "the same", "smaller"],
    why: "It hardly leans, so that all of the contact gives way together: "
      + "the force is larger, the pull that it takes much smaller.",
    turn: "E", ask: "Compare with a soft one: how much farther must the top be pulled?",
  },
  {
    name: "A rubber band", preset: "fig6", values: { drive_t: 10 }, to: 22, order: [1, 0, 2],
    curve: "forces",
    question: "Now a rubber band pulls the top. It is as stiff as the punch. When will the punch slip?",
    answers: ["after a longer pull, at the same force", "after the same pull, at a smaller force",
      "after a shorter pull, at a larger force"],
    why: "The force at which the contact gives way is the same. To reach it, the band has to be stretched as well.",
    turn: "E", ask: "Move the stiffness of the punch: how little changes once the band is the softer spring?",
  },
  {
    name: "No load", preset: "no-load", values: {}, to: 13, order: [1, 2, 0], curve: "forces",
    question: "The load is held at zero: nothing presses the punch down. How large is the friction when it slips?",
    answers: ["about as large as before", "zero: friction is proportional to load", "a tenth of what it was"],
    why: "Adhesion alone presses the surfaces together. Friction over load is a line that does not begin at zero.",
    turn: "delta_bar", ask: "Move the press depth: is friction zero anywhere while the surfaces hold on to each other?",
  },
  {
    name: "What you have learnt", preset: "fig6", values: {}, to: 20, order: [0, 1, 2], curve: "forces",
    of: "U_s", same: () => 0.1,
    unseen: [
      { values: { E: 140 },
        why: "A stiffer punch builds up force faster, so its springs give way after a shorter pull." },
      { values: { E: 35 },
        why: "A softer punch builds up force more slowly, so its springs give way after a longer pull." },
      { values: { delta_bar: 0.3 }, why: "Pressed deeper, more contact holds it, so it takes a longer pull." },
      { values: { delta_bar: -0.1 }, why: "Held higher, less contact holds it, so a shorter pull is enough." },
      { values: { phi_ratio: 0.5 }, why: "With a weaker grip each spring gives way earlier." },
    ],
    hints: ["A punch sticks like a spring until its springs to the sites give way.",
      "Before that its edges peel, behind more than in front.",
      "A slip by one site brings contact back.", "Adhesion alone can carry friction, without any load."],
    question: "Now {change}, unseen so far. Does it slip after a shorter or a longer pull than {before} nm?",
    answers: ["shorter", "longer", "the same, to a tenth of a nanometre"],
    why: "It slips at {after} nm instead of {before} nm. {reason}",
    turn: "delta_bar",
    ask: "Twelve runs at twelve press depths end the tour: is friction over load a line through zero? Afterwards the "
      + "sliders are yours, and More has the lens, the tractions, the contact area and its map.",
  },
]

const OF_SLIP = { U_s: "U", F_s: "F", L_s: "L", A_s: "A" } // {what a question is about: of an event}
// A value of a first slip; without one nothing holds, and none comes
export const slipValue = (of, slip) => (slip ? slip[OF_SLIP[of]] : of === "U_s" ? Infinity : 0)

export const ASKED = { // {what a question is about: in words}
  U_s: ["How far must the top be pulled until it slips", "nm"], F_s: ["How large is the friction when it slips", "N/m"],
  L_s: ["What is the load when it slips", "N/m"], A_s: ["How large is the contact when it slips", "nm"],
}

// The stop of a question that a teacher has written: what a change does to the first slip of the scene at hand
export function ownStop({ ask, change, base: { preset = "fig6", ...values } }) {
  const [question, unit] = ASKED[ask]
  return {
    name: "A question", preset, values, order: [0, 1, 2], curve: ask === "A_s" ? "area" : "forces",
    of: ask, same: (value) => 0.01 * Math.abs(value), unseen: [{ values: change, why: "" }],
    question: `Now {change}. ${question}, compared with {before} ${unit} before?`,
    answers: ["lower", "higher", "the same, within 1 %"], why: `It is {after} ${unit} instead of {before} ${unit}.`,
    turn: "delta_bar", ask: "The sliders are yours.",
  }
}
