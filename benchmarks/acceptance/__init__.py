"""Whether a bent character is the character it was: judged without any code of the package.

Files are read, posed and played here from the specification of glTF 2.0, with NumPy alone.
"""
