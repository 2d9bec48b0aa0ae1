"""The report on reflectance models."""
