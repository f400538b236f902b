"""What the server counts and what it can tell of its state, as text for Prometheus; nothing here names a visitor."""

import os
from collections import Counter
from threading import Lock
from time import monotonic

KNOWN = {  # counted since the start
    "pages_total": "pages sent",
    "visits_total": "visitors who came",
    "turned_away_total": "visitors for whom there was no room",
    "slices_total": "slices of runs computed",
    "evaluations_total": "force evaluations in them",
    "shelf_hits_total": "runs that were known already",
    "shelf_misses_total": "runs that had to be computed",
    "followed_total": "pictures of runs that followed a hand on a slider",
    "agreed_total": "runs that were as followed: slips to 1e-4 nm, F to 1e-3 of its largest",
    "disagreed_total": "runs that were not",
    "not_followed_total": "times a run could not be followed, by reason",
    "tasks_total": "tasks done by workers",
    "tasks_lost_total": "tasks that took too long or whose worker ended",
    "worker_restarts_total": "workers replaced",
    "refused_messages_total": "messages of browsers that were none of the page's",
}
_counts, _lock, _begun = Counter(), Lock(), monotonic()
_reasons = {}  # name: Counter of reasons
_gauges = {}  # name: (what it is, () -> value)


def count(name, more=1, reason=None):
    """Count something of KNOWN, in any thread; with a reason, for each of them apart."""
    with _lock:
        _counts[f"{name}_total"] += more
        if reason is not None:
            _reasons.setdefault(f"{name}_total", Counter())[reason.replace('"', "'")] += more


def counted(name):
    """How often it was counted."""
    return _counts[f"{name}_total"]


def gauge(name, said, value):
    """Have `value()` told whenever somebody asks."""
    _gauges[name] = said, value


def text():
    """All of it, in Prometheus's text format."""
    lines = []
    for name, said in KNOWN.items():
        lines += [f"# HELP contact_{name} {said}", f"# TYPE contact_{name} counter"]
        apart = _reasons.get(name) or {None: _counts[name]}
        for reason, many in apart.items():
            label = "" if reason is None else f'{{reason="{reason}"}}'
            lines.append(f"contact_{name}{label} {many}")
    for name, (said, value) in _gauges.items():
        lines += [f"# HELP contact_{name} {said}", f"# TYPE contact_{name} gauge", f"contact_{name} {value():g}"]
    return "\n".join(lines) + "\n"


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
