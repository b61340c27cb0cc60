"""Models on disk."""

import io
import json
import pickle
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pendulum
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.effects.formula import formula_effect
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification import Model, Settings, extend, identify
from lagrangian_ff.identification.storage import VERSION
from lagrangian_ff.kernels import KERNELS
from lagrangian_ff.record_json import by_name


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the file of a small model."""
    path = tmp_path_factory.mktemp("model") / "model.npz"
    settings = Settings(samples=40, evaluations=8, train=1.0)
    identify(pendulum.motion(10.0), settings).model.save(path)
    return path


@pytest.mark.parametrize("name", sorted(KERNELS))
def test_a_model_predicts_the_same_after_a_round_trip(name: str, tmp_path: Path) -> None:
    settings = Settings(f"{name}+fri", samples=30, evaluations=4, train=1.0)
    model = identify(pendulum.motion(8.0), settings).model
    model.save(tmp_path / "model.npz")
    again = Model.load(tmp_path / "model.npz")
    _, x = pendulum.states(2.0, 20.0, seed=5)
    states = x.q, x.qd, x.qdd
    np.testing.assert_array_equal(again.predict(*states), model.predict(*states))
    assert again.joints == model.joints
    assert again.name == model.name
    assert json.dumps(again.record) == json.dumps(model.record)
    assert by_name(again.range) == by_name(model.range)
    np.testing.assert_array_equal(again.data.tau[again.seen], model.data.tau[model.seen])


@pytest.mark.parametrize("spoilt", [np.inf, np.nan, 1e300])
def test_a_model_that_does_not_read_back_is_not_saved(
    saved: Path, tmp_path: Path, spoilt: float
) -> None:
    model = Model.load(saved)
    target = tmp_path / "model.npz"
    target.write_bytes(b"as it was")
    with np.errstate(all="ignore"), pytest.raises(ModelError, match="not sound, and was not saved"):
        replace(model, weights=spoilt * model.weights * 1e8).save(target)
    assert target.read_bytes() == b"as it was"
    assert list(tmp_path.iterdir()) == [target]


def test_a_burst_of_false_efforts_hardly_raises_the_range_of_torque() -> None:
    clean, burst = pendulum.motion(20.0), pendulum.motion(20.0)
    tau = burst.tau.copy()
    tau[700:704] = 2000.0
    settings = Settings(samples=150, evaluations=8, train=1.0)
    expected = identify(clean, settings).model.range.tau_max
    found = identify(replace(burst, tau=tau), settings).model
    assert (found.range.tau_max < 500.0).all()
    assert any("2000 N·m, which nothing else" in note for note in found.identified.notes)
    assert not any(
        "which nothing else" in n for n in identify(clean, settings).model.identified.notes
    )
    assert (expected > 0.9 * np.abs(clean.tau).max(axis=0)).all()


def rewrite(source: Path, target: Path, change: Callable[[dict[str, Any]], None]) -> Path:
    """Return a copy of a model file with its header or arrays changed."""
    with np.load(source) as file:
        content: dict[str, Any] = {name: file[name] for name in file.files}
    content["header"] = json.loads(bytes(content["header"]).decode())
    change(content)
    text = json.dumps(content["header"]).encode()
    np.savez(target, **{**content, "header": np.frombuffer(text, dtype=np.uint8)})
    return target


def test_the_joints_of_an_added_effect_may_have_any_name(tmp_path: Path) -> None:
    motion = replace(pendulum.motion(8.0), joints=("left+right", "b"))
    model = identify(motion, Settings("vrbfs+fri", samples=30, evaluations=4, train=1.0)).model
    wider = extend(model, EFFECTS["stribeck"], "left+right").model
    wider.save(tmp_path / "model.npz")
    again = Model.load(tmp_path / "model.npz")
    assert again.name == wider.name == "vrbfs+fri+stribeck@left+right"
    _, x = pendulum.states(2.0, 20.0, seed=5)
    states = x.q, x.qd, x.qdd
    np.testing.assert_array_equal(again.predict(*states), wider.predict(*states))


def with_formula(saved: Path, tmp_path: Path) -> tuple[Model, Path]:
    """Return a model with a formula on the elbow, and its file."""
    wave = formula_effect("my_wave", "A*cos(n*q)+B*q_1", {"n": (2.0, 9.0)}, units={"A": "N·m"})
    wider = extend(Model.load(saved), wave, "elbow").model
    wider.save(tmp_path / "wider.npz")
    return wider, tmp_path / "wider.npz"


def test_a_formula_needs_no_other_file(saved: Path, tmp_path: Path) -> None:
    wider, file = with_formula(saved, tmp_path)
    assert "my_wave" not in EFFECTS
    again = Model.load(file)
    _, x = pendulum.states(2.0, 20.0, seed=5)
    states = x.q, x.qd, x.qdd
    np.testing.assert_array_equal(again.predict(*states), wider.predict(*states))
    *_, term = again.basis.terms
    assert (term.effect.name, term.effect.formula) == ("my_wave", "A*cos(n*q)+B*q_1")
    assert [one.unit for one in term.effect.parameters] == ["N·m", "SI"]


@pytest.mark.parametrize(
    "formula", [3, {}, {"name": "my_wave", "formula": "q"}, {"name": "../x", "formula": "A*q"}]
)
def test_a_formula_that_is_none_is_a_damage(saved: Path, tmp_path: Path, formula: object) -> None:
    def damage(content: dict[str, Any]) -> None:
        content["header"]["basis"][-1]["formula"] = formula

    _, file = with_formula(saved, tmp_path)
    with pytest.raises(ModelError, match="is damaged"):
        Model.load(rewrite(file, tmp_path / "strange.npz", damage))


def test_a_kernel_that_is_not_known_is_named(saved: Path, tmp_path: Path) -> None:
    def strange(content: dict[str, Any]) -> None:
        content["header"]["name"] = "wizardry+fri"

    with pytest.raises(ModelError, match="'wizardry' is neither a kernel"):
        Model.load(rewrite(saved, tmp_path / "strange.npz", strange))


def test_a_model_of_version_2_was_made_exactly(saved: Path, tmp_path: Path) -> None:
    def older(content: dict[str, Any]) -> None:
        content["header"]["version"] = 2
        for name in ("seen", "more_q", "more_qd", "more_qdd"):
            del content[name]
        del content["header"]["record"]["settings"]["landmarks"]

    model = Model.load(rewrite(saved, tmp_path / "older.npz", older))
    np.testing.assert_array_equal(model.seen, model.index)
    more = extend(model, EFFECTS["stribeck"], "elbow")
    assert more.record["samples"] == len(model.index)


def test_a_newer_version_says_so(saved: Path, tmp_path: Path) -> None:
    def newer(content: dict[str, Any]) -> None:
        content["header"]["version"] = VERSION + 1

    with pytest.raises(ModelError, match=f"version {VERSION + 1}, this program reads up to"):
        Model.load(rewrite(saved, tmp_path / "new.npz", newer))


@pytest.mark.parametrize(
    "change",
    [
        lambda c: c.pop("weights"),
        lambda c: c.update(weights=c["weights"][:-1]),
        lambda c: c.update(weights=c["weights"] * np.nan),
        lambda c: c.update(unit=np.ones(5)),
        lambda c: c.update(coefficients=np.ones(2)),
        lambda c: c["header"].pop("joints"),
        lambda c: c["header"].update(joints=["one"]),
        lambda c: c["header"].update(hyperparameters={"sgima": [1.0]}),
        lambda c: c["header"]["range"].pop("q_low"),
        lambda c: c["header"]["hyperparameters"].update(sigma=[-1.0]),
        lambda c: c["header"]["hyperparameters"].update(sigma=[0.0]),
        lambda c: c["header"]["hyperparameters"].update(sigma=[float("nan")]),
        lambda c: c["header"]["hyperparameters"].update(sigma=[1.0, 2.0, 3.0]),
        lambda c: c.update(noise=0.0 * c["noise"]),
        lambda c: c.update(noise_share=-c["noise_share"]),
        lambda c: c.update(unit=0.0 * c["unit"]),
        lambda c: c.update(trust=np.full_like(c["weights"], 1.5)),
        lambda c: c.update(trust=np.zeros_like(c["weights"])),
        lambda c: c.update(trust=np.ones(3)),
        lambda c: c.update(noise=c["noise"] * 1e300),
        lambda c: c.update(weights=c["weights"] + 1e300),
        lambda c: c.update(q=c["q"] + 1e200),
        lambda c: c.update(q=c["q"].tobytes()),
        lambda c: c.update(segment=c["segment"][::-1] - np.arange(len(c["segment"]))),
        lambda c: c.update(index=c["index"][:0], seen=c["seen"][:0]),
        lambda c: c["header"].update(record=[]),
        lambda c: c["header"].update(conditioning="usual"),
        lambda c: c["header"].update(range=3),
        lambda c: c["header"].update(name=None),
        lambda c: c["header"].update(steps=[3]),
        lambda c: c["header"].update(steps=[{"joints": [1]}]),
        lambda c: c["header"].update(steps=[{"error_after": "small"}]),
        lambda c: c["header"].update(mechanism=[]),
        lambda c: c["header"]["record"].update(uncertainty=[]),
        lambda c: c["header"]["record"].update(joints=7),
        lambda c: c["header"]["record"].update(effects=[None]),
        lambda c: c["header"]["record"]["uncertainty"].update(quick={"elbow": "wide"}),
        lambda c: c["header"]["hyperparameters"].update(sigma=[1e300]),
    ],
)
def test_contents_that_do_not_fit_are_called_damaged(
    saved: Path, tmp_path: Path, change: Callable[[dict[str, Any]], None]
) -> None:
    with pytest.raises(ModelError, match=r"bad\.npz is damaged"):
        Model.load(rewrite(saved, tmp_path / "bad.npz", change))


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"luck": 1}, "hold luck, which this version does not know"),
        ({"train": "all"}, "train is 'all'"),
        ({"folds": 0}, "folds is 0"),
        ("usual", "'usual', expected an object"),
    ],
)
def test_settings_of_a_file_that_cannot_be_are_refused(
    saved: Path, tmp_path: Path, settings: object, said: str
) -> None:
    def other(content: dict[str, Any]) -> None:
        content["header"]["record"]["settings"] = settings

    path = rewrite(saved, tmp_path / "other.npz", other)
    with pytest.raises(ModelError, match=said):
        extend(Model.load(path), EFFECTS["stribeck"], "elbow")


def test_an_effect_of_ones_own_is_asked_for(saved: Path, tmp_path: Path) -> None:
    def own(content: dict[str, Any]) -> None:
        content["header"]["basis"][0].update(effect="wizardry")

    with pytest.raises(ModelError, match=r"'wizardry', which is not in the .* --effects-file"):
        Model.load(rewrite(saved, tmp_path / "own.npz", own))


@example(cut=0.0, byte=1, place=0.47343273140212017)
@given(cut=st.floats(0.0, 0.999), byte=st.integers(0, 255), place=st.floats(0.0, 0.999))
def test_a_damaged_file_never_passes_or_crashes(
    saved: Path, tmp_path_factory: pytest.TempPathFactory, cut: float, byte: int, place: float
) -> None:
    whole = saved.read_bytes()
    path = tmp_path_factory.mktemp("damaged") / "model.npz"
    path.write_bytes(whole[: int(cut * len(whole))])
    with pytest.raises(ModelError):
        Model.load(path)
    changed = bytearray(whole)
    changed[int(place * len(whole))] = byte
    path.write_bytes(bytes(changed))
    try:
        model = Model.load(path)
    except ModelError:
        return
    assert np.isfinite(model.weights).all()


def test_nothing_is_executed_on_loading(tmp_path: Path) -> None:
    class Trap:
        def __reduce__(self) -> tuple[Any, tuple[str]]:
            return (exec, ("raise SystemExit('executed')",))

    path = tmp_path / "trap.npz"
    np.savez(path, header=np.array([Trap()], dtype=object))
    with pytest.raises(ModelError):
        Model.load(path)
    path.write_bytes(pickle.dumps(Trap()))
    with pytest.raises(ModelError):
        Model.load(path)


def test_other_files_are_not_models(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="no model file"):
        Model.load(tmp_path / "absent.npz")
    with pytest.raises(ModelError, match="is a folder"):
        Model.load(tmp_path)
    np.savez(tmp_path / "other.npz", time=np.arange(3))
    with pytest.raises(ModelError, match="not a model"):
        Model.load(tmp_path / "other.npz")
    buffer = io.BytesIO()
    np.save(buffer, np.arange(3))
    (tmp_path / "array.npz").write_bytes(buffer.getvalue())
    with pytest.raises(ModelError, match="not a model"):
        Model.load(tmp_path / "array.npz")


def test_saving_where_nothing_can_be_written_is_explained(saved: Path, tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="cannot write"):
        Model.load(saved).save(tmp_path / "no" / "such" / "folder" / "model.npz")


def test_a_failed_save_keeps_the_file_that_was_there(saved: Path, tmp_path: Path) -> None:
    target = tmp_path / "model.npz"
    target.write_bytes(b"precious")
    broken = replace(Model.load(saved), record={"not json": object()})
    with pytest.raises(TypeError):
        broken.save(target)
    assert target.read_bytes() == b"precious"
    assert [p.name for p in tmp_path.iterdir()] == ["model.npz"]


def test_a_file_that_would_execute_code_is_named_for_what_it_is(tmp_path: Path) -> None:
    path = tmp_path / "model.npz"
    path.write_bytes(pickle.dumps({"joints": ["a"]}))
    with pytest.raises(ModelError, match="is not a model of lagrangian_ff: it is a pickle") as why:
        Model.load(path)
    assert "allow_pickle" not in str(why.value)
    np.savez(path, header=np.array([print], dtype=object))
    with pytest.raises(ModelError, match="array header holds Python objects") as why:
        Model.load(path)
    assert "allow_pickle" not in str(why.value)


def test_a_model_that_claims_to_be_huge_is_refused(saved: Path, tmp_path: Path) -> None:
    path = tmp_path / "huge.npz"
    with zipfile.ZipFile(saved) as old, zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as new:
        for name in old.namelist():
            content = old.read(name)
            new.writestr(name, bytes(160 << 20) if name == "q.npy" else content)
    with pytest.raises(ModelError, match=r"huge\.npz: claims to unpack to 160"):
        Model.load(path)


@pytest.mark.parametrize("text", [b"[" * 100_000, b'{"joints": ["\\ud800"]}'])
def test_a_header_that_cannot_be_read_or_said_is_refused(
    saved: Path, tmp_path: Path, text: bytes
) -> None:
    with np.load(saved) as file:
        content: dict[str, Any] = {name: file[name] for name in file.files}
    content["header"] = np.frombuffer(text, dtype=np.uint8)
    np.savez(tmp_path / "deep.npz", **content)
    with pytest.raises(ModelError, match=r"deep\.npz is damaged or no model file"):
        Model.load(tmp_path / "deep.npz")
