"""What a face is: a surface, its paths and its frames."""
