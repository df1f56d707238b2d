"""Exported code computes, tick by tick, what Python computes, in any compiler and language, and never goes astray."""

from __future__ import annotations

import csv
import json
import re
import subprocess
from pathlib import Path

import needs
import numpy as np
import pytest
from export_cases import KINDS, LAWS, built, experiment_of, exported, ran

import asmc_pin
from asmc_pin.cli import main
from asmc_pin.codegen import c_compiler, exporting
from asmc_pin.codegen.exported_code import row_meanings
from asmc_pin.codegen.guarded_law import BAD_INPUT, BAD_RESULT, BAD_TIME, FAULT, LIMITED, OK
from asmc_pin.controllers import CONTROLLERS

LIBM = {"ntsm"}
"""Laws with a power in them, whose last digits are the library's."""


def rows_of(folder: Path) -> list[dict[str, str]]:
    with (folder / "short_it_vectors.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_every_law_that_can_be_exported_is_among_the_cases():
    assert {kind["law"] for kind in KINDS.values()} >= set(LAWS)
    assert len(LAWS) >= 13


@pytest.mark.parametrize("kind", KINDS)
def test_c_is_python_to_the_last_bit_in_two_compilers_and_as_cpp(kind, tmp_path):
    done = exported(tmp_path / "x", KINDS[kind])
    assert done.exact == (KINDS[kind]["law"] not in LIBM)
    for compiler, language in (("c", "c"), ("clang", "c"), ("c++", "c++")):
        said = ran(built(tmp_path / "x", compiler, language=language), tmp_path / "x")
        assert f"ticks {done.ticks} wrong 0" in said
        assert not done.exact or "largest_difference 0\n" in said
    assert {int(row["status"]) for row in rows_of(tmp_path / "x")} == {
        OK,
        LIMITED,
        BAD_TIME,
        BAD_INPUT,
        BAD_RESULT,
        FAULT,
    }


@pytest.mark.parametrize("kind", KINDS)
def test_in_single_precision_c_is_python_in_single_precision_and_near_to_double(kind, tmp_path):
    done = exported(tmp_path / "x", KINDS[kind], real="float")
    said = ran(built(tmp_path / "x", "clang", "-O1"), tmp_path / "x")
    assert "wrong 0" in said
    assert not done.exact or "largest_difference 0\n" in said
    assert done.from_double > 0.0
    assert "typedef float" in (tmp_path / "x" / "short_it.h").read_text()


@pytest.mark.parametrize("kind", KINDS)
def test_every_torque_is_finite_within_its_limit_and_no_further_from_the_last_than_a_step(kind, tmp_path):
    exported(tmp_path / "x", KINDS[kind], torque_rate=[4000.0, 3000.0])
    last = None
    for row in rows_of(tmp_path / "x"):
        torque = np.array([float(value) for name, value in row.items() if name.startswith("tau_out ")])
        assert np.isfinite(torque).all()
        assert (np.abs(torque) <= [40.0, 15.0]).all()
        if row["init"] == "0":
            assert (np.abs(torque - last) <= np.array([4.0, 3.0]) * (1 + 1e-12)).all()
            if int(row["status"]) in (BAD_TIME, BAD_INPUT, BAD_RESULT):
                assert (torque == last).all()
        last = torque


def test_the_c_is_not_what_python_computes_where_products_and_sums_are_contracted_or_the_law_is_another(tmp_path):
    """That a difference would be seen: the vectors of one law, run by the code of another."""
    exported(tmp_path / "one", KINDS["ppc"])
    exported(tmp_path / "two", {"law": "bsmc", "gain": 1e-9, "boundary": 1.0})
    runner = built(tmp_path / "two", "c")
    with pytest.raises(AssertionError, match=r"wrong [1-9]"):
        ran(runner, tmp_path / "one")


@pytest.mark.parametrize("law", LAWS)
def test_every_field_of_the_structures_has_its_unit(law, tmp_path, monkeypatch):
    monkeypatch.setattr(exporting, "find_compiler", lambda: None)
    kind = next(kind for kind in KINDS.values() if kind["law"] == law)
    exported(tmp_path / "x", kind)
    header = (tmp_path / "x" / "short_it.h").read_text(encoding="utf-8")
    fields = re.findall(r"^    (short_it_\w+|uint32_t) (\w+)(\[SHORT_IT_NV\])?; /\* (.*) \*/$", header, re.M)
    assert len(fields) == len(re.findall(r"^    \w+ \w+(?:\[SHORT_IT_NV\])?;", header, re.M)) > 15
    unit = re.compile(r"rad|1/s|N·m|N\.m|no unit|kg·m²|\bs$|ticks|state|1 from|law, as of|multiplied by")
    assert not [field for field in fields if not unit.search(field[3])]
    assert set(row_meanings(CONTROLLERS[law](mbar=1.0, ks=1.0, beta=1.0, period=0.001, **own(kind)))) >= {"mbar"}


def own(kind):
    return {key: value for key, value in kind.items() if key != "law"}


def test_no_heap_no_state_of_its_own_and_no_library_beyond_mathematics(tmp_path):
    """What the object needs from outside, and what it has at file scope, as the linker sees it."""
    import subprocess

    from needs import program

    for kind, allowed in (("baek2016", set()), ("sta", {"sqrt"}), ("ntsm", {"pow"})):
        folder = tmp_path / kind
        exported(folder, KINDS[kind])
        flags = ["-std=c99", "-O2", "-fno-builtin-memcpy", "-c", "short_it.c", "-o", "o.o"]
        subprocess.run([program("c"), *flags], cwd=folder, check=True)
        listed = subprocess.run(["nm", "o.o"], cwd=folder, capture_output=True, text=True, check=True).stdout
        symbols = [line.split()[-2:] for line in listed.splitlines()]
        assert {name for kind_of, name in symbols if kind_of == "U"} - {"memcpy", "_GLOBAL_OFFSET_TABLE_"} <= allowed
        assert not [name for kind_of, name in symbols if kind_of in "bBdDC"]


def fuzzed(folder: Path, kind: str, real: str) -> None:
    """Bits drawn at random as numbers, for a while each kind: no undefined behaviour, and no torque that is not one."""
    import subprocess

    from needs import program

    exported(folder, KINDS[kind], real=real)
    (folder / "fuzz.c").write_text((Path(__file__).parent / "fuzz_exported.c").read_text())
    flags = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g", "-O1", "-std=c99", "-Wall", "-Werror"]
    subprocess.run([program("c"), *flags, "short_it.c", "fuzz.c", "-o", "fuzz", "-lm"], cwd=folder, check=True)
    done = subprocess.run(["./fuzz", "20000"], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    counts = dict(pair.split("=") for pair in done.stdout.split())
    assert all(int(counts[name]) > 0 for name in ("ok", "limited", "bad_time", "bad_input", "fault"))


SOME = {"baek2016": "double", "ntsm": "double", "sta": "float", "adrc": "double", "barrier": "float"}


@pytest.mark.parametrize("kind", SOME)
def test_random_calls_are_survived_under_the_sanitizers(kind, tmp_path):
    fuzzed(tmp_path / "x", kind, SOME[kind])


@pytest.mark.long
@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind not in SOME])
def test_random_calls_of_every_other_law_are_survived_too(kind, tmp_path):
    fuzzed(tmp_path / "x", kind, "double")


BUMP = {"ism": 2.0, "plestan2010": 0.1 * 1.001, "constant epsilon": 0.1 * 1.001, "sta": 0.01, "adaptive sta": 0.01}
"""Laws that switch at s = 0, sgn(0) = +1, whatever it was before: by this times M̄, rad/s²."""


def test_the_hand_over_is_bumpless_but_for_a_sign_that_begins_somewhere():
    for name, kind in KINDS.items():
        bump = np.array([0.05, 0.04]) * BUMP.get(name, 0.0)
        np.testing.assert_allclose(torques_at_rest(kind) - [3.0, -2.0], bump, rtol=3e-3, atol=1e-9, err_msg=name)


def torques_at_rest(kind):
    from asmc_pin.codegen.exported_code import translate
    from asmc_pin.codegen.guarded_law import Guard, GuardedLaw
    from asmc_pin.controllers import Sample, Setpoint

    law = experiment_of(kind).build_controllers()["It"]
    translated = translate(law, 2, "x", "double")
    guard = Guard(0.001, np.full(2, 40.0), np.full(2, 40.0), np.zeros(2), 5, 20)
    guarded = GuardedLaw(law, guard, translated.first, translated.step.period_row)
    q, v, tau = np.array([0.3, 0.2]), np.zeros(2), np.array([3.0, -2.0])
    guarded.init(q, v, tau)
    assert guarded.step(Sample(q, v, tau), Setpoint(q, v, v), 0.001) == OK
    return guarded.command


def test_a_tick_that_was_missed_counts_in_the_acceleration_of_the_next(tmp_path):
    """v rises steadily; with a reading lost the estimate is still its slope, and the torque what it would have been."""
    from asmc_pin.codegen.exported_code import translate
    from asmc_pin.codegen.guarded_law import Guard, GuardedLaw
    from asmc_pin.controllers import Sample, Setpoint

    law = experiment_of(KINDS["ppc"]).build_controllers()["It"]
    translated = translate(law, 2, "x", "double")
    guard = Guard(0.001, np.full(2, 40.0), np.full(2, 40.0), np.zeros(2), 5, 20)

    def torque(lost):
        guarded = GuardedLaw(law, guard, translated.first, translated.step.period_row)
        for k in range(10):
            v = np.full(2, 2.0 * k * 0.001)
            q = np.full(2, 1.0 * (k * 0.001) ** 2)
            if k == 0:
                guarded.init(q, v, np.zeros(2))
            reading = q * np.nan if k in lost else q
            guarded.step(Sample(reading, v, np.zeros(2)), Setpoint(q, v, np.full(2, 2.0)), 0.001)
        return guarded.command

    np.testing.assert_allclose(torque(lost=(6, 7, 8)), torque(lost=()), atol=1e-12)


def test_a_certificate_is_checked_again_named_in_the_code_and_refused_for_another_mbar(tmp_path):
    experiment = experiment_of(KINDS["ppc"])
    proof = asmc_pin.certify(experiment.build_arm(), [0.05, 0.04])
    assert proof.verdict == "holds"
    proof.save(tmp_path / "proof.npz")
    asmc_pin.export(experiment, "It", tmp_path / "x", ramp=0.02, certificate=tmp_path / "proof.npz")
    header = (tmp_path / "x" / "short_it.h").read_text(encoding="utf-8")
    assert "certificate: proof.npz" in header
    assert "Lemma 1" in header
    assert "period of 0.001 s" in header
    other = experiment.replace(defaults={"mbar": [0.05, 0.03], "ks": 8.0, "beta": 9.0})
    with pytest.raises(asmc_pin.ParameterError, match="give a certificate of this"):
        asmc_pin.export(other, "It", tmp_path / "y", ramp=0.02, certificate=tmp_path / "proof.npz")


# What is refused, and what is said ------------------------------------------------------------------------------------


def test_a_law_without_a_step_for_one_trial_is_not_exported(tmp_path):
    with pytest.raises(asmc_pin.ExperimentError, match="cannot be exported"):
        exported(tmp_path / "x", {"law": "pd_gravity", "kp": 10.0, "kd": 1.0})
    assert not (tmp_path / "x").exists()


def test_an_arm_without_torque_limits_is_not_exported(tmp_path):
    experiment = experiment_of(KINDS["ppc"], plant={"effort_limit": [float("inf"), 10.0]})
    with pytest.raises(asmc_pin.ExperimentError, match="no torque limit"):
        asmc_pin.export(experiment, "It", tmp_path / "x")


@pytest.mark.parametrize(
    ("options", "named"),
    [
        ({"safe_torque": 50.0}, "safe_torque"),
        ({"safe_torque": [1.0, 2.0, 3.0]}, "safe_torque"),
        ({"torque_rate": 0.0}, "torque_rate"),
        ({"ramp": 0.0}, "ramp"),
        ({"fault_ticks": 0}, "fault_ticks"),
    ],
)
def test_options_that_make_no_sense_are_named(options, named, tmp_path):
    with pytest.raises(asmc_pin.ParameterError) as error:
        exported(tmp_path / "x", KINDS["ppc"], **options)
    assert error.value.parameter == named


def test_an_export_is_replaced_by_force_only_and_other_folders_never(tmp_path, monkeypatch):
    monkeypatch.setattr(exporting, "find_compiler", lambda: None)
    exported(tmp_path / "x", KINDS["ppc"])
    with pytest.raises(asmc_pin.ResultError, match="force=True"):
        exported(tmp_path / "x", KINDS["ppc"])
    exported(tmp_path / "x", KINDS["ppc"], force=True)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("…")
    with pytest.raises(asmc_pin.ResultError, match="left alone"):
        exported(tmp_path / "mine", KINDS["ppc"], force=True)


def test_code_that_computes_something_else_is_a_fault_of_ours_and_is_not_written(tmp_path, monkeypatch):
    monkeypatch.setattr(exporting, "run_vectors", lambda *_: c_compiler.VectorRun(10, 3, 4, 0.5))
    with pytest.raises(exporting.NotTheSame, match="3 of 10 ticks"):
        exported(tmp_path / "x", KINDS["ppc"])
    assert not (tmp_path / "x").exists()


def test_the_command_that_is_named_to_check_the_code_elsewhere_does_it(tmp_path, monkeypatch):
    needs.program("c")
    monkeypatch.chdir(tmp_path)
    done = exported(Path("x"), KINDS["ppc"])
    run = subprocess.run(done.check_yourself(), shell=True, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    assert f"ticks {done.ticks} wrong 0" in run.stdout


def test_without_a_compiler_the_files_are_written_and_that_is_said(tmp_path, monkeypatch):
    monkeypatch.setenv("CC", "no_such_compiler")
    done = exported(tmp_path / "x", KINDS["ppc"])
    assert done.checked_ticks == 0
    assert "not compiled" in "\n".join(done.lines())


def test_the_same_experiment_gives_the_same_files(tmp_path, monkeypatch):
    monkeypatch.setattr(exporting, "find_compiler", lambda: None)
    for name in ("a", "b"):
        exported(tmp_path / name, KINDS["sta"])
    for path in (tmp_path / "a").iterdir():
        assert path.read_bytes() == (tmp_path / "b" / path.name).read_bytes()


def test_the_command_prints_its_json_and_says_who_is_not_there(tmp_path, capsys):
    file = tmp_path / "short.toml"
    file.write_text(experiment_of(KINDS["ppc"]).to_toml(), encoding="utf-8")
    with pytest.raises(SystemExit) as end:
        main(["export", str(file), "It", "--out", str(tmp_path / "x"), "--ramp", "0.02", "--json"])
    told = json.loads(capsys.readouterr().out)
    assert end.value.code in (0, None)
    assert told["abi"] == 1
    assert len(told["files"]) == 4
    with pytest.raises(SystemExit) as end:
        main(["export", str(file), "She", "--out", str(tmp_path / "y")])
    assert end.value.code == 2
    assert "there is no 'She'" in capsys.readouterr().err
