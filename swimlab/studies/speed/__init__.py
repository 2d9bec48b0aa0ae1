"""The report on speed against error."""
