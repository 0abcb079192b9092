"""Exact planar predicates, triangles in space, distances, trees of boxes, symmetry groups."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
