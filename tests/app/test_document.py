"""What app/document.py uses of Bokeh beyond its documentation."""

import asyncio
from threading import Thread

import panel as pn
from bokeh.document import Document
from bokeh.io import curdoc
from bokeh.models import Div
from bokeh.server.session import ServerSession
from tornado.ioloop import IOLoop
from visitor import ended, waited

from app import document
from app.experiment import Experiment
from app.stage import Wire


def test_models_added_in_a_frozen_document_are_known_afterwards():
    doc = Document()
    with document.frozen(doc):
        doc.add_root(Div(name="one"))
        doc.add_root(Div(name="two"))
    assert [doc.get_model_by_name(name).name for name in ("one", "two")] == ["one", "two"]


def test_a_destroyed_document_makes_no_call_and_raises_nothing():
    doc, calls = Document(), []
    document.later(doc, lambda: calls.append(1))
    (callback,) = doc.session_callbacks
    ended(callback.callback())
    doc.callbacks.destroy()
    document.later(doc, lambda: calls.append(2))
    del doc
    assert calls == [1] and curdoc() is not None


def test_panel_knows_the_document_of_what_a_worker_has_caused_to_be_sent():
    """Else it puts the change off until the next callback, and others overtake it: findings/panel-coroutine-..."""

    async def visit():
        doc, known = Document(), asyncio.Queue()
        experiment = Experiment(doc=doc, stage=Wire())
        experiment.stage.param.watch(lambda change: known.put_nowait(pn.state.curdoc is doc), "status")
        ServerSession("visitor", doc, io_loop=IOLoop.current())
        worker = Thread(target=document.later, args=(doc, lambda: experiment.send("status", run=1)))
        worker.start()
        return await known.get()

    assert waited(visit())
