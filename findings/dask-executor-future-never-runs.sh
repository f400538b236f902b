#!/usr/bin/env bash
# dask's executor of concurrent.futures (Client.get_executor): its futures are never "running", and cancel() of a call
# that a worker computes answers True, where the standard library's answers False. The worker goes on computing to the
# end, and keeps its thread: a loop that submits a new call for each one it has cancelled fills a cluster with calls
# that nobody waits for.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet distributed==2026.8.0 2>/dev/null
cd "$folder"
venv/bin/python - <<'PY'
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import distributed
from distributed import Client, LocalCluster


def work(begun, ended):
    begun.touch()
    time.sleep(3)
    ended.touch()


def tried(executor, name):
    begun, ended = Path(f"{name}-begun").absolute(), Path(f"{name}-ended").absolute()
    future = executor.submit(work, begun, ended)
    while not begun.exists():
        time.sleep(0.01)
    running, cancelled = future.running(), future.cancel()
    time.sleep(6)
    return running, cancelled, ended.exists()


with ThreadPoolExecutor(1) as executor:
    usual = tried(executor, "threads")
with LocalCluster(n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None) as cluster:
    with Client(cluster) as client:
        found = tried(client.get_executor(), "dask")
print("distributed", distributed.__version__, "(running, cancelled, ended all the same): threads", usual, "dask", found)
assert usual == (True, False, True) and found == (False, True, True), "changed"
PY
echo "as found: a call that dask's worker computes is said not to run, and to be cancelled, and is computed to its end"
