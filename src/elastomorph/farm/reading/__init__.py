"""Data sets read: faces, labels and pictures as arrays."""
