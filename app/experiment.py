"""The experiment of a visitor: runs what the browser asks for, and publishes the status of the run.

A Stage has all that server and browser tell each other. Each parameter that a browser sets goes to the method declared
for it by `@order`.
"""

import logging
from collections.abc import Callable, Sequence
from functools import partial
from itertools import count
from typing import Any

import panel as pn
import param
from bokeh.document import Document
from bokeh.models import CustomJS, Div
from panel.viewable import Viewer

from app import document, interface, page
from app.document import on_loop
from app.service import metrics
from app.service.jobs import Jobs
from app.service.jobs import jobs as shared_jobs
from app.service.worker import KERNELS
from app.session import controls, orders
from app.session.orders import order, orders_of
from app.session.pursuit import Pursuit
from app.session.run import Request, Run
from app.stage import Stage, Wire
from solver import Scene, SceneError

pn.config.browser_info = False  # else every document has a component more, which tells of the browser
log = logging.getLogger("app")
LOOK = 1000  # ms between two updates of waiting visitors
OF_THE_RUN = "hello", "scene", "restore", "release", "skip"  # orders without which there is no run
controls.FOR_SERVER |= interface.names("READS")
controls.FOR_BROWSER |= interface.names("KEEPS")
_failed: set[tuple[str, str]] = set()  # (feature, method) that the log has
visitors = set()  # of this process; Panel's own count is late


class Experiment(Viewer):
    """What one visitor sees and changes, on a page or in a layout of Panel. `scene` may be watched, bound and set.

    Example: `pn.Column("# A punch", Experiment(Scene(E=100.0)))`

    A scene too large for a browser raises SceneError. Every method runs under the lock of the visitor's document.
    """

    scene: Any = param.ClassSelector(class_=Scene, doc="as the controls have it")
    preset = param.String(doc="name of the preset that the scene began with")
    notes = param.List(item_type=str, doc="on how an address, an entry or a file was read")
    errors = param.Dict({}, doc="{parameter: why its entry was refused}")

    def __init__(
        self,
        scene: Scene | None = None,
        *,
        doc: Document | None = None,
        arguments: Any = None,
        jobs: Jobs = shared_jobs,
        stage: Wire | None = None,
    ) -> None:
        """scene: the first one; else that of the arguments {name: [bytes]} of an address. doc: that of a page."""
        controls.refuse_large(scene or Scene())
        addressed, preset, notes = controls.scene_from_address(arguments or {})
        super().__init__(scene=scene or addressed, preset=preset, notes=notes)
        self.doc, self.jobs, self.closed = doc or pn.state.curdoc or document.kernel(), jobs, False
        self.stage = stage or Stage()
        self._own = self.scene  # as it was set here: another one was set by somebody else
        self.own = ""  # id of the Stage's model in the document
        self.sent = count(1)  # numbers messages, as a parameter that is set to what it is sends nothing
        self.acknowledged = None  # number of the last order: the browser ignores older values
        self.status = {}  # as sent last
        self.features = {name: made(self) for name, made in interface.classes().items()}
        self.pursuit = Pursuit(self)
        self.orders = orders_of(self, self.pursuit, *self.features.values())
        self.stage.param.watch(self._heed, [*self.orders])
        if doc is None and self.doc is not None:  # on a page of somebody else's
            if isinstance(self.doc, Document):  # a notebook ends with its process
                self.doc.on_session_destroyed(lambda session_context: self.close())
            self.doc.add_periodic_callback(on_loop(self.look), LOOK)
        visitors.add(self)
        metrics.count("visits")
        log.info("visitor arrived, now %d", len(visitors))

    def __panel__(self) -> Wire:
        return self.stage

    def close(self) -> None:
        """Cancel every call: the visitor left."""
        if not self.closed:
            self.closed = True
            self.pursuit.close()
            self.tell("close")
            visitors.discard(self)
            log.info("visitor left, now %d, slices in flight %d", len(visitors), self.jobs.pool.in_flight)

    def tell(self, what: str, *values: Any) -> list[Any]:
        """Call a method of every feature and return the results. A failure is logged once; run and page go on."""
        found = []
        for name, feature in self.features.items():
            if what != "close" and getattr(type(feature), what) is getattr(interface.Feature, what):
                continue  # it does nothing there
            try:
                found.append(getattr(feature, what)(*values))
            except Exception:
                if (name, what) not in _failed:  # at every status it would flood the log
                    log.exception("the feature %s failed: %s", name, what)
                _failed.add((name, what))
        return found

    def send(self, kind: str, **content: Any) -> None:
        """Set a parameter of the Stage to a dictionary, whose values are those of JSON, or bytes."""
        if not self.closed:
            with document.current(self.doc):
                self.stage.param.update({kind: content | {"sent": next(self.sent)}})

    def may_change(self, model: str, attribute: str) -> bool:
        """Whether the browser may set an attribute of the model with this id: of the Stage, what has an order."""
        return model == self.own and attribute in self.orders

    def later(self, call: Callable[[], object]) -> None:
        """Make a call under the lock of the document, unless the visitor has left; any thread may call this."""
        if not self.closed:
            document.later(self.doc, lambda: None if self.closed else call())

    # orders from the browser

    def _heed(self, *events: param.parameterized.Event) -> None:
        """Obey what the browser has set, in the order of its numbers: Panel may pass on several in any order.

        Until the page is loaded Panel drops what is sent to it.
        """
        given = [event for event in events if event.new and not self.closed]
        # Panel may set parameters in a thread, or in a notebook's message; a file is forgotten not before they are set
        now = not isinstance(self.doc, document.Kernel) and pn.state.loaded and pn.config.nthreads is None
        now = now and not any("content" in event.new for event in given)
        for event in sorted(given, key=lambda event: n if orders.is_number(n := event.new.get("n")) else 0):
            call = partial(self.obey, event.name, event.new)
            call() if now else pn.state.onload(on_loop(self.later, call))

    def obey(self, name: str, given: Any) -> None:
        """Run an order {"n": number, field: value} of the browser. Each is acknowledged, even a rejected one.

        A picture acknowledges its own order. Until then the browser sends no newer position of the slider.
        """
        pictured = False
        if orders.is_number(given.get("n")):
            self.acknowledged = given["n"]
        try:
            if "content" in given:
                with document.current(self.doc):
                    self.stage.param.update({name: {}})  # nothing keeps a file
            method, values = orders.read(self.orders[name], given)
            method(**values)
            pictured = bool(values.get("held")) and self.pursuit.state == "following"
        except orders.Refused as refused:
            metrics.count("rejected_messages")
            self.notes = [f"{refused}{controls.STAYS}"]
        except Exception:
            if name in OF_THE_RUN:
                self.pursuit.fail_unexpectedly()
            else:
                log.exception("the order %s failed", name)
                self.notes = [f"An error of the server, which its log describes. {controls.STAYS.strip()}"]
        if not pictured:
            self.publish()

    @order("hello")
    def hello(self) -> None:
        """Start the first run: the page is ready."""
        self.pursuit.request(Request(self.scene))

    @order("scene", values=orders.are_entries, held=orders.is_flag)
    def change(self, values: dict[str, Any], held: bool = False) -> None:
        """Change parameters {name: text}. Each invalid one leaves a message, and the run on screen stays.

        held: a slider is held: predicted runs follow it.
        """
        self.notes = []
        scene, self.errors = controls.changed_scene(self.scene, values, self.notes)
        if scene == self.scene:
            self.publish()
        else:
            self._own = self.scene = scene
            self.pursuit.request(Request(scene, held, self.acknowledged))

    @order("restore", values=orders.is_address)
    def restore(self, values: dict[str, Any]) -> None:
        """Show the scene of an address {name: text}; an empty one means the default preset."""
        scene, preset, notes = controls.scene_from_address({name: [text.encode()] for name, text in values.items()})
        self.show(scene, preset, notes)

    def show(self, scene: Scene, preset: str, notes: Sequence[str] = ()) -> None:
        """Show another scene, based on `preset`, with notes on how it was read."""
        self.tell("replaced")
        self._own = self.scene = scene
        self.preset, self.errors, self.notes = preset, {}, [*notes]
        self.pursuit.request(Request(scene))

    @param.depends("scene", watch=True)
    def _heed_scene(self) -> None:
        """Show a scene that somebody has set; raises SceneError, and keeps the one before, if it is too large."""
        if self.scene is not self._own:
            try:
                controls.refuse_large(self.scene)
            except SceneError:
                self.scene = self._own
                raise
            self.show(self.scene, self.preset)

    @property
    def run(self) -> Run | None:
        """The run on screen, or None."""
        return self.pursuit.run

    def look(self) -> None:
        """Publish place in the queue and compiled kernels, and answer orders whose picture waits; once a second."""
        if not self.closed and self.pursuit.state != "idle":
            self.later(self.publish)

    def publish(self) -> None:
        """Send what has changed of status, values, notes and errors to the browser."""
        run, position = self.run, self.pursuit.position
        if run is None:
            return
        waits = [f"{position} before you in the queue of the server."] if position else []
        own: dict[str, Any] = {"values": controls.values_of(self.scene), "acknowledged": self.acknowledged}
        own |= {"errors": self.errors, "preset": self.preset}
        own |= {"address": controls.address_of(self.scene, self.preset)}
        own |= {"compiled": (min(self.jobs.pool.compiled, KERNELS), KERNELS) if run.state == "warming" else None}
        own |= {"notes": self.notes + waits, "cautions": self.pursuit.cautions}
        for more in self.tell("status"):
            own |= more
        status = run.status() | own
        news = {name: value for name, value in status.items() if name not in self.status or self.status[name] != value}
        if news:
            self.status = status
            self.send("status", **news)


def serve() -> None:
    """Add a visitor's Stage to the current document."""
    doc = pn.state.curdoc
    try:
        experiment = Experiment(doc=doc, arguments=pn.state.session_args, stage=Wire())
        doc.on_session_destroyed(lambda session_context: experiment.close())
        add_to(doc, experiment.stage)
        experiment.own = doc.roots[0].data.id
    except Exception:  # otherwise the visitor would wait forever
        log.exception("the page could not be built")
        doc.clear()
        doc.add_root(Div(text="The experiment could not be opened. See the server's log, then reload the page."))


def add_to(doc: Document, stage: Wire) -> None:
    """Add the parameters of the page to a document."""
    with document.frozen(doc):
        stage.server_doc(doc, title=page.TITLE, location=False)
        doc.roots[0].stylesheets = []  # of Panel: the component itself shows nothing
    doc.config.update(reconnect_session=False, notifications=None, notify_connection_status=False)
    doc.js_on_event("connection_lost", CustomJS(code="document.dispatchEvent(new Event('connection-lost'))"))


def example(doc: Document) -> None:
    """Add what a visitor's document has to another one."""
    pn.extension()  # once, as it takes a sixth of what a document does: else scripts of all that Panel knows are loaded
    add_to(doc, Wire())
