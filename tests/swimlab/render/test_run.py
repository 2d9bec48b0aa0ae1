"""Run folders: resumed, refused, forced, interrupted."""

import json
import shutil
from dataclasses import replace

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest

from sequences import Sequence, load
from swimlab.render.plan import Plan, check_samples, parse_frames
from swimlab.render.run import render_run
from swimlab.runs.clips import check_complete
from swimlab.runs.frames import FrameError, frame_path, read_frame
from swimlab.runs.record import Record, RunError
from swimlab.scoring.measure import measure_run

NAMES = ("pixel-point", "reference")
LARGEST_HALF = 65504.0


@pytest.fixture(scope="module")
def sequence(tmp_path_factory, maps) -> Sequence:
    """A tiny road with its own maps in files."""
    folder = tmp_path_factory.mktemp("maps")
    for key, pixels in {"albedo": maps[..., :3], "normal": maps[..., 3:6], "gloss": maps[..., 6:]}.items():
        write_map(folder / f"{key}.exr", pixels)
    material = "\n".join(f'{key} = "{key}.exr"' for key in ("albedo", "normal", "gloss"))
    (folder / "tiny.toml").write_text(
        f'version = 1\nname = "tiny"\nframes = 4\nsize = [24, 16]\n[scene.material]\n{material}\n', encoding="utf-8"
    )
    return load(folder / "tiny.toml")


def write_map(path, pixels):
    output = oiio.ImageOutput.create("exr")
    assert output.open(str(path), oiio.ImageSpec(*pixels.shape[1::-1], pixels.shape[2], oiio.FLOAT))
    assert output.write_image(np.ascontiguousarray(pixels))
    assert output.close()


def plan_of(sequence, **changes):
    given = {"techniques": NAMES, "frames": (0, 1, 2), "samples": 4} | changes
    return Plan(sequence=sequence, **given)


def files_of(run):
    return {path.relative_to(run).as_posix() for path in run.rglob("*") if path.is_file()}


def contents(run):
    return {name: (run / name).read_bytes() for name in files_of(run) if name != "run.json"}


def pixels(run):
    """Decoded pictures: the bits that matter, without the header."""
    return {name: pixels_of(run / name).tobytes() for name in files_of(run) if name.endswith(".exr")}


def pixels_of(path):
    source = oiio.ImageInput.open(str(path))
    values = source.read_image(0, 0, 0, source.spec().nchannels, oiio.FLOAT)
    source.close()
    return values


@pytest.fixture(scope="module")
def whole(sequence, tmp_path_factory):
    """An uninterrupted run of frames 0 to 2."""
    run = tmp_path_factory.mktemp("whole")
    render_run(plan_of(sequence), run, command="swimlab render tiny")
    return run


def test_a_run_holds_what_the_contract_says(whole, sequence):
    folders = ("pixel-point", "reference", "error", "geometry")
    assert files_of(whole) == {f"{folder}/{frame:04d}.exr" for folder in folders for frame in range(3)} | {"run.json"}
    record = json.loads((whole / "run.json").read_text())
    assert record["version"] == 1
    assert record["techniques"] == list(NAMES)
    assert record["frames"] == [0, 1, 2]
    assert record["sequence"]["name"] == "tiny"
    assert record["sequence"]["techniques"]["pixel-aniso"] == {"anisotropy": 16, "thinnest": 0.0}
    assert record["settings"] == {"samples": 4, "half": True}
    assert record["hash"] == plan_of(sequence).digest()
    assert record["uniform_velocity"] == [0.71875, 0.59375]
    assert record["resizes"] is False
    assert record["provenance"]["command"] == "swimlab render tiny"
    assert set(record["times"]) == set(NAMES)
    assert set(record["reference_rms_error"]) == {"0", "1", "2"}
    assert all(error > 0 for error in record["reference_rms_error"].values())
    assert read_frame(frame_path(whole, "pixel-point", 0)).shape == (16, 24, 4)


@pytest.mark.parametrize(("half", "kind"), [(True, oiio.HALF), (False, oiio.FLOAT)])
def test_the_stated_error_has_the_digits_of_the_pictures(sequence, tmp_path, half, kind):
    render_run(plan_of(sequence, techniques=("reference",), frames=(0,), half=half), tmp_path)
    for folder in ("reference", "error"):
        source = oiio.ImageInput.open(str(frame_path(tmp_path, folder, 0)))
        assert source.spec().format == kind
        source.close()


def test_halves_of_the_stated_error_leave_the_floor_as_it_is(tmp_path, tolerance):
    """So a run that was rendered when it was floats reads the same."""
    road = load("road-shift").with_changes(size=(160, 90))
    plan = Plan(road, ("pixel-point", "reference"), (0, 1), samples=4)
    render_run(plan, tmp_path / "half")
    render_run(replace(plan, half=False), tmp_path / "float")
    shutil.copytree(tmp_path / "half", tmp_path / "before")
    shutil.rmtree(tmp_path / "before" / "error")
    shutil.copytree(tmp_path / "float" / "error", tmp_path / "before" / "error")
    (now,), (before,) = (measure_run(tmp_path / name)["sequences"] for name in ("half", "before"))
    floor, as_floats = (entry["scores"]["budget.floor"] for entry in (now, before))
    assert floor == pytest.approx(as_floats, rel=tolerance("floor of halves"))
    assert floor != as_floats


def test_a_second_run_renders_only_what_is_missing(sequence, tmp_path):
    render_run(plan_of(sequence, techniques=("pixel-point",), frames=(0, 1)), tmp_path)
    frame_path(tmp_path, "pixel-point", 1).unlink()
    kept = {name: (tmp_path / name).stat().st_mtime_ns for name in files_of(tmp_path) - {"run.json"}}
    steps = []
    record = render_run(plan_of(sequence), tmp_path, advance=steps.append)
    assert steps == list(NAMES) * 3
    assert {name: (tmp_path / name).stat().st_mtime_ns for name in kept} == kept
    assert record.frames == [0, 1, 2]
    assert record.techniques == list(NAMES)


def test_resuming_gives_the_bits_of_one_go(sequence, tmp_path, whole):
    render_run(plan_of(sequence, frames=(2,)), tmp_path)
    render_run(plan_of(sequence), tmp_path)
    assert pixels(tmp_path) == pixels(whole)


@pytest.mark.parametrize("after", [1, 2, 5])
def test_an_interrupt_leaves_whole_files_and_is_resumed(sequence, tmp_path, whole, after):
    steps = []

    def advance(name):
        steps.append(name)
        if len(steps) == after:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        render_run(plan_of(sequence), tmp_path, advance=advance)
    left = files_of(tmp_path)
    assert "run.json" in left
    assert len([name for name in left if name.startswith(NAMES)]) == after
    assert not [name for name in left if "tmp" in name]
    finished, left_bits = pixels(whole), pixels(tmp_path)
    assert left_bits == {name: finished[name] for name in left_bits}
    assert set(Record.read(tmp_path).times) <= set(NAMES)
    render_run(plan_of(sequence), tmp_path)
    assert pixels(tmp_path) == finished
    assert Record.read(tmp_path).frames == [0, 1, 2]


def test_a_killed_run_has_its_stated_error_noted_on_resuming(sequence, tmp_path, tolerance):
    """A kill leaves pictures and the run.json of the start, which lists none of them."""
    plan = plan_of(sequence, techniques=("reference",))
    noted = render_run(plan, tmp_path).reference_rms_error
    assert len(noted) == 3
    fresh = Record.read(tmp_path)
    fresh.frames, fresh.techniques, fresh.reference_rms_error = [], [], {}
    fresh.write(tmp_path)
    resumed = render_run(plan, tmp_path)
    assert resumed.reference_rms_error == pytest.approx(noted, rel=tolerance("half float"))
    assert resumed.frames == [0, 1, 2]


def test_force_renders_anew(sequence, tmp_path):
    plan = plan_of(sequence, techniques=("pixel-point",), frames=(0, 1))
    render_run(plan, tmp_path)
    before = pixels(tmp_path)
    frame_path(tmp_path, "pixel-point", 0).write_text("damaged")
    stamp = frame_path(tmp_path, "geometry", 1).stat().st_mtime_ns
    render_run(plan, tmp_path, force=True)
    assert pixels(tmp_path) == before
    assert frame_path(tmp_path, "geometry", 1).stat().st_mtime_ns > stamp


def test_a_folder_of_other_settings_is_refused_and_left_alone(sequence, tmp_path):
    plan = plan_of(sequence, techniques=("pixel-point",), frames=(0, 1))
    render_run(plan, tmp_path)
    before = contents(tmp_path), (tmp_path / "run.json").read_bytes()
    other = plan_of(sequence.with_changes(seed=1), techniques=("pixel-point",), frames=(0,))
    with pytest.raises(RunError, match=f"other settings .*{plan.digest()}.*{other.digest()}.*--force"):
        render_run(other, tmp_path)
    assert (contents(tmp_path), (tmp_path / "run.json").read_bytes()) == before


def test_force_over_another_run_removes_its_pictures(sequence, tmp_path):
    render_run(plan_of(sequence), tmp_path)
    other = plan_of(sequence.with_changes(seed=1), techniques=("pixel-point",), frames=(0,))
    record = render_run(other, tmp_path, force=True)
    assert files_of(tmp_path) == {"pixel-point/0000.exr", "geometry/0000.exr", "run.json"}
    assert (record.techniques, record.frames, record.hash) == (["pixel-point"], [0], other.digest())
    assert Record.read(tmp_path).hash == other.digest()


@pytest.mark.parametrize(
    "content", ["", "[]", "{}", '{"version": 2}', '{"version": 1, "hash": "a"}', '{"version": 1, "x": 1}']
)
def test_a_broken_description_is_refused_by_name(sequence, tmp_path, content):
    (tmp_path / "run.json").write_text(content)
    with pytest.raises(RunError, match=r"run\.json"):
        render_run(plan_of(sequence), tmp_path)


def test_force_goes_over_a_broken_description(sequence, tmp_path):
    (tmp_path / "run.json").write_text("{")
    render_run(plan_of(sequence, techniques=("pixel-point",), frames=(0,)), tmp_path, force=True)
    assert Record.read(tmp_path).frames == [0]


def test_a_folder_without_description_is_no_run(tmp_path):
    with pytest.raises(RunError, match=r"run\.json: is missing"):
        Record.read(tmp_path)


def test_the_hash_is_of_all_that_decides_the_pixels(sequence):
    plan = plan_of(sequence)
    same = [plan_of(sequence), plan_of(sequence, techniques=("tsl",)), plan_of(sequence, frames=(3,))]
    spelled_out = {"tsl": {"size": 1024}}
    same.append(plan_of(sequence.with_changes(techniques=spelled_out)))
    assert {each.digest() for each in same} == {plan.digest()}
    others = [
        plan_of(sequence, samples=16),
        plan_of(sequence, half=False),
        plan_of(sequence.with_changes(seed=1)),
        plan_of(sequence.with_changes(size=(24, 18))),
        plan_of(sequence.with_changes(techniques={"tsl": {"size": 512}})),
        plan_of(sequence.with_changes(motion={"kind": "drive"})),
    ]
    assert len({plan.digest(), *(each.digest() for each in others)}) == len(others) + 1


@pytest.mark.parametrize("key", ["albedo", "normal", "gloss"])
def test_the_hash_follows_the_maps_bytes(sequence, key):
    path = sequence.folder / f"{key}.exr"
    before, plan = path.read_bytes(), plan_of(sequence)
    digest = plan.digest()
    try:
        path.write_bytes(before + b"\0")
        assert plan.digest() != digest
    finally:
        path.write_bytes(before)
    assert plan.digest() == digest


def test_pictures_carry_the_hash(whole, sequence):
    source = oiio.ImageInput.open(str(frame_path(whole, "reference", 1)))
    assert source.spec().get_string_attribute("swimlab:hash") == plan_of(sequence).digest()
    source.close()


def test_an_incomplete_run_names_what_is_missing(whole):
    check_complete(whole, NAMES, (0, 1, 2))
    with pytest.raises(FrameError, match=r"tsl.0000\.exr: is missing \(3 in all\)"):
        check_complete(whole, ("pixel-point", "tsl"), (0, 1, 2))


def test_light_beyond_the_largest_half_is_refused_and_not_written_as_infinite(sequence, tmp_path):
    scene = sequence.scene.model_dump() | {"sun": {"diffuse": 1e6}}
    bright = plan_of(sequence.with_changes(scene=scene), techniques=("pixel-bilinear",), frames=(0,))
    with pytest.raises(RunError, match="--float"):
        render_run(bright, tmp_path / "half")
    render_run(replace(bright, half=False), tmp_path / "float")
    assert read_frame(frame_path(tmp_path / "float", "pixel-bilinear", 0)).max() > LARGEST_HALF


@pytest.mark.parametrize(
    ("text", "frames"),
    [("0-3", (0, 1, 2, 3)), ("0-3x2", (0, 2)), ("3,1", (1, 3)), ("2", (2,)), ("1-2,2-3", (1, 2, 3))],
)
def test_ranges_of_frames(text, frames):
    assert parse_frames(text, 4) == frames


@pytest.mark.parametrize("text", ["", "x", "0-4", "-1", "4", "1.5", "0:2", "0-3x0"])
def test_what_is_no_range_is_refused(text):
    with pytest.raises(RunError, match=f"--frames {text}: "):
        parse_frames(text, 4)


@pytest.mark.parametrize("samples", [4, 9, 64, 4096])
def test_square_numbers_of_samples(samples):
    assert check_samples(samples) == samples


@pytest.mark.parametrize("samples", [-4, 0, 1, 2, 63, 4225])
def test_other_numbers_of_samples_are_refused(samples):
    with pytest.raises(RunError, match=f"--samples {samples}: must be a square number"):
        check_samples(samples)
