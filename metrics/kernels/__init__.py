"""What runs on all cores: the launcher."""
