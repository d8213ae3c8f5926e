"""How near parts of a net's surface are to each other, and how far they may move before any meet: kernels.

How far a pair may go is found by additive steps, each no longer than the distance left allows at the speed of its
fastest nodes (Li et al. 2021, ACM Trans. Graph. 40(4), 170, 5.2).
"""

import numpy as np

from codend.compiled import njit
from codend.mechanics.contact import Contact, room, write_corners
from codend.mechanics.nearest import NODE_TRIANGLE, closing, nearest
from codend.net.net import Floats

LEFT_OVER = 0.1
"""Share of their distance that a move leaves between two parts."""
MOST_STEPS = 60
CLOSE_ENOUGH = 0.02
"""Of the distance that may be used up: what is left of it when a pair counts as having met."""


@njit(cache=True)
def least_distance(position: Floats, contact: Contact) -> float:
    """Least distance of the pairs, m; inf where there is none."""
    found, least = room(), np.inf
    for pair in range(len(contact.kind)):
        write_corners(position, contact.node, contact.image, contact.rotations, pair, found.corner)
        least = min(least, nearest(contact.kind[pair], found)[1])
    return np.sqrt(least)


@njit(cache=True, error_model="numpy")
def free_share(position: Floats, move: Floats, contact: Contact) -> float:
    """Share of a move, at most 1, after which every pair that might meet keeps ``LEFT_OVER`` of its distance."""
    found, share = room(), 1.0
    start, way = np.zeros((4, 3)), np.zeros((4, 3))
    for pair in range(len(contact.kind)):
        kind = contact.kind[pair]
        write_corners(position, contact.node, contact.image, contact.rotations, pair, start)
        write_corners(move, contact.node, contact.image, contact.rotations, pair, way)
        if _pass_by(kind, start, way):
            continue
        speed = closing(kind, way)
        if speed == 0.0:
            continue
        found.corner[:] = start
        distance = np.sqrt(nearest(kind, found)[1])
        kept = LEFT_OVER * distance
        if distance - kept > speed * share:
            continue
        usable, at = distance - kept, 0.0
        for _ in range(MOST_STEPS):
            at += 0.9 * (distance - kept) / speed
            if at >= share:
                break
            for i in range(4):
                for j in range(3):
                    found.corner[i, j] = start[i, j] + at * way[i, j]
            distance = np.sqrt(nearest(kind, found)[1])
            if distance - kept < CLOSE_ENOUGH * usable:
                break
        share = min(share, at)
    return share


@njit(cache=True)
def _pass_by(kind: int, start: Floats, way: Floats) -> bool:
    """Whether the boxes of where the parts of a pair go do not meet."""
    own = 1 if kind == NODE_TRIANGLE else 2
    for j in range(3):
        low, high, there_low, there_high = np.inf, -np.inf, np.inf, -np.inf
        for i in range(4):
            a, b = start[i, j], start[i, j] + way[i, j]
            if i < own:
                low, high = min(low, a, b), max(high, a, b)
            else:
                there_low, there_high = min(there_low, a, b), max(there_high, a, b)
        if low > there_high or high < there_low:
            return True
    return False
