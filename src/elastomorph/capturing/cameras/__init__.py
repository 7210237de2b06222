"""Where cameras stood, and poses in one frame."""
