"""What is published works without the repository: the sdist, its wheel, and the page served from an empty folder."""

import os
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from contextlib import suppress
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PATIENCE = 300  # s; a limit against hanging

pytestmark = [pytest.mark.thorough, pytest.mark.slow]


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """A folder with what the wheel holds, made from the sdist."""
    dist, folder = tmp_path_factory.mktemp("dist"), tmp_path_factory.mktemp("installed")
    run = {"cwd": ROOT, "check": True, "timeout": PATIENCE}
    subprocess.run([sys.executable, "-m", "build", "--outdir", dist, "."], **run)
    (wheel,) = dist.glob("*.whl")
    assert len(list(dist.glob("*.tar.gz"))) == 1
    subprocess.run([sys.executable, "-m", "pip", "install", "--no-deps", "--target", folder, wheel], **run)
    return folder


def test_wheel_contains_every_file_of_the_packages(installed):
    for name in ("app", "solver"):
        expected = {path.relative_to(ROOT) for path in (ROOT / name).rglob("*") if path.is_file()}
        expected = {path for path in expected if "__pycache__" not in path.parts and path.suffix != ".pyc"}
        held = {path.relative_to(installed) for path in (installed / name).rglob("*") if path.is_file()}
        assert not expected - held


def test_the_wheel_computes_and_serves_from_an_empty_folder(installed, tmp_path):
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    # interpreted, as compiling takes a minute: tests/cli/test_cold_start.py compiles
    environment = os.environ | {"PYTHONPATH": str(installed), "NUMBA_DISABLE_JIT": "1"}
    own = {"cwd": tmp_path, "env": environment}
    small = ["--set", "nodes=16", "width=40", "u_x_max=1", "--json", "run.json"]
    subprocess.run([sys.executable, "-m", "solver", "run", *small], check=True, timeout=PATIENCE, **own)
    assert (tmp_path / "run.json").is_file()
    command = [sys.executable, "-m", "solver", "serve", "--port", str(port)]
    server = subprocess.Popen(command, **own)
    try:
        page, end = None, time.monotonic() + PATIENCE
        while page is None and time.monotonic() < end and server.poll() is None:
            with suppress(urllib.error.URLError, ConnectionError):
                page = urllib.request.urlopen(f"http://localhost:{port}/app", timeout=30).read()
        assert page is not None and b"page.js" in page
    finally:
        server.terminate()
        server.wait(30)
