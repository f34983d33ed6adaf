"""Closed forms that several cases use. Public domain (LICENSE)."""

import cmath
import math

from scipy.optimize import brentq


def damped(k, gamma, m, x, v, t):
    """Place and speed after t of m x'' = -k x - gamma x'; k per m may be anything positive, and strongly damped, too."""
    a = gamma / (2 * m)
    w = cmath.sqrt(k / m - a * a)
    c, s = cmath.cos(w * t), t if w == 0 else cmath.sin(w * t) / w
    decay = math.exp(-a * t)
    return decay * (x * c + (v + a * x) * s).real, decay * (v * c - (a * v + k / m * x) * s).real


class Impact:
    """Two things that approach each other at the speed u: a spring k and a damper gamma until they part, with the mass m."""

    def __init__(self, k, gamma, m):
        rate = gamma / (2 * m)
        self.duration = math.pi / math.sqrt(k / m - rate * rate)
        self.restitution = math.exp(-rate * self.duration)

    def after(self, gap, u, t):
        """Distance of the surfaces and its rate after t, when both have parted again."""
        free = t - gap / u - self.duration
        if free < 0:
            raise ValueError("they have not parted yet")
        return self.restitution * u * free, self.restitution * u


def two(m1, m2, x1, x2, v1, v2, reach, impact, t):
    """Places and velocities of two bodies on a line after their impact; `reach` is the distance at which they touch."""
    m, centre, mean = m1 + m2, (m1 * x1 + m2 * x2) / (m1 + m2), (m1 * v1 + m2 * v2) / (m1 + m2)
    distance, rate = impact.after(x2 - x1 - reach, v1 - v2, t)
    centre += mean * t
    distance += reach
    return centre - m2 / m * distance, centre + m1 / m * distance, mean - m2 / m * rate, mean + m1 / m * rate


class Flat:
    """A disk that is pressed on a straight wall with the constant force N at its overlap N/k_n, and driven along it with P.

    The wall is below it: u = v + omega a is the velocity of the point of contact, with the arm a = R - h/2, and du/dt = P/m + F/M with
    1/M = 1/m + a^2/I. F is the force of friction: -k_t s - gamma_t u while it sticks, -+mu N while it slides.
    """

    def __init__(self, m, inertia, radius, law, pressed, along, v):
        kn, self.kt, self.gt, mu = law[0], law[1], law[3], law[4]
        self.m, self.inertia, self.arm, self.along = m, inertia, radius - pressed / kn / 2, along
        self.reduced = 1 / (1 / m + self.arm**2 / inertia)
        self.limit = mu * pressed
        self.x, self.v, self.theta, self.omega, self.s, self.t = 0.0, v, 0.0, 0.0, 0.0, 0.0

    @property
    def slip(self):
        return self.v + self.omega * self.arm

    def _moved(self, t, slip, slipped, s):
        """After t more, with the slip velocity and its integral: what F did follows from both."""
        m, u0 = self.m, self.slip
        impulse = self.reduced * (slip - u0 - self.along / m * t)
        twice = self.reduced * (slipped - u0 * t - self.along / m * t * t / 2)
        self.x += self.v * t + self.along / m * t * t / 2 + twice / m
        self.theta += self.omega * t + self.arm / self.inertia * twice
        self.v += self.along / m * t + impulse / m
        self.omega += self.arm / self.inertia * impulse
        self.s, self.t = s, self.t + t

    def _stuck(self, t):
        """Elongation and slip velocity after t: an oscillator about the elongation that holds P."""
        rest = self.reduced * self.along / self.m / self.kt
        x, v = damped(self.kt, self.gt, self.reduced, self.s - rest, self.slip, t)
        return rest + x, v

    def stick(self, end):
        """Sticks until `end`, or until the test force leaves the cone."""
        test = lambda t: abs(self.kt * self._stuck(t)[0] + self.gt * self._stuck(t)[1]) - self.limit  # noqa: E731
        grid = [(end - self.t) * k / 20000 for k in range(1, 20001)]
        out = next((k for k, t in enumerate(grid) if test(t) > 0), None)
        t = end - self.t if out is None else brentq(test, grid[out - 1] if out else 0.0, grid[out], xtol=1e-15)
        s, u = self._stuck(t)
        self._moved(t, u, s - self.s, s)
        return out is not None

    def slide(self, end):
        """Slides until `end`, or until the test force comes back to the cone."""
        side = math.copysign(1, self.kt * self.s + self.gt * self.slip)  # of the elongation to which the spring goes
        u0, s0, held = self.slip, self.s, side * self.limit / self.kt
        rate = self.along / self.m - side * self.limit / self.reduced
        spring = lambda t: held + (s0 - held) * math.exp(-self.kt / self.gt * t)  # noqa: E731
        margin = lambda t: side * (self.kt * (spring(t) - held) + self.gt * (u0 + rate * t))  # noqa: E731
        left = end - self.t
        grid = [left * k / 20000 for k in range(1, 20001)]
        back = next((k for k, t in enumerate(grid) if margin(t) < 0), None)
        t = left if back is None else brentq(margin, grid[back - 1] if back else 0.0, grid[back], xtol=1e-15)
        self._moved(t, u0 + rate * t, u0 * t + rate * t * t / 2, spring(t))
        return back is not None

    def advance(self, end):
        while self.t < end:
            if abs(self.kt * self.s + self.gt * self.slip) > self.limit * (1 + 1e-12):
                self.slide(end)
            elif self.stick(end):
                self.slide(end)
        return self
