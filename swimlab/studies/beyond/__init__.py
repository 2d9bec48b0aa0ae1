"""The report on what lies beyond the deck: techniques, moment chains, texture-space lighting and more."""
