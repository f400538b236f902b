"""The stability report as text, as plain data, and as a page that opens offline."""

from dataclasses import asdict, dataclass
from html import escape
from typing import Any

from .. import html_page
from .atlas import CENTRE
from .conditioning import Limit
from .form import Form
from .stability import BAD, GOOD

# Colours of Okabe & Ito
COLOURS = dict(zip(GOOD, ("#0072B2", "#BBBBBB", "#E69F00"), strict=True)) | dict.fromkeys(BAD, "#D55E00")
NOTE = (
    "Every scene is an approach and a short shear. A sample of its frames is rechecked by sums over springs and modes"
    " in long double, which share no code with the solver, and by all growth rates of the frame's disturbances."
)


@dataclass(frozen=True)
class Group:
    """Outcomes of some scenes, as plain data of `stability.assess`."""

    results: list

    @property
    def counts(self) -> dict[str, int]:
        """Scenes per verdict, of all verdicts."""
        return {verdict: sum(r["verdict"] == verdict for r in self.results) for verdict in COLOURS}

    @property
    def frames(self) -> dict[str, int]:
        """Frames that are unstable, those that report possible flutter themselves, and all whose spectrum is known."""
        names = {"unstable": "unstable", "said": "said", "judged": "spectra"}
        return {name: sum(r.get(key, 0) for r in self.results) for name, key in names.items()}

    @property
    def share(self) -> float:
        """Converged scenes over valid ones."""
        return self.counts["converged"] / max(1, len(self.results) - self.counts["refused"])


@dataclass(frozen=True)
class Report:
    """The outcomes of the scenes, the closed forms, and the limits of floating point."""

    results: list
    forms: list[Form]
    limits: list[Limit]

    @property
    def all(self) -> Group:
        """Every scene."""
        return Group(self.results)

    @property
    def regions(self) -> dict[str, Group]:
        """The scenes by what they probe: every axis, and the other parameters in which they differ."""
        names = dict.fromkeys([*CENTRE, *(name for r in self.results for name in r["probed"])])
        groups = {name: Group([r for r in self.results if name in r["probed"]]) for name in names}
        return {name: group for name, group in groups.items() if group.results}

    @property
    def failed(self) -> bool:
        """Whether a scene has a bad verdict, a closed form does not hold or a limit is exceeded."""
        bad = any(self.all.counts[verdict] for verdict in BAD)
        exceeded = any(limit.attained > limit.allowed for limit in self.limits)
        return bad or exceeded or not all(form.held for form in self.forms)

    def data(self) -> dict[str, Any]:
        """Everything as plain types."""
        return {
            "counts": self.all.counts,
            "converged_of_valid": self.all.share,
            "unstable_frames": self.all.frames,
            "regions": {name: group.counts | group.frames for name, group in self.regions.items()},
            "closed_forms": [asdict(form) | {"held": form.held} for form in self.forms],
            "conditioning": [asdict(limit) for limit in self.limits],
            "scenes": self.results,
        }

    def text(self) -> str:
        """The tables for a terminal."""
        shown = [f"{title}\n{frame.to_string(index=False, justify='left')}\n" for title, frame in self.tables().items()]
        return "\n".join(shown)

    def tables(self) -> dict:
        """{title: DataFrame of text} of the whole report, without those that are empty."""
        from pandas import DataFrame  # takes longer to import than the solver

        unstable, said, judged = self.all.frames.values()
        scenes = (
            f"Scenes: {len(self.results)}; converged: {100 * self.all.share:.2f}% of the valid ones; unstable frames:"
            f" {unstable}, and {said} with a caution, of {judged} whose spectrum was computed"
        )
        limits = "Conditioning: relative error attained, and by the printed formula in float64 (nan: it overflows)"
        lost = [r for r in self.results if r["verdict"] not in ("converged", "refused")]
        refused = [r for r in self.results if r["verdict"] == "refused" != r["kind"]]
        tables = {
            scenes: [_of_group(name, group) for name, group in ({"all": self.all} | self.regions).items()],
            "Closed forms": [_of_form(form) for form in self.forms],
            limits: [_of_limit(limit) for limit in self.limits],
            "Scenes that gave up, or worse": [_of_scene(r) for r in lost],
            "Scenes within every range, refused for their combination": [_of_scene(r) for r in refused],
        }
        return {title: DataFrame(rows) for title, rows in tables.items() if rows}

    def write_page(self, file) -> None:
        """Write the tables and two diagrams as one HTML file; raises OSError."""
        parts = [f"<h1>Stability on stiff and extreme scenes</h1><p>{NOTE}</p>", self._bars(), self._residuals()]
        for title, frame in self.tables().items():
            table = html_page.table(frame, "words" if len(frame.columns) < 5 else None)
            parts.append(f"<h2>{escape(title)}</h2>{table}")
        html_page.write_page(file, "Stability of the contact solver", *parts)

    def _bars(self):
        """Scenes per region, stacked by verdict."""
        from bokeh.plotting import figure

        names = list(self.regions)[::-1]
        counts = [self.regions[name].counts for name in names]
        verdicts = [verdict for verdict in COLOURS if any(count[verdict] for count in counts)]
        source = {verdict: [count[verdict] for count in counts] for verdict in verdicts} | {"name": names}
        size = {"height": 120 + 18 * len(names), "width": 1000}
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
        shown = figure(height=320, width=1000, x_axis_type="log", y_axis_type="log", toolbar_location=None, **axes)
        work, residuals = ([r[name] for r in some] for name in ("evaluations", "residual"))
        shown.scatter(work, residuals, size=4, color=COLOURS["converged"], alpha=0.5)
        return shown


# Each of these is one row of a table, {header: text}.


def _of_group(name, group):
    unstable = "{}, {} of {}".format(*group.frames.values())
    return {"probed": name} | group.counts | {"unstable frames, with a caution": unstable}


def _of_form(form):
    numbers = {"error": f"{form.error:.1e}", "allowed": f"{form.tolerance:.0e}", "held": "yes" if form.held else "NO"}
    return {"form": form.name} | numbers | {"reason for what is allowed": form.reason, "source": form.source}


def _of_limit(limit):
    printed = "" if limit.textbook is None else f"{limit.textbook:.1e}"
    return {"where": limit.name, "attained": f"{limit.attained:.1e}", "as printed": printed, "remedy": limit.remedy}


def _of_scene(result):
    return {"verdict": result["verdict"], "python -m solver run": result["set"], "reason": result["reason"]}
