"""The gate: scores of runs against the ceilings of a gate file and against a baseline.

`rules` reads the gate file, `baseline` what was recorded earlier, `repeats` refuses a run that comes twice; `judge`
compares them, `comparable` names settings that differ, `lacking` the missing scores. `about` says what in the frames a
score is about, `look` finds where that is worst in one of them, `evidence` over them all, with a picture; `outputs`
writes the outcome.
"""
