"""The report of a run: one HTML page that works offline, and a contact sheet for a README."""
