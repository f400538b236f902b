"""What app/document.py uses of Bokeh beyond its documentation."""

from bokeh.document import Document
from bokeh.io import curdoc
from bokeh.models import Div
from visitor import ended

from app import document


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
