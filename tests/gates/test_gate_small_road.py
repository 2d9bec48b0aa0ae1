"""The project's own gate: texture-space lighting and anisotropic filtering on a small road, against a baseline.

After a change that is meant, from this folder:
swimlab study small-road.toml -t tsl,pixel-aniso --samples 16 -o RUN && swimlab baseline update gate.toml RUN
"""


def test_a_small_road_costs_what_it_did(swimlab_gate):
    outcome = swimlab_gate("small-road.toml", "gate.toml", techniques=["tsl", "pixel-aniso"], samples=16, threads=2)
    assert len(outcome.checks) == 4
