"""The other poses, followed by the neutral's photographs."""
