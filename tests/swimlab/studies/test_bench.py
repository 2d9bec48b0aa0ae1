"""What `bench` prints; never how fast it was."""


def test_measures_are_timed_by_family(swimlab):
    code, out, err = swimlab("bench", "measures", "--size", "96x80", "--frames", "4", "-q")
    assert (code, err) == (0, "")
    assert "The limit is the transform" in " ".join(out.split())
    for row in ("transforms alone", "budget", "residual", "plane", "budget, residual, plane", "all"):
        assert any(line.strip().startswith(row) for line in out.splitlines())


def test_a_clip_too_small_to_measure_is_refused(swimlab):
    code, _, err = swimlab("bench", "measures", "--size", "32x32", "-q")
    assert code == 2
    assert "64x64" in err
