"""Rotations by vectors, Euler parameters and ZYX angles over time: w and w' (docs/theory.md 2.2, 2.4, 2.5)."""

import math

from ..language import inlined
from ..math import algebra as al


@inlined
def rotation_vector(E):
    """phi (rad, at most half a turn) of a rotation."""
    sign = 1.0 if E[3] >= 0.0 else -1.0
    axis = (sign * E[0], sign * E[1], sign * E[2])
    sine = al.norm(axis)
    return al.scale(2.0 * math.atan2(sine, sign * E[3]) / sine if sine > 0.0 else 2.0, axis)


@inlined
def rotation_of_vector(phi, rate, second):
    """(E, w, w') of exp(phi) (docs/theory.md 2.5): w = phi' + a phi x phi' + b phi x (phi x phi').

    a = (1 - cos t) / t^2 and b = (t - sin t) / t^3 for the angle t = |phi|; a' = da (phi . phi'), b' = db (phi . phi').
    """
    square = al.dot(phi, phi)

    if square < 0.01:
        a = 0.5 - square / 24.0 * (1.0 - square / 30.0 * (1.0 - square / 56.0))
        b = (1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0))) / 6.0
        da = -(1.0 - square / 15.0 * (1.0 - 3.0 * square / 112.0)) / 12.0
        db = -(1.0 - square / 21.0 * (1.0 - square / 48.0)) / 60.0
        sine = 0.5 - square / 48.0 * (1.0 - square / 80.0 * (1.0 - square / 168.0))
    else:
        t = math.sqrt(square)
        a = (1.0 - math.cos(t)) / square
        b = (t - math.sin(t)) / (t * square)
        da = (t * math.sin(t) - 2.0 * (1.0 - math.cos(t))) / (square * square)
        db = (3.0 * math.sin(t) - t * (2.0 + math.cos(t))) / (t * square * square)
        sine = math.sin(0.5 * t) / t

    E = (sine * phi[0], sine * phi[1], sine * phi[2], math.cos(0.5 * math.sqrt(square)))
    turn = al.cross(phi, rate)
    double = al.cross(phi, turn)
    w = al.axpy(b, double, al.axpy(a, turn, rate))
    along = al.dot(phi, rate)
    alpha = al.axpy(da * along, turn, al.axpy(db * along, double, second))
    turn_2 = al.cross(phi, second)
    alpha = al.axpy(a, turn_2, alpha)
    return E, w, al.axpy(b, al.add(al.cross(rate, turn), al.cross(phi, turn_2)), alpha)


@inlined
def rate_of_rotation(phi, w):
    """phi' of the rotation exp(phi), |phi| at most half a turn, that turns at w (rad/s)."""
    square = al.dot(phi, phi)

    if square < 0.01:
        factor = (1.0 + square / 60.0 * (1.0 + square / 42.0)) / 12.0
    else:
        t = math.sqrt(square)
        factor = (1.0 - 0.5 * t * math.cos(0.5 * t) / math.sin(0.5 * t)) / square

    turn = al.cross(phi, w)
    return al.axpy(factor, al.cross(phi, turn), al.axpy(-0.5, turn, w))


@inlined
def rotation_of_E(E, rate, second):
    """(E of unit length, w, w') of Euler parameters of any length and their derivatives.

    w = 2 B E' / E.E and w' = 2 B E'' / E.E - 2 (E.E') / E.E w, since B E = B' E' = 0.
    """
    s = 1.0 / al.E_dot(E, E)
    w = al.scale(2.0 * s, al.B_times(E, rate))
    alpha = al.axpy(-2.0 * s * al.E_dot(E, rate), w, al.scale(2.0 * s, al.B_times(E, second)))
    return al.E_scale(math.sqrt(s), E), w, alpha


@inlined
def rotation_of_zyx(angles, rates, seconds):
    """(E, w, w') of ZYX angles (yaw, pitch, roll): w = yaw' z + pitch' y1 + roll' x2 about axes that turn."""
    c = math.cos(angles[0])
    s = math.sin(angles[0])
    y = (-s, c, 0.0)
    x = (c * math.cos(angles[1]), s * math.cos(angles[1]), -math.sin(angles[1]))
    turning = (0.0, 0.0, rates[0])
    leaning = al.axpy(rates[1], y, turning)
    w = al.axpy(rates[2], x, leaning)
    alpha = al.axpy(seconds[1], y, (0.0, 0.0, seconds[0]))
    alpha = al.axpy(seconds[2], x, al.axpy(rates[1], al.cross(turning, y), alpha))
    return al.zyx_E(angles), w, al.axpy(rates[2], al.cross(leaning, x), alpha)
