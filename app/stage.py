"""The live experiment, or a computed run, as one component of Panel. Its parameters are all that both sides tell.

    import panel as pn
    from app.stage import Stage
    from solver import Scene, simulate

    pn.Column("# A punch", Stage(simulate(Scene()))).servable()
    Stage(simulate(Scene())).save("punch.html")

`app.experiment.Experiment(Scene())` is one with sliders.
"""

import html
from pathlib import Path
from typing import IO, Any

import param
from panel.custom import JSComponent

from app import alone, bundle, interface, page
from app.service import packing, worker
from app.session import controls
from app.session.orders import HALF
from solver.scene import LIMITS

# Panel imports a component's scripts as copies, so this one only hands the model over
SCRIPT = """
    export function render({ model }) {
        document.dispatchEvent(new CustomEvent("stage", { detail: model }))
    }
"""
FRAME = '<iframe title="{}" srcdoc="{}" width="960" height="600" style="border: 0; max-width: 100%"></iframe>'
EMPTY, MAKE = "this Stage has no result", "make it by Stage(simulate(Scene()))"
# Parameters of features, which are there before the class: Panel makes its model from them
Features = type("Features", (param.Parameterized,), interface.params())


class Wire(Features, JSComponent):  # type: ignore[misc, valid-type]
    """What server and browser tell each other: of the page of this server, which draws itself.

    A visitor's browser sets the parameters of the second group, {"n": number, field: value}; `orders.read` checks each
    field where it arrives. Several values of one parameter may arrive as the last one.
    """

    # what the browser shows
    run = param.Dict({}, doc="a part of a computed run: run, state, frames, body (bytes, service/packing.py)")
    skeleton = param.Dict({}, doc="a predicted run: acknowledged, or checked; body (bytes, service/skeletons.py)")
    status = param.Dict({}, doc="of values, notes, errors and progress, what has changed")

    # what a visitor asks for
    hello = param.Dict({}, doc="the page is ready for the first run")
    scene = param.Dict({}, doc="parameters by hand: values {name: text}, held")
    release = param.Dict({}, doc="the hand has let go: exact (frames of the exact run, at once)")
    skip = param.Dict({}, doc="end the run and keep its frames")
    restore = param.Dict({}, doc="the scene of an address: values {name: text}")

    _esm = SCRIPT
    # Panel waits 50 ms for other changes, unless they are of these
    _priority_changes = ("scene", "hello", "restore", "release", "skip")  # type: ignore[assignment]


class Stage(Wire):
    """The punch, its curves, its sliders and its player, drawn by app/static/js; or a Result, to be played.

    Example: `pn.Column(Stage(simulate(Scene())))`
    """

    live = param.Boolean(default=True, doc="whether a server answers its sliders; a Result is played alone")

    _bundle = bundle.path()

    def __init__(self, result: Any = None, title: str = "", **params: Any) -> None:
        """result: a Result to show, read-only; title: of its file.

        Raises ValueError for a Result without frames, or for a title that no file can hold.
        """
        self._title, given = _checked(title or page.TITLE), played(result) if result is not None else {}
        super().__init__(**({"sizing_mode": "stretch_width"} | params | given))

    @property
    def _page(self):
        """The file of the Result, or an empty text."""
        return "" if self.live else alone.file_of({"run": self.run, "status": self.status}, self._title)

    def save(self, filename: str | Path | IO, title: str | None = None, **_: Any) -> None:
        """Write the file of the Result. Raises OSError where it cannot be written, ValueError without a Result."""
        if title is not None:
            self._title = _checked(title)
        if not (text := self._page):
            raise ValueError(f"{EMPTY} to save; {MAKE}")
        if isinstance(filename, (str, Path)):
            Path(filename).write_text(text, encoding="utf-8")
        else:
            filename.write(text)

    def _repr_mimebundle_(self, *include: Any, **how: Any) -> Any:
        """Return the file in a frame of a notebook; of a live one what Panel makes of it."""
        if self.live:
            return super()._repr_mimebundle_(*include, **how)
        return {"text/html": self._repr_html_()}, {}

    def _repr_html_(self) -> str:
        """Return the file in a frame of a notebook."""
        if not (text := self._page):
            return f"<p>{EMPTY} to show; {MAKE}</p>"
        return FRAME.format(html.escape(self._title), html.escape(text))


def _checked(title):
    if HALF.search(title):
        raise ValueError(f"title = {title!r} has half of a character; allowed: text that UTF-8 can write; correct it")
    return title


def played(result: Any) -> dict[str, Any]:
    """Return the parameters of a Stage that plays a Result. Raises ValueError without frames."""
    scene, frames = result.scene, list(result.frames)
    if not frames:
        raise ValueError("result has no frames; allowed: at least one; compute a longer run")
    (body,) = packing.packed(scene, list(zip(frames, worker.works(scene, frames)[0], strict=True)), True)
    count = len(frames)
    run = {"run": 1, "state": "finished", "frames": count, "body": body, "sent": 1}
    status = {"state": "finished", "run": 1, "frames": count, "total": count, "why": "", "seconds": 0.0, "known": True}
    status |= {"evaluations": sum(frame.evaluations for frame in frames), "tolerance": scene.tolerance}
    status |= {"residual": max(frame.residual for frame in frames), "errors": {}, "acknowledged": None}
    status |= {"values": controls.values_of(scene), "notes": [*result.notes], "cautions": [*result.cautions]}
    status |= {"preset": "", "address": {}, "words": _words(scene), "sent": 2}
    return {"live": False, "run": run, "status": status}


def _words(scene):
    """Return the parameters of a Scene that are not the usual ones, in words."""
    changed = scene.differences().items()
    return ", ".join(f"{name} = {_value(name, value)}" for name, value in changed) or "the default scene"


def _value(name, value):
    """Return the value of a parameter with its unit."""
    number = f"{value:g}" if isinstance(value, float) else str(value)
    return f"{number} {LIMITS[name].unit}".rstrip() if name in LIMITS else number
