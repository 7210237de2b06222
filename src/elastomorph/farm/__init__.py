"""Data sets of faces as recipes: sampled, made on many machines, read as arrays."""
