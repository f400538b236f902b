"""The stability report as plain data, and as tables and diagrams for people."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from .atlas import CENTRE
from .conditioning import Limit
from .document import Document, Section
from .form import Form
from .stability import BAD, GOOD

# Colours of Okabe & Ito
COLOURS = dict(zip(GOOD, ("#0072B2", "#BBBBBB", "#E69F00"), strict=True)) | dict.fromkeys(BAD, "#D55E00")
FRAMES = "unstable", "cautioned", "spectra"  # numbers of `stability.stable`
NOTE = (
    "Every scene is an approach and a short shear. A sample of its frames is rechecked by sums over springs and modes"
    " in long double, which share no code with the solver, and by all growth rates of the frame's disturbances."
)


def counted(results: Iterable[Mapping[str, Any]]) -> dict[str, int]:
    """Scenes per verdict; frames that are unstable, unstable with a caution, and all with a computed spectrum."""
    results = list(results)
    verdicts = {verdict: sum(r["verdict"] == verdict for r in results) for verdict in COLOURS}
    return verdicts | {name: sum(r.get(name, 0) for r in results) for name in FRAMES}


@dataclass(frozen=True)
class Report:
    """The outcomes of the scenes, plain data of `stability.assess`; the closed forms; the limits of floating point."""

    results: list
    forms: list[Form]
    limits: list[Limit]

    @property
    def counts(self) -> dict[str, int]:
        """Those of all scenes."""
        return counted(self.results)

    @property
    def share(self) -> float:
        """Converged scenes over valid ones."""
        return self.counts["converged"] / max(1, len(self.results) - self.counts["refused"])

    @property
    def regions(self) -> dict[str, dict[str, int]]:
        """The counts by what the scenes probe: every axis, and the other parameters in which they differ."""
        names = dict.fromkeys([*CENTRE, *(name for r in self.results for name in r["probed"])])
        groups = {name: [r for r in self.results if name in r["probed"]] for name in names}
        return {name: counted(group) for name, group in groups.items() if group}

    @property
    def failed(self) -> bool:
        """Whether a scene has a bad verdict, a closed form does not hold or a limit is exceeded."""
        bad = any(self.counts[verdict] for verdict in BAD)
        exceeded = any(limit.attained > limit.allowed for limit in self.limits)
        return bad or exceeded or not all(form.held for form in self.forms)

    def data(self) -> dict[str, Any]:
        """Everything as plain types."""
        return {
            "counts": {verdict: self.counts[verdict] for verdict in COLOURS},
            "converged_of_valid": self.share,
            "unstable_frames": {name: self.counts[name] for name in FRAMES},
            "regions": self.regions,
            "closed_forms": [asdict(form) | {"held": form.held} for form in self.forms],
            "conditioning": [asdict(limit) for limit in self.limits],
            "scenes": self.results,
        }

    def document(self) -> Document:
        """The report for people."""
        from pandas import DataFrame  # takes longer to import than the solver

        unstable, cautioned, spectra = (self.counts[name] for name in FRAMES)
        scenes = (
            f"Scenes: {len(self.results)}; converged: {100 * self.share:.2f}% of the valid ones; unstable frames:"
            f" {unstable}, and {cautioned} with a caution, of {spectra} whose spectrum was computed"
        )
        limits = "Conditioning: relative error attained, and by the printed formula in float64 (nan: it overflows)"
        plain = self.data()
        tables = {
            scenes: [{"probed": name} | counts for name, counts in ({"all": self.counts} | self.regions).items()],
            "Closed forms": plain["closed_forms"],
            limits: plain["conditioning"],
            "Scenes that gave up, or worse": _scenes(self.results, ["gave up", *BAD]),
            "Scenes within every range, refused for their combination": _scenes(self.results, ["refused"]),
        }
        sections = [Section(title, DataFrame(map(_texts, rows), dtype=str)) for title, rows in tables.items() if rows]
        start = Section("", lines=[NOTE], figures=lambda: [self._bars(), self._residuals()])
        return Document("Stability on stiff and extreme scenes", [start, *sections])

    def _bars(self):
        """Scenes per region, stacked by verdict."""
        from bokeh.plotting import figure

        regions = self.regions
        names, verdicts = list(regions)[::-1], [verdict for verdict in COLOURS if self.counts[verdict]]
        source = {verdict: [regions[name][verdict] for name in names] for verdict in verdicts} | {"name": names}
        size = {"height": 120 + 18 * len(names), "width": 640}
        shown = figure(y_range=names, x_axis_label="scenes", toolbar_location=None, **size)
        colours = [COLOURS[verdict] for verdict in verdicts]
        shown.hbar_stack(verdicts, y="name", height=0.8, color=colours, source=source, legend_label=verdicts)
        shown.add_layout(shown.legend[0], "right")
        return shown

    def _residuals(self):
        """The recomputed residual over the tolerance, against the force evaluations of the scene."""
        from bokeh.plotting import figure

        some = [r for r in self.results if r.get("residual") and r.get("evaluations")]
        axes = {"x_axis_label": "force evaluations of the scene", "y_axis_label": "recomputed residual / tolerance"}
        shown = figure(height=320, width=460, x_axis_type="log", y_axis_type="log", toolbar_location=None, **axes)
        work, residuals = ([r[name] for r in some] for name in ("evaluations", "residual"))
        shown.scatter(work, residuals, size=4, color=COLOURS["converged"], alpha=0.5)
        return shown


def _scenes(results, verdicts):
    some = [r for r in results if r["verdict"] in verdicts]
    return [{"verdict": r["verdict"], "python -m solver run": r["set"], "reason": r["reason"]} for r in some]


def _texts(row):
    """The row with numbers as text, and nothing for None."""
    shown = {name: f"{value:.1e}" if isinstance(value, float) else value for name, value in row.items()}
    return {name: "" if value is None else str(value) for name, value in shown.items()}
