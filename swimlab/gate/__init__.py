"""The gate: scores of runs against the ceilings of a gate file and against a baseline.

`rules` reads the gate file, `measured` the scores of runs, `baseline` what was recorded earlier; `judge` compares
them, `comparable` names settings that differ, `lacking` the scores that are not there, `evidence` finds
and pictures the worst place, and `table`, `junit` and `github` write the outcome.
"""
