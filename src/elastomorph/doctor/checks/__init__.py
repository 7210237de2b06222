"""One kind of fault a module: what it looks for, and how it says what it found."""
