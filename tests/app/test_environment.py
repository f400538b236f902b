"""Environment variables of the server: an invalid one ends it with one sentence, before the port is open."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from app import environment

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("text", ["0", "abc", "-1", "1.5", "1001", "9" * 30, " ", "٣"])
def test_numbers_out_of_range_are_refused_with_the_value_and_the_range(monkeypatch, text):
    monkeypatch.setenv("APP_WORKERS", text)
    with pytest.raises(SystemExit) as refused:
        environment.whole("APP_WORKERS", 1000, 2)
    assert refused.value.code == (f"APP_WORKERS is {text!r}. Set it to a whole number from 1 to 1000, or leave it out.")


def test_numbers_within_the_range_are_taken(monkeypatch):
    monkeypatch.setenv("APP_WORKERS", "1000")
    assert environment.whole("APP_WORKERS", 1000, 2) == 1000
    monkeypatch.setenv("APP_WORKERS", "")
    assert environment.whole("APP_WORKERS", 1000, 2) == 2


@pytest.mark.parametrize(
    "text", ["https://a.example; script-src *", "a\r\nb", "https://a.example,b", "'unsafe-inline'"]
)
def test_sites_cannot_add_rules_to_the_policy(monkeypatch, text):
    monkeypatch.setenv("APP_FRAME_ANCESTORS", text)
    with pytest.raises(SystemExit, match=r"separated by spaces"):
        environment.sites("APP_FRAME_ANCESTORS", "'self'")


def test_sites_are_taken_as_a_policy_names_them(monkeypatch):
    text = "'self' https://school.example https://*.example:8443 school.example"
    monkeypatch.setenv("APP_FRAME_ANCESTORS", text)
    assert environment.sites("APP_FRAME_ANCESTORS", "'self'") == text


def test_a_scheduler_needs_an_address_and_dask(monkeypatch):
    monkeypatch.setenv("APP_SCHEDULER", "host:8786")
    with pytest.raises(SystemExit, match=r"tcp://host:port or tls://host:port"):
        environment.scheduler("APP_SCHEDULER")
    monkeypatch.setenv("APP_SCHEDULER", "tls://host:8786")
    monkeypatch.setattr(environment, "find_spec", lambda name: name == "distributed")
    assert environment.scheduler("APP_SCHEDULER") == "tls://host:8786"
    monkeypatch.setattr(environment, "find_spec", lambda _: None)
    with pytest.raises(SystemExit, match=r"needs dask. Run pip install"):
        environment.scheduler("APP_SCHEDULER")


def test_a_server_with_an_invalid_variable_ends_with_one_sentence():
    run = [sys.executable, "-m", "panel", "serve", "app", "--port", "0", "--address", "127.0.0.1"]
    ended = subprocess.run(run, cwd=ROOT, env=os.environ | {"APP_VISITORS": "abc"}, capture_output=True, timeout=300)
    assert ended.returncode == 1 and b"Traceback" not in ended.stderr
    assert ended.stderr.decode().splitlines()[-1].startswith("APP_VISITORS is 'abc'. Set it to a whole number")
