"""What each feature costs a visitor: bytes and requests of the page, and time of the server for a visit.

`python tests/bench/features.py [NAME ...]` compares the page with all features to that without each of them (or without
the named ones), and to the core alone. Bytes are those of the compressed page with the scripts and styles that it loads
at once. The time is that of making and closing a visitor, the median of REPEATS.
"""

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
REPEATS = 30
MEASURE = """
import gzip, json, statistics, time
from bokeh.document import Document
from app import assets, modules, page
from app.experiment import Experiment, example
from app.service.jobs import Jobs
from app.stage import Wire

class Idle:
    status, in_flight, compiled = "ready", 0, 0

shared = page.shared(example)
names = {modules.PAGE, assets.STYLE}
body = gzip.compress(shared.page_for({}, token="", nonce="").encode(), 1)
times = []
for _ in range(%d):
    begun = time.process_time()
    Experiment(doc=Document(), jobs=Jobs(Idle()), stage=Wire()).close()
    shared.page_for({}, token="", nonce="")
    times.append(time.process_time() - begun)
size = len(body) + sum(len(assets.content(name)[1]) for name in names)
print(json.dumps([size, len(names) + 1, statistics.median(times)]))
"""


def measured(features: str) -> list[float]:
    """[bytes, requests, s of the server] of a visit with these features, as APP_FEATURES names them."""
    command = [sys.executable, "-c", MEASURE % REPEATS]
    ran = subprocess.run(
        command, env=os.environ | {"APP_FEATURES": features}, cwd=ROOT, capture_output=True, check=True
    )
    return json.loads(ran.stdout.splitlines()[-1])


def main() -> None:
    sys.path.insert(0, str(ROOT))
    from app import interface

    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("names", nargs="*", default=sorted(interface.classes()), help="features, default all")
    names = parser.parse_args().names
    whole, core = measured("all"), measured("none")
    print("| left out | kB | requests | ms of the server |\n|---|---|---|---|")
    for name in ["none", "all", *names]:
        one = {"none": whole, "all": core}.get(name) or measured(f"-{name}")
        saved = [a - b for a, b in zip(whole, one, strict=True)] if name in names else one
        print(f"| {name} | {saved[0] / 1000:.1f} | {saved[1]:.0f} | {1000 * saved[2]:.2f} |", flush=True)


if __name__ == "__main__":
    main()
