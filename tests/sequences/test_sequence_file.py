import json
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import BaseModel, ConfigDict, Field

import sequences
from sequences import (
    MOTIONS,
    Camera,
    Material,
    Road,
    Scene,
    Sequence,
    SequenceError,
    Sun,
    library,
    load,
    schema,
)


class Tsl(BaseModel):
    model_config = ConfigDict(extra="forbid")
    size: int = Field(1024, ge=1, description="side of the target, texels")
    anisotropy: int = 16


class Plain(BaseModel):
    model_config = ConfigDict(extra="forbid")


SETTINGS = {"tsl": Tsl, "lod-hack": Tsl}
BRDFS = {"blinn-phong": Plain}


def toml(table, path=()):
    """A table of plain values as TOML."""
    lines = [f"[{'.'.join(path)}]"] if path else []
    lines += [f"{key} = {json.dumps(value)}" for key, value in table.items() if not isinstance(value, dict)]
    for key, value in table.items():
        if isinstance(value, dict):
            lines.append(toml(value, (*path, key)))
    return "\n".join(lines) + "\n"


@pytest.fixture
def write(tmp_path):
    def written(text):
        path = tmp_path / "a.toml"
        path.write_text(text if isinstance(text, str) else toml(text), encoding="utf-8")
        return path

    return written


def problems(path, **known):
    with pytest.raises(SequenceError) as caught:
        load(path, **known)
    assert str(caught.value).splitlines() == caught.value.problems
    for problem in caught.value.problems:
        assert problem.startswith(f"{path}: ")
    return [problem.removeprefix(f"{path}: ") for problem in caught.value.problems]


roads = st.one_of(
    st.fixed_dictionaries(
        {},
        optional={
            "width": st.floats(0.1, 100),
            "length": st.integers(1, 1000),
            "tessellation": st.tuples(st.integers(1, 256), st.integers(1, 256)).map(list),
        },
    ),
    st.fixed_dictionaries(
        {"profile": st.just("hills"), "amplitude": st.floats(0, 10), "wavelength": st.floats(1, 100)}
    ),
)
motions = st.one_of(
    st.fixed_dictionaries(
        {"kind": st.just("shift"), "velocity": st.tuples(st.floats(-9, 9), st.floats(-9, 9)).map(list)}
    ),
    st.fixed_dictionaries({"kind": st.just("scale")}, optional={"from": st.floats(0.1, 16), "to": st.floats(0.1, 16)}),
    st.fixed_dictionaries({"kind": st.sampled_from(["drive", "turn"])}, optional={"speed": st.floats(-50, 50)}),
    st.fixed_dictionaries({"kind": st.just("sun")}, optional={"azimuth_speed": st.floats(-50, 50)}),
)
files = st.fixed_dictionaries(
    {"version": st.just(1), "name": st.from_regex(r"[A-Za-z0-9][A-Za-z0-9._-]{0,20}", fullmatch=True)},
    optional={
        "frames": st.integers(1, 1000),
        "fps": st.floats(1, 1000),
        "size": st.tuples(st.integers(8, 16384), st.integers(8, 16384)).map(list),
        "seed": st.integers(0, 2**32 - 1),
        "scene": st.fixed_dictionaries(
            {},
            optional={
                "road": roads,
                "sun": st.fixed_dictionaries({"elevation": st.floats(-90, 90)}),
                "wires": st.fixed_dictionaries({"count": st.integers(1, 9)}, optional={"height": st.floats(0.01, 9)}),
            },
        ),
        "camera": st.fixed_dictionaries({}, optional={"fov": st.floats(1, 170), "yaw": st.integers(-360, 360)}),
        "motion": motions,
        "techniques": st.fixed_dictionaries({}, optional={"tsl": st.fixed_dictionaries({"size": st.integers(1)})}),
    },
)


def within(part, whole):
    """Whether every value of a nested table stands in another one."""
    if isinstance(part, dict):
        return all(key in whole and within(value, whole[key]) for key, value in part.items())
    return list(part) == list(whole) if isinstance(part, list) else part == whole


@settings(derandomize=True)
@given(data=files)
def test_a_file_survives_the_round_trip(tmp_path_factory, data):
    path = tmp_path_factory.mktemp("file") / "a.toml"
    path.write_text(toml(data), encoding="utf-8")
    sequence = load(path)
    dumped = sequence.model_dump()
    assert within(data, dumped)
    assert Sequence.model_validate(dumped).model_dump() == dumped
    assert Sequence.model_validate(json.loads(json.dumps(dumped))).model_dump() == dumped
    assert sequence.with_changes() == sequence


def test_two_keys_are_enough_and_the_rest_is_the_road(write):
    sequence = load(write('version = 1\nname = "mine"'))
    assert sequence.with_changes(name="road-shift").model_dump() == load("road-shift").model_dump()


@pytest.mark.parametrize("name", library())
def test_the_library_loads_under_its_own_names(name):
    sequence = load(name, brdfs=BRDFS, technique_settings=SETTINGS)
    assert sequence.name == name
    assert sequence.size == (640, 360)
    assert sequence.folder == library()[name].parent.resolve()


def test_the_library_covers_every_motion():
    assert {load(name).motion.kind for name in library()} == set(MOTIONS)
    frames = {name: load(name).frames for name in library()}
    sixteen = dict.fromkeys(("road-drive", "road-hills", "road-posts", "road-sliver", "road-sun", "road-turn"), 16)
    assert frames == {"road-scale": 9, "road-shift": 32} | sixteen


def test_the_shift_of_the_library_keeps_alias_orders_apart():
    """No two of the 25 orders n up to 2 share n.v modulo 1 at the resolution of 32 frames."""
    sequence = load("road-shift")
    vx, vy = sequence.motion.uniform_velocity
    places = {(nx * vx + ny * vy) % 1 * sequence.frames for nx in range(-2, 3) for ny in range(-2, 3)}
    assert len({round(place) for place in places}) == 25


def test_every_problem_is_told_at_once(write):
    path = write("""
        version = 2
        frames = "3"
        fps = true
        size = [640, 2]
        colour = "red"
        [scene.road]
        profile = "hills"
        wavelenght = 3
        [scene.material]
        brdf = "phong"
        normal = "made:gravel"
        [scene.sun]
        elevation = 91
        [camera]
        fov = nan
        [motion]
        kind = "shift"
        velocty = [0, 1]
        [techniques.tls]
        [techniques.tsl]
        size = 0
        [techniques.lod-hack]
        anisotrpy = 4
    """)
    found = problems(path, technique_settings=SETTINGS, brdfs=BRDFS)
    keys = [problem.split(":")[0] for problem in found]
    assert sorted(keys) == sorted(
        [
            "version",
            "name",
            "frames",
            "fps",
            "size.1",
            "colour",
            "scene.road.amplitude",
            "scene.road.wavelength",
            "scene.road.wavelenght",
            "scene.material.brdf",
            "scene.material.normal",
            "scene.sun.elevation",
            "camera.fov",
            "motion.velocty",
            "techniques.tls",
            "techniques.tsl.size",
            "techniques.lod-hack.anisotrpy",
        ]
    )
    said = dict(zip(keys, found, strict=True))
    assert all("(" in problem for problem in found), "each has a hint"
    assert "did you mean 'wavelength'?" in said["scene.road.wavelenght"]
    assert "did you mean 'velocity'?" in said["motion.velocty"]
    assert "did you mean 'tsl'?" in said["techniques.tls"]
    assert "did you mean 'anisotropy'?" in said["techniques.lod-hack.anisotrpy"]
    assert "known: blinn-phong" in said["scene.material.brdf"]
    assert "-90..90" in said["scene.sun.elevation"]


@pytest.mark.parametrize(
    ("text", "key", "says"),
    [
        ("size = [640]", "size.1", "missing"),
        ("size = [640, 360, 3]", "size", "at most 2"),
        ("size = [640.0, 360]", "size.0", "integer"),
        ("size = [7, 360]", "size.0", "8"),
        ("size = [640, 16385]", "size.1", "16384"),
        ("size = 640", "size", "tuple"),
        ("frames = 0", "frames", "greater than or equal to 1"),
        ("frames = 1.5", "frames", "integer"),
        ("frames = true", "frames", "integer"),
        ("fps = 0", "fps", "greater than 0"),
        ("fps = inf", "fps", "finite"),
        ('fps = "60"', "fps", "number"),
        ("seed = -1", "seed", "0"),
        ("seed = 4294967296", "seed", "4294967296"),
        ("motion = 3", "motion", "table"),
        ("motion = {}", "motion.kind", "known: drive, scale, shift"),
        ('motion = {kind = "shfit"}', "motion.kind", "did you mean 'shift'?"),
        ('motion = {kind = "shift", velocity = [1]}', "motion.velocity.1", "missing"),
        ('motion = {kind = "scale", from = 0}', "motion.from", "greater than 0"),
        ('motion = {kind = "scale", start = 1}', "motion.start", "known: from, kind, to"),
        ('motion = {kind = "scale", to = 17}', "motion.to", "16"),
        ('motion = {kind = "drive", speed = "fast"}', "motion.speed", "number"),
        ("camera = 4", "camera", "table"),
        ("camera = {height = 0}", "camera.height", "greater than 0"),
        ("camera = {fov = 180}", "camera.fov", "170"),
        ("camera = {pitch = 100}", "camera.pitch", "90"),
        ("scene = {road = {length = 0}}", "scene.road.length", "greater than 0"),
        ('scene = {road = {profile = "bumps"}}', "scene.road.profile", "'flat' or 'hills'"),
        ("scene = {road = {amplitude = 1}}", "scene.road.amplitude", "flat road"),
        ("scene = {material = {albedo = 3}}", "scene.material.albedo", "string"),
        ("scene = {sun = {diffuse = -1}}", "scene.sun.diffuse", "0"),
        ("techniques = {tsl = 3}", "techniques.tsl", "table"),
        ("techniques = 3", "techniques", "table"),
    ],
)
def test_a_bad_value_is_named_with_its_key(write, text, key, says):
    (problem,) = problems(write(f'version = 1\nname = "a"\n{text}\n'), technique_settings=SETTINGS, brdfs={"b": Plain})[
        :1
    ]
    assert problem.startswith(f"{key}: ")
    assert says in problem


@pytest.mark.parametrize("name", ["", "a/b", "..", ".hidden", "a b", "x" * 101])
def test_a_name_has_to_serve_as_a_folder(write, name):
    assert problems(write({"version": 1, "name": name}))[0].startswith("name: ")


@pytest.mark.parametrize("text", ["version = ", "version = 1\nversion = 1", "[scene", "name = road"])
def test_broken_toml_is_told_with_its_place(write, text):
    (problem,) = problems(write(text))
    assert "not TOML" in problem
    assert "line 1" in problem or "line 2" in problem or "end of document" in problem


def test_files_that_cannot_be_read(tmp_path):
    assert "No such file" in problems(tmp_path / "none.toml")[0]
    (tmp_path / "folder.toml").mkdir()
    assert "directory" in problems(tmp_path / "folder.toml")[0]
    (tmp_path / "bytes.toml").write_bytes(b'name = "\xff"')
    assert "not UTF-8" in problems(tmp_path / "bytes.toml")[0]


def test_an_unknown_name_lists_the_library():
    (problem,) = problems("road-shfit")
    assert "did you mean 'road-shift'?" in problem
    assert all(name in problem for name in library())


def test_maps_lie_beside_the_file_and_are_not_read(write):
    path = write('version = 1\nname = "a"\n[scene.material]\nalbedo = "maps/none.exr"')
    sequence = load(path)
    assert sequence.map_path("maps/none.exr") == path.parent.resolve() / "maps" / "none.exr"
    assert sequence.map_path("/absolute.exr").as_posix() == "/absolute.exr"
    assert sequence.map_path("made:asphalt") is None
    assert sequence.with_changes(frames=2).map_path("a.exr") == path.parent.resolve() / "a.exr"


def test_changes_are_checked():
    sequence = load("road-shift")
    small = sequence.with_changes(size=(64, 36), frames=4)
    assert (small.size, small.frames, small.camera) == ((64, 36), 4, sequence.camera)
    assert sequence.size == (640, 360)
    assert sequence.with_changes(motion={"kind": "drive"}).motion.kind == "drive"
    with pytest.raises(SequenceError) as caught:
        sequence.with_changes(size=(0, 36), frames=0, sise=1)
    assert [problem.split(":")[0] for problem in caught.value.problems] == ["frames", "size.0", "sise"]


def test_the_schema_tells_every_key():
    described = json.loads(json.dumps(schema(SETTINGS), allow_nan=False))
    assert described["required"] == ["version", "name"]
    for model in (Scene, Road, Material, Sun, Camera, *MOTIONS.values(), Tsl):
        table = described["$defs"][model.__name__]
        assert set(table["properties"]) == {field.alias or name for name, field in model.model_fields.items()}
        assert table["additionalProperties"] is False
    assert set(described["properties"]) == set(Sequence.model_fields)
    assert set(described["$defs"]["Scale"]["properties"]) == {"kind", "from", "to"}
    for model in (Scene, Road, Material, Sun, Camera, *MOTIONS.values()):
        fields = described["$defs"][model.__name__]["properties"].values()
        assert all("description" in field for field in fields)
    techniques = described["properties"]["techniques"]
    assert set(techniques["properties"]) == set(SETTINGS)
    assert techniques["additionalProperties"] is False
    assert set(references(described)) <= {f"#/$defs/{name}" for name in described["$defs"]}


def references(node):
    """Every reference in a schema."""
    if isinstance(node, dict):
        yield from (value for key, value in node.items() if key == "$ref")
    for child in node.values() if isinstance(node, dict) else node if isinstance(node, list) else ():
        yield from references(child)


def test_the_schema_leaves_unknown_techniques_open():
    assert schema()["properties"]["techniques"]["additionalProperties"] != False  # noqa: E712


def test_exported_names_are_there_and_sequences_do_not_change():
    assert all(hasattr(sequences, name) for name in sequences.__all__)
    sequence = load("road-shift")
    with pytest.raises(ValueError, match="frozen"):
        sequence.frames = 3
    assert math.isfinite(sequence.fps)
