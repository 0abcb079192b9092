"""Geometry that knows no origami: exact planar predicates, triangles in space, distances, symmetry groups."""
