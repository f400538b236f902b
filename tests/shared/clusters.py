"""A dask cluster of this machine's own, for tests."""

import os
import signal
import socket
import subprocess
import sys

PATIENCE = 300  # s; a limit against hanging, not a claim about speed
QUIET = ["--no-dashboard", "--host", "127.0.0.1"]


class Local:
    """A scheduler and two workers, as processes of this machine."""

    def __init__(self, folder):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = probe.getsockname()[1]
        self.folder, self.processes = folder, []
        self.address = f"tcp://127.0.0.1:{self.port}"

    def start(self):
        self._run("scheduler", "--port", str(self.port), *QUIET)
        for _ in range(2):
            self._run("worker", self.address, "--nthreads", "1", "--local-directory", str(self.folder), *QUIET)

    def _run(self, *command):
        output = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "start_new_session": True}
        self.processes.append(subprocess.Popen([sys.executable, "-m", "dask", *command], cwd=self.folder, **output))

    def stop(self):
        for process in self.processes:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait(PATIENCE)
        self.processes = []
