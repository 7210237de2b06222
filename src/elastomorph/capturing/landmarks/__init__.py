"""Named points of a face, and distances that were measured on it."""
