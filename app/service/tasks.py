"""What tasks of features for workers share."""

from app.service.caller import Lost
from solver.continuation.state import Outcome

READING, MEMORY = 10.0, 2**30  # s and bytes for a file of a visitor
SLICE = 0.12  # s of work before a call returns a Part, so that other calls get a turn


def failure_of(error: Exception) -> Exception:
    """Return why there is no result, without a full stop: a Lost if that may be the fault of a busy machine."""
    why = f"{error}".rstrip(".")
    return Lost("hang", why) if getattr(error, "outcome", None) is Outcome.OUT_OF_TIME else ValueError(why)
