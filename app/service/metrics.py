"""What the server counts and what it can tell of its state, as text for Prometheus; nothing here names a visitor."""

import os
from time import monotonic

from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram, disable_created_metrics, generate_latest

KNOWN = {  # counted since the start
    "pages": "pages sent",
    "visits": "visitors who came",
    "turned_away": "visitors for whom there was no room",
    "slices": "slices of runs computed",
    "evaluations": "force evaluations in them",
    "shelf_hits": "runs that were known already",
    "shelf_misses": "runs that had to be computed",
    "followed": "pictures of runs that followed a hand on a slider",
    "agreed": "runs that were as followed: slips to 1e-4 nm, F to 1e-3 of its largest",
    "disagreed": "runs that were not",
    "tasks": "tasks done by workers",
    "tasks_lost": "tasks that took too long or whose worker ended",
    "worker_restarts": "workers replaced",
    "refused_messages": "messages of browsers that were none of the page's",
}
disable_created_metrics()
_registry, _begun = CollectorRegistry(), monotonic()
_counters = {name: Counter(f"contact_{name}", said, registry=_registry) for name, said in KNOWN.items()}
not_followed = Counter(
    "contact_not_followed", "times a run could not be followed, by reason", ["reason"], registry=_registry
)


def count(name, more=1):
    """Count something of KNOWN, in any thread."""
    _counters[name].inc(more)


def counted(name):
    """How often it was counted."""
    return _registry.get_sample_value(f"contact_{name}_total")


def gauge(name, said, value):
    """Have `value()` told whenever somebody asks."""
    Gauge(f"contact_{name}", said, registry=_registry).set_function(value)


def text():
    """All of it, in Prometheus's text format, as bytes."""
    return generate_latest(_registry)


def memory():
    """Bytes that this process holds (Linux), otherwise nan."""
    try:
        with open("/proc/self/statm", encoding="ascii") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except OSError:
        return float("nan")


class Pulse:
    """How late the server's loop comes to what is due: call `beat` every EVERY seconds."""

    EVERY = 0.05  # s
    BUCKETS = (0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0)  # s

    def __init__(self, registry=None):
        said = "how late the server's loop came to what was due"
        self.last, self.lags = (
            None,
            Histogram("contact_loop_lag_seconds", said, registry=registry, buckets=self.BUCKETS),
        )

    def beat(self):
        """Count the time since the last beat, less what it should be."""
        now = monotonic()
        if self.last is not None:
            self.lags.observe(max(0.0, now - self.last - self.EVERY))
        self.last = now


pulse = Pulse(_registry)
gauge("uptime_seconds", "since the server was started", lambda: monotonic() - _begun)
gauge("memory_bytes", "of the server's process", memory)
