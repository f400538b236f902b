"""Compute six scenes by an explicit GFMD and by `fast`, and write docs/benchmark.md: `python docs/benchmark.py`.

GFMD is that of tests/shared/plain_gfmd.py, which shares nothing with the solver but Scene. It halves the increment of a
slip until it is close to the end of the branch. Near that end, U_x is a smooth function of the largest move, with a
maximum at the end: a polynomial through some states gives it. docs/benchmark.json keeps the numbers with commit, date
and processor.
"""

import argparse
import json
import sys
from dataclasses import dataclass
from datetime import date
from pathlib import Path

import numpy as np
from numpy.polynomial import Polynomial

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "tests" / "shared")]
from evidence import output, processor  # noqa: E402
from plain_gfmd import contact, run  # noqa: E402

from solver import Scene, load_path  # noqa: E402

STORE, PAGE = HERE / "benchmark.json", HERE / "benchmark.md"
SMALL = {"nodes": 256, "width": 625.0, "tolerance": 1e-11}
SCENES = {  # name: what differs from the defaults of Scene
    "default": {"u_x_max": 20.0, "tolerance": 1e-11},
    "wavy": {"surface": "wave", "delta_bar": 0.3, "amplitude": 3.0, "u_x_max": 24.0} | SMALL,
    "rough": {"surface": "rough", "delta_bar": 0.0, "seed": 3, "cut_off": 0.1, "u_x_max": 12.0} | SMALL,
    "flat": {"surface": "flat", "delta_bar": 0.1, "phi_ratio": 0.1, "damping": 4.0, "u_x_max": 12.0} | SMALL,
    "soft": {"E": 20.0, "delta_bar": 0.2, "u_x_max": 24.0} | SMALL,
    "held load": {"hold": "load", "delta_bar": 0.4, "u_x_max": 12.0} | SMALL,
}
PARTS = 4  # of u_x_max, at whose ends F, L and A are compared
COLUMNS = ("U_x", "F", "L", "A")  # nm, N/m, N/m, nm
SLIP = 0.5  # nm beyond twice the increment: a larger move is a slip
NEAR = 1e-4  # nm before the end of a branch, where the states for the polynomial begin
STATES, DEGREE = 12, 9  # of them, at distances NEAR, 4 NEAR, 9 NEAR ..., and of the polynomials


@dataclass
class Increment:
    """An increment of `plain_gfmd.run` that collects the ends of branches in `slips`, as rows of COLUMNS."""

    scene: Scene
    slips: list
    U_x: float = 0.0

    def __call__(self, plain, u, U_x, U_z, p0):
        """The Rest at U_x."""
        if U_x <= self.U_x:  # the approach
            return plain.rest(u, U_x, U_z, p0)
        low, begin = self.U_x, u
        while True:
            at, rest = U_x, plain.rest(u, U_x, U_z, p0)
            slipped = self._slips(u, rest.u, at - low)
            while slipped and at - low > 0.5 * NEAR:
                middle = 0.5 * (low + at)
                half = plain.rest(u, middle, U_z, p0)
                if self._slips(u, half.u, middle - low):
                    at, rest = middle, half
                else:
                    low, u = middle, half.u
            if slipped:
                self.slips.append(self._end(plain, begin, low, U_z, p0))
            low, u = at, rest.u
            begin = u
            if at == U_x:
                self.U_x = U_x
                return rest

    def _slips(self, before, after, step):
        return np.abs(after - before).max() > SLIP + 2.0 * step

    def _end(self, plain, u, low, U_z, p0):
        """The end of a branch that is stable at low, from its states below: (U_x, F, L, A)."""
        loads = low - NEAR * (np.arange(STATES, 0, -1) ** 2 - 1.0)
        rests = []
        for load in loads:
            rests.append(plain.rest(rests[-1].u if rests else u, load, U_z, p0))
        move = rests[-1].u - rests[0].u
        along = np.array([float((rest.u * move).sum()) for rest in rests]) / np.sqrt((move**2).sum())
        over = [Polynomial.fit(along, values, DEGREE) for values in (loads, *measured(self.scene, rests))]
        ends = [z.real for z in over[0].deriv().roots() if abs(z.imag) < 1e-6 * abs(z.real)]
        end = min((z for z in ends if z > along[-1]), key=lambda z: z - along[-1])
        return [float(value(end)) for value in over]


def measured(scene, rests):
    """F (N/m), L (N/m) and A (nm) of some Rests."""
    T = np.array([rest.T for rest in rests])
    area = np.array([contact(rest.T[1]) for rest in rests])
    return -T[:, 0].sum(axis=1) * scene.spacing, T[:, 1].sum(axis=1) * scene.spacing, area * scene.width


def places(scene):
    """U_x at which F, L and A are compared."""
    return [scene.u_x_max * (k + 1) / PARTS for k in range(PARTS)]


def rows(scene, frames, slips):
    """{"frames": rows of COLUMNS at `places`, "slips": rows}; frames: (U_x, F_bar, L_bar, A_bar) of the shear."""
    force, table = scene.width * scene.E, np.array(list(frames))
    found = [table[np.abs(table[:, 0] - place).argmin()] for place in places(scene)]
    return {"frames": [[float(v) for v in row * [1.0, force, force, scene.width]] for row in found], "slips": slips}


def by_gfmd(scene):
    """`rows` of the explicit GFMD."""
    slips = []
    records = run(scene, tolerance=scene.tolerance, increment=Increment(scene, slips))
    frames = [(r.load, r.F_bar, r.L_bar, r.A_bar) for r in records if r.stage == "shear"]
    return rows(scene, frames, slips)


def by_fast(scene):
    """`rows` of `fast`."""
    shear = [frame for frame in load_path(scene) if frame.stage == "shear"]
    force = scene.width * scene.E
    events = [event for frame in shear for event in frame.slips if event.kind != "control"]
    slips = [[e.load, e.F_bar * force, e.L_bar * force, e.A_bar * scene.width] for e in events]
    return rows(scene, [(f.U_x, f.F_bar, f.L_bar, f.A_bar) for f in shear], slips)


def digits(ours, theirs):
    """Largest difference of each of COLUMNS over its largest value."""
    ours, theirs = np.array(ours), np.array(theirs)
    return np.abs(ours - theirs).max(axis=0) / np.abs(theirs).max(axis=0)


def section(name, result):
    """Markdown of one scene."""
    given = ", ".join(f"{key}={value!r}" for key, value in result["input"].items())
    lines = [f"## {name.capitalize()}", "", f"`Scene({given})`", ""]
    lines += ["| where | method | U_x (nm) | F (N/m) | L (N/m) | A (nm) |", "|---|---|---|---|---|---|"]
    for part, word in (("frames", "increment"), ("slips", "slip")):
        for k, pair in enumerate(zip(result["gfmd"][part], result["fast"][part], strict=True)):
            for method, row in zip(("GFMD", "fast"), pair, strict=True):
                numbers = " | ".join(f"{value:#.10g}" for value in row)
                lines.append(f"| {word} {k + 1} | {method} | {numbers} |")
    lines += ["", "Largest difference over the largest value:", ""]
    for part in ("frames", "slips"):
        if result["gfmd"][part]:
            off = digits(result["fast"][part], result["gfmd"][part])
            lines.append(f"- {part}: " + ", ".join(f"{c} {v:.0e}" for c, v in zip(COLUMNS, off, strict=True)))
    return "\n".join(lines)


INTRODUCTION = """# Benchmark

Six scenes by two methods, to ten digits. GFMD is the explicit method of the paper (`tests/shared/plain_gfmd.py`); it
shares nothing with the solver but its input. `fast` is the solver's method. `python docs/benchmark.py` computes both
and writes this page; `docs/benchmark.json` has all digits.

Parameters that a scene does not name have the defaults of [the reference](reference.md). An increment is a state of
equilibrium during the shear; a slip is the end of a branch, with F, L and A just before it. GFMD counts A where
T_z > 0. `fast` counts it where T_z exceeds 1e-8 phi_n/delta_n (flats: 1e-3), so that its last digits of A differ.
At the end of a branch F changes infinitely fast with U_x, so that F and L of a slip have fewer digits in common."""


def page(store):
    """The page, a section per scene."""
    where = "Computed at commit {commit}, {date}, {processor}.".format(**store)
    parts = [INTRODUCTION, where, *(section(name, result) for name, result in store["scenes"].items())]
    return "\n\n".join(parts) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"scenes, of {', '.join(SCENES)} (default: all)")
    names = parser.parse_args().names or list(SCENES)
    store = json.loads(STORE.read_text()) if STORE.exists() else {"scenes": {}}
    for name in names:
        scene = Scene(**SCENES[name])
        store["scenes"][name] = {"input": SCENES[name], "gfmd": by_gfmd(scene), "fast": by_fast(scene)}
        print(name, flush=True)
    store["scenes"] = {name: store["scenes"][name] for name in SCENES if name in store["scenes"]}
    commit = output("git", "rev-parse", "--short", "HEAD")
    store |= {"commit": commit, "date": date.today().isoformat(), "processor": processor()}
    STORE.write_text(json.dumps(store, indent=1) + "\n")
    PAGE.write_text(page(store), encoding="utf-8")


if __name__ == "__main__":
    main()
