"""The gate: scores of runs against the ceilings of a gate file and against a baseline.

`rules` reads the gate file, `baseline` what was recorded earlier; `judge` compares
them, `comparable` names settings that differ, `lacking` the missing scores, `repeats` runs that come twice; `evidence`
finds and pictures the worst place, and `outputs` writes the outcome.
"""
