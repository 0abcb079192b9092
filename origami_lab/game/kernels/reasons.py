"""Why the rules refuse a place or a leaf: the numbers that the kernels answer with.

0 is no reason: it may be played. :mod:`origami_lab.game.legality` names each and says it in a sentence.
"""

from __future__ import annotations

FITS = 0

# places of a child
ON_THE_LEAF = 1
OFF_THE_BOARD = 2
IN_ANOTHER_IMAGE = 3
OUT_OF_ORDER = 4
TOO_LONG = 5
TOO_SHORT = 6
OVER_THE_SHEET = 7
HALF_TURN_OR_MORE = 8
STRAIGHT_AND_STIFF = 9
TOO_SHARP = 10
NO_ROOM_BESIDE = 11
MERGES_WITH_IMAGE = 12
ON_A_MIRROR = 13
OFF_THE_MIRROR = 14
ALONG_THE_BOUNDARY = 15
TOO_NARROW = 16
CROSSES = 17
COVERS_A_CORNER = 18
TRIANGLE_INEQUALITY = 19
OPENS_THE_OTHER_WAY = 20
NOT_BETWEEN = 21

# leaves that cannot be extended
AT_THE_EDGE = 22
ON_TWO_MIRRORS = 23
CLOSED_SECTOR = 24
WITHOUT_CREASE = 25
STRAIGHT_SECTOR = 26
NO_SIDE_OPEN = 27

# what only the motion tells
COLLIDES = 28
DOES_NOT_CLOSE = 29

# where nothing can be asked
NO_LEAF = 30
