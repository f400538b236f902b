"""Counters and gauges of the server, as text for Prometheus. They have no data of visitors."""

import os
from time import monotonic
from typing import Any

from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram, disable_created_metrics, generate_latest

COUNTERS = {  # counters since the start
    "pages": "pages sent",
    "visits": "visits",
    "rejected_visits": "visits rejected because the server was full",
    "slices": "slices of runs computed",
    "evaluations": "force evaluations in slices of runs",
    "run_cache_hits": "runs found in the cache",
    "run_cache_misses": "runs that were not in the cache",
    "followed": "pictures of predicted runs during drags of sliders",
    "certified": "predicted runs that were checked and are exact",
    "not_certified": "predicted runs that were checked and are not, or not surely",
    "tasks": "calls that workers finished",
    "tasks_lost": "calls that took too long or lost their worker",
    "worker_restarts": "workers replaced",
    "rejected_messages": "rejected messages of browsers: the page sends no such message",
}
disable_created_metrics()
_registry, _begun = CollectorRegistry(), monotonic()
_counters = {name: Counter(f"contact_{name}", meaning, registry=_registry) for name, meaning in COUNTERS.items()}
not_followed = Counter(
    "contact_not_followed", "times a run could not be followed, by reason", ["reason"], registry=_registry
)


def count(name: str, more: float = 1) -> None:
    """Increase a counter of COUNTERS; any thread may call this."""
    _counters[name].inc(more)


def counted(name: str) -> float | None:
    """Return the value of a counter."""
    return _registry.get_sample_value(f"contact_{name}_total")


def gauge(name: str, meaning: str, value: Any) -> None:
    """Register a gauge that calls `value()` for every request."""
    Gauge(f"contact_{name}", meaning, registry=_registry).set_function(value)


def text() -> bytes:
    """Return all metrics in the text format of Prometheus, as bytes."""
    return generate_latest(_registry)


def memory() -> float:
    """Return the resident memory of this process, bytes (Linux; nan elsewhere)."""
    try:
        with open("/proc/self/statm", encoding="ascii") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except OSError:
        return float("nan")


class LoopLag:
    """Lag of the server's event loop: call `record` every EVERY seconds."""

    EVERY = 0.05  # s
    BUCKETS = (0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0)  # s

    def __init__(self, registry: Any = None) -> None:
        meaning = "lag of the server's event loop"
        self.last: float | None = None
        self.lags = Histogram("contact_loop_lag_seconds", meaning, registry=registry, buckets=self.BUCKETS)

    def record(self) -> None:
        """Record the time since the last call minus EVERY."""
        now = monotonic()
        if self.last is not None:
            self.lags.observe(max(0.0, now - self.last - self.EVERY))
        self.last = now


loop_lag = LoopLag(_registry)
gauge("uptime_seconds", "seconds since the start of the server", lambda: monotonic() - _begun)
gauge("memory_bytes", "resident memory of the server's process", memory)
