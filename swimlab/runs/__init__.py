"""What lies on disk: run folders, frames, scores and reports' files; read and written here, and nowhere else."""
