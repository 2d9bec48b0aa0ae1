"""What notebooks and scripts call: studies, scores as tables, frames as pictures."""
