"""From a sequence to pictures: scene, techniques, renderer and run."""
