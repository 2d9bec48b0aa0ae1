"""The report on hard cases."""
