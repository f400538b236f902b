"""What the research pages share: a scene with sliders, one computation at a time, and the text about its result."""

import asyncio
import logging
from collections.abc import Callable, Coroutine, Iterable, Sequence
from functools import partial
from time import monotonic
from typing import Any

import panel as pn
import param

from app.document import on_loop
from app.features.lab.feature import back, slider_name
from app.features.lab.look import CHART, HEADING, TEXT
from app.features.lab.tasks import tried
from app.service.caller import Lost
from app.service.job import EXACT
from app.service.jobs import jobs
from app.session.controls import CONTROLS, RANGES, changed_scene
from solver import Scene
from solver.live_plots import Curve, chart, draw

log = logging.getLogger("app")
BUG = "It could not be computed. See the server's log, then reload the page."
PAUSE = 0.2  # s without a change of the sliders before a computation begins
APART = 0.5  # s between two drawings of results
CELLS = "td, th { padding: 0.3rem !important }"  # tables fit onto a phone in a wide font, too
SLIDER = {"flex": "1 1 200px", "max-width": "320px"}


def side_by_side(*viewables: Any) -> pn.Row:
    """Return viewables beside each other where there is room for them."""
    return pn.Row(*viewables, sizing_mode="stretch_width", styles={"flex-wrap": "wrap"})


class LabPage(param.Parameterized):
    """A page about a scene. Subclasses have TITLE, STATEMENT, `compute` and `content`."""

    TITLE = STATEMENT = ""
    scene: Any = param.ClassSelector(class_=Scene)
    found = param.Dict({}, doc="{scene: result} of `run`")
    share = param.Number(default=None, allow_None=True, doc="done of the computation, 0..1; None: nothing is computed")
    text = param.String(doc="result in words, or why there is none")

    def __init__(self, scene=None):
        super().__init__(scene=scene or Scene())
        self._task, self._entries, self._follow = None, {}, []

    async def compute(self) -> None:
        """Compute for the scene. A ValueError is shown."""

    def content(self) -> list[Any]:
        """Return the plots and tables, a list of Viewables."""
        return []

    @classmethod
    def view(cls, scene: Scene | None = None) -> pn.viewable.Viewable:
        """Return the page for a Scene (default: the default Scene); it computes as soon as it is shown."""
        return cls(scene).layout()

    def layout(self) -> pn.viewable.Viewable:
        """Return the Viewable of this page."""
        if pn.state.curdoc:
            pn.state.on_session_destroyed(lambda context: self.cancel())
        busy = self.param.share.rx.is_not(None)
        done = pn.bind(lambda share: round(100 * (share or 0)), self.param.share)
        progress = pn.indicators.Progress(value=done, visible=busy)
        cancel = pn.widgets.Button(label="Cancel", on_click=on_loop(self.cancel), visible=busy)
        title = pn.pane.HTML(f"<h1 style='font-size: 18px; margin: 0'>{self.TITLE}</h1>")
        there = [pn.pane.HTML(pn.bind(back, self.param.scene))] if "lab" in pn.state.session_args else []
        heading = [pn.Row(*there, title, styles=HEADING), pn.pane.Markdown(self.STATEMENT)]
        if pn.state.curdoc:
            pn.state.onload(on_loop(self.start))
        else:  # in a notebook
            self.start()
        sliders = side_by_side(*(self._slider(control) for control in CONTROLS))
        look = ["pre { white-space: pre-wrap; font: inherit }"]
        words = pn.pane.Str(self.param.text, sizing_mode="stretch_width", stylesheets=look)
        page = pn.Column(*heading, sliders, pn.Row(progress, cancel), words, *self.content())

        self._follow.append(partial(pn.io.push_notebook, page))
        data = [name for name in self.param if name not in ("name", "share", "text")]
        self.param.watch(self._draw_later, data)
        return page

    def chart(self, curves: Callable[[], Sequence[Curve]], x: str, y: str, **look: Any) -> pn.pane.Bokeh:
        """Return the chart of curves(), which follows the parameters of the page; look: as of `live_plots.chart`."""
        plot = chart(curves(), x, y, styles=CHART, **look)
        plot.axis.axis_label_text_font_size = plot.axis.major_label_text_font_size = TEXT
        for legend in plot.legend:
            legend.label_text_font_size = TEXT
        plot.title.text_font_size = TEXT
        self._follow.append(lambda: draw(plot, curves()))
        return pn.pane.Bokeh(plot)

    def table(self, rows: Callable[[], Any]) -> pn.pane.DataFrame:
        """Return a table of rows(), a DataFrame, which follows the parameters of the page."""
        table = pn.pane.DataFrame(rows(), index=False, stylesheets=[CELLS])
        self._follow.append(lambda: setattr(table, "object", rows()))
        return table

    def _draw_later(self, *events):
        for each in self._follow:
            pn.state.execute(on_loop(each), schedule=True)

    def start(self, compute: Callable[[], Coroutine[Any, Any, None]] | None = None) -> None:
        """Compute in place of what is computed now."""
        param.parameterized.async_executor(partial(self._start, compute or self.compute))

    def cancel(self, *events: Any) -> None:
        """End the computation, which frees its worker."""
        if self._task:
            self._task.cancel()
            self._task, self.share, self.text = None, None, "Cancelled."

    async def call(self, function: Callable[..., Any], *arguments: Any, **how: Any) -> Any:
        """Return function(*arguments), computed by a worker; raises Lost, or ValueError where there is no result."""
        return await jobs.result(tried, function, *arguments, owner=id(self), **how)

    async def run(self, task: Callable[[Scene], Any], scenes: Iterable[Scene]) -> None:
        """Set `found` to {scene: task(scene)} as results come; `text` names the scenes without one.

        The scenes are computed by all workers that are free, so that somebody who drags waits for one of them at most.
        """
        found, failed, drawn, scenes = {}, {}, 0.0, list(dict.fromkeys(scenes))

        async def compute(scene):
            try:
                found[scene] = await self.call(task, scene, rank=EXACT)
            except (Lost, ValueError) as error:
                failed[scene] = f"{scene}: {error}."

        async with asyncio.TaskGroup() as group:  # which ends the others where this is cancelled
            tasks = [group.create_task(compute(scene)) for scene in scenes]
            for done, finished in enumerate(asyncio.as_completed(tasks), 1):
                await finished
                self.share = done / len(scenes)
                if monotonic() > drawn + APART or done == len(scenes):
                    self.found, drawn = {scene: found[scene] for scene in scenes if scene in found}, monotonic()
        self.text = " ".join(failed[scene] for scene in scenes if scene in failed)

    def show(self, scene: Scene) -> None:
        """Go to another scene."""
        self.scene = scene
        for name, entry in self._entries.items():
            entry.value = getattr(scene, name)
        self.start()

    async def _start(self, compute):
        self.cancel()
        self._task = task = asyncio.current_task()
        self.param.update(share=0.0, text="")
        try:
            await compute()
        except asyncio.CancelledError:
            return
        except (Lost, ValueError) as error:
            self.text = f"{error}".rstrip(".") + "."
        except Exception:
            log.exception("a research page failed")
            self.text = BUG
        if self._task is task:
            self._task, self.share = None, None

    def _slider(self, control):
        limits, value = RANGES[control.name], getattr(self.scene, control.name)
        look = {"sizing_mode": "stretch_width"}
        step = 0.01 if control.positions[-1] < 10 else 1.0
        name, ends = slider_name(control), {"start": limits.low, "end": limits.high}
        entry = pn.widgets.FloatInput(label=name, value=value, step=step, **ends, **look)
        slider = pn.widgets.IntSlider(end=len(control.positions) - 1, show_value=False, **look)

        def place(event=None):
            slider.value = _closest(control.positions, entry.value)

        def enter(event):
            if event.new != _closest(control.positions, entry.value):  # else the entry has moved the slider
                entry.value = control.positions[event.new]

        place()
        slider.param.watch(enter, "value")
        entry.param.watch(place, "value")
        entry.param.watch(partial(self._change, control.name), "value")
        self._entries[control.name] = entry
        return pn.Column(entry, slider, styles=SLIDER)

    def _change(self, name, event):
        scene, errors = changed_scene(self.scene, {name: f"{event.new!r}"})
        if errors:
            self.text = errors[name]
        elif scene != self.scene:
            self.scene = scene
            self.start(self._compute_later)

    async def _compute_later(self):
        await asyncio.sleep(PAUSE)
        await self.compute()


def _closest(positions, value):
    """Return the index of the position of a slider that is closest to a value."""
    return min(range(len(positions)), key=lambda k: abs(positions[k] - value))
