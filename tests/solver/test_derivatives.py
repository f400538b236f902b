"""The commands that need derivatives: what they print, write and refuse."""

import csv
import json

import pytest

SMALL = ("nodes=64", "width=160", "radius=0.6", "delta_bar=0.1", "u_x_max=12", "du_x=0.2", "du_z=0.5", "E=30")


def strict(file):
    return json.loads(file.read_text(), parse_constant=lambda word: pytest.fail(f"{word} is not JSON"))


def rows(file):
    with open(file, newline="") as text:
        return list(csv.DictReader(text))


def test_sensitivities_are_printed_and_written(call, tmp_path):
    file, table = tmp_path / "s.json", tmp_path / "s.csv"
    code, out, _ = call("sensitivities", "--set", *SMALL, "--json", file, "--csv", table)
    assert code == 0 and "phi_ratio" in out and "First slip" in out
    slips, written = strict(file)["slips"], rows(table)
    assert len(slips) * len(slips[0]["by"]) == len(written)
    assert float(written[0]["dU_s"]) == slips[0]["by"][written[0]["parameter"]]["per_unit"]["U_s"]
    assert len(slips[0]["nodes"]["F_s"]) == 64


@pytest.mark.thorough
def test_a_fit_of_the_csv_of_a_run_recovers_its_parameter(call, tmp_path):
    """The CSV of `run` is a measurement."""
    curve, file = tmp_path / "curve.csv", tmp_path / "fit.json"
    assert call("run", "--set", *SMALL, "--csv", curve)[0] == 0
    code, out, _ = call("fit", curve, "--free", "phi_ratio", "--set", *SMALL, "phi_ratio=0.9", "--json", file)
    found = strict(file)
    assert code == 0 and found["reached"] and "phi_ratio" in out
    assert found["values"]["phi_ratio"] == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("settings", [("u_x_max=1",), ("delta_bar=-1", "u_x_max=1")], ids=["sticks", "never touches"])
def test_a_run_without_a_slip_is_not_said_to_slide(call, settings):
    code, out, _ = call("sensitivities", "--set", *SMALL, *settings)
    assert code == 0 and out.startswith("The run has no slip up to u_x_max = 1 nm")


@pytest.mark.parametrize(
    "arguments, said",
    [
        (("fit", "nowhere.csv", "--free", "E"), "nowhere.csv"),
        (("sensitivities", "--set", "E=-1"), "E = -1"),
    ],
)
def test_bad_input_is_reported_in_one_line_and_exits_with_2(call, arguments, said):
    code, _, error = call(*arguments)
    assert code == 2 and said in error and len(error.strip().splitlines()) == 1


def test_a_path_without_derivatives_is_rejected_by_name(call):
    code, _, error = call("sensitivities", "--set", *SMALL, "path=unload")
    assert code == 1 and error.startswith("path = 'unload' cannot be followed: use path=shear; ")
