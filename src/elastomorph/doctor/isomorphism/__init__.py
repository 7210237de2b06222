"""Which vertex of one file is which of another: an isomorphism of their polygons.

Vertices are told apart by colour refinement, matched by a traversal of half-edges or, where that
does not get everywhere, by backtracking; positions choose among the automorphisms.
"""
