"""What the server counts and what it can tell of its state, as text for Prometheus; nothing here names a visitor."""

import os
from time import monotonic

from prometheus_client import CollectorRegistry, Counter, Gauge, disable_created_metrics, generate_latest

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
    """How late the server's loop comes to what is due: `beat` is to be called every EVERY seconds."""

    EVERY = 0.05  # s

    def __init__(self):
        self.last, self.latest = None, 0.0

    def beat(self):
        """The loop has come to it."""
        now = monotonic()
        if self.last is not None:
            self.latest = max(self.latest, now - self.last - self.EVERY)
        self.last = now

    def worst(self):
        """Seconds, the most since this was last asked."""
        worst, self.latest = self.latest, 0.0
        return worst


pulse = Pulse()
gauge("loop_lag_seconds", "by which the server's loop was late, at most, since this was last asked", pulse.worst)
gauge("uptime_seconds", "since the server was started", lambda: monotonic() - _begun)
gauge("memory_bytes", "of the server's process", memory)
