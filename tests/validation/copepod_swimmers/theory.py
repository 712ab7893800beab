"""Swimmers of spheres at zero Reynolds number: closed formulas, and the motion that follows from a stroke.

Arrays of a stroke hold one period in equal parts, without its end: shape (arms, samples), any one unit of length.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

Arms = Sequence[tuple[int, int]]  # numbers of the two beads
Numbers = Sequence[float] | np.ndarray


def geometrical_factor(radii: Numbers, mean_arms: Numbers) -> float:
    """K = 3 r₁r₂r₃ / (2 (r₁+r₂+r₃)²) · [1/l̄₁² + 1/l̄₂² − 1/(l̄₁+l̄₂)²]   [paper, eq. (29)]; any one unit of length."""
    first, second = mean_arms
    brackets = 1 / first**2 + 1 / second**2 - 1 / (first + second) ** 2
    return 3 * np.prod(radii) / (2 * np.sum(radii) ** 2) * brackets


def small_stroke_velocity(radii: Numbers, arms: np.ndarray, period: float) -> float:
    """Three spheres in a row, small strokes of any wave form   [Golestanian & Ajdari, Phys. Rev. E 77, 036308 (2008)].

        u = K ⟨u₁ u̇₂ − u̇₁ u₂⟩ = K ω Σ_n n d₁ₙ d₂ₙ sin(φ₁ₙ − φ₂ₙ)

    with the arms l̄ᵢ + uᵢ, uᵢ = Σ_n dᵢₙ cos(nωt + φᵢₙ). Leading order in radius over arm and in stroke over arm.

    @param radii  trailing, middle, leading
    @param arms   l₁ (trailing to middle) and l₂ (middle to leading), shape (2, samples)
    @return the mean velocity from trailing to leading
    """
    mean = arms.mean(axis=1)
    first, second = arms - mean[:, None]
    rates = derivative(arms, period)
    return geometrical_factor(radii, mean) * float(np.mean(first * rates[1] - rates[0] * second))


def any_stroke_velocity(radii: Numbers, arms: np.ndarray, period: float) -> float:
    """Three spheres in a row, strokes of any size   [Golestanian & Ajdari (2008), there for equal spheres].

    Without interaction the beads move with ẋᵢ and exert the forces 6πη aᵢ (ẋᵢ − V), V = Σ aᵢẋᵢ/Σ aᵢ. Inserted in
    Oseen's interaction, with the sum of forces zero, these give to first order in radius over arm

        u = ⟨ 3/(2 Σ a) Σ_{i<j} aᵢ aⱼ (ẋᵢ + ẋⱼ − 2V)/|xⱼ − xᵢ| ⟩

    which for equal spheres is their a/6 ⟨(l̇₂ − l̇₁)/(l₁+l₂) + 2 (l̇₁/l₂ − l̇₂/l₁)⟩.

    @return the mean velocity from trailing to leading
    """
    radius = np.asarray(radii, float)
    place = np.array([np.zeros_like(arms[0]), arms[0], arms.sum(axis=0)])
    speed = derivative(place, period)
    speed = speed - radius @ speed / radius.sum()
    total = sum(
        radius[i] * radius[j] * (speed[i] + speed[j]) / (place[j] - place[i]) for i, j in ((0, 1), (0, 2), (1, 2))
    )
    return float(np.mean(1.5 / radius.sum() * total))


def triangle_rotation(arms: np.ndarray, period: float) -> float:
    """Mean angular velocity of an equilateral triangle of equal beads, for small strokes and small beads.

        Ω = 2/(3√3 L²) Σ_cyclic ⟨u_k u̇_{k+1} − u̇_k u_{k+1}⟩

    Arm k connects the beads k and k + 1, numbered against the clock; a positive Ω turns in that direction. Arms
    L + ε cos(ωt − 2πk/3) turn the triangle by 2π (ε/L)² in every period. Derivation: let beads without interaction
    be at c₁e^{2πik/3} + c₂e^{−2πik/3} in the complex plane; no torque means Im(c̄₁ċ₁ + c̄₂ċ₂) = 0, and to first
    order the arms' changes are √3 Re(c₂e^{iπ/3}e^{2πik/3}) for real c₁ = L/√3. The interaction of the beads adds
    terms of the order of radius over arm.
    """
    mean = arms.mean()
    change = arms - arms.mean(axis=1)[:, None]
    rates = derivative(arms, period)
    swept = change * np.roll(rates, -1, axis=0) - rates * np.roll(change, -1, axis=0)
    return float(2 / (3 * np.sqrt(3) * mean**2) * swept.mean(axis=1).sum())


def derivative(values: np.ndarray, period: float) -> np.ndarray:
    """Rate of change of functions that repeat themselves; the last axis is one period."""
    samples = values.shape[-1]
    waves = np.fft.rfft(values)
    orders = np.arange(waves.shape[-1])
    if samples % 2 == 0:
        orders[-1] = 0  # the highest wave of an even number of samples has no sine part
    return np.fft.irfft(2j * np.pi / period * orders * waves, samples)


def mobility(places: np.ndarray, radii: np.ndarray, wall: bool = False) -> np.ndarray:
    """Velocities per force of spheres in fluid of viscosity 1   [Rotne & Prager 1969; Zuk et al. 2014].

    @param places  shape (n, 3)
    @param wall    beside a no-slip wall at z = 0, whose images act on points: without terms of the order (a/z)³
    @return shape (3n, 3n)
    """
    one, itself = np.eye(3), np.arange(len(radii))
    apart = places[:, None] - places
    distance = np.linalg.norm(apart, axis=2)[..., None, None]
    distance[itself, itself] = 1.0
    along = apart[..., None] * apart[..., None, :] / distance**2
    squares = np.add.outer(radii**2, radii**2)[..., None, None] / distance**2
    blocks = ((1 + squares / 3) * one + (1 - squares) * along) / (8 * np.pi * distance)
    blocks[itself, itself] = one / (6 * np.pi * radii[:, None, None])
    if wall:
        blocks += [[images(place, source) for source in places] for place in places]
    return blocks.swapaxes(1, 2).reshape(3 * len(radii), -1)


def images(place: np.ndarray, source: np.ndarray) -> np.ndarray:
    """Flow at `place` per force at `source`, of its images behind a no-slip wall at z = 0   [Blake 1971].

    The wall's part of Green's function of the half space, viscosity 1: with R from the mirror image of the source, h
    its height, Δ = diag(1, 1, −1) and S = 1/R + RR/R³,

        8π G = −S + (2h² ∇(R/R³) − 2h ∇S·e_z) Δ
    """
    height, mirror, up = source[2], np.diag([1.0, 1.0, -1.0]), np.array([0, 0, 1.0])
    apart = place - mirror @ source
    r = np.linalg.norm(apart)
    one, square = np.eye(3), np.outer(apart, apart)
    source_dipole = one / r**3 - 3 * square / r**5
    mixed = np.outer(apart, up)
    dipole = (mixed - mixed.T + apart[2] * one) / r**3 - 3 * apart[2] * square / r**5
    flow = -(one / r + square / r**3) + (2 * height**2 * source_dipole - 2 * height * dipole) @ mirror
    return flow / (8 * np.pi)


@dataclass(frozen=True)
class Stroke:
    """Spheres that forces along arms hold at given distances: neither a force nor a torque from outside.

    places   at the start, shape (beads, 3); their distances are made those of `lengths`
    radii    shape (beads,)
    arms     pairs of beads; as many as it takes to fix the shape of every swimmer that is not in a row
    lengths  of the arms over one period, shape (arms, samples)
    straight triples of beads that stay on a line
    wall     beside a no-slip wall at z = 0
    """

    places: np.ndarray
    radii: np.ndarray
    arms: Arms
    lengths: np.ndarray
    straight: Sequence[tuple[int, int, int]] = ()
    wall: bool = False

    def motion(self, periods: int = 1, parts: int = 200) -> np.ndarray:
        """Places of the beads after 0, 1, … periods, shape (periods + 1, beads, 3); Runge-Kutta, `parts` a period.

        The forces s along the arms follow from l̇ = B s with B = E M Eᵀ; v = M Eᵀ s. E: velocities → rates of arms.
        """
        nodes = np.arange(2 * parts) / (2 * parts)
        lengths = _at(self.lengths, nodes)
        rates = _at(derivative(self.lengths, 1.0), nodes)
        place = self._adjusted(lengths[:, 0])
        result = [place]
        for _ in range(periods):
            for part in range(parts):
                first, middle, last = (rates[:, (2 * part + k) % (2 * parts)] for k in range(3))
                step = 1 / parts
                k1 = self._velocity(place, first)
                k2 = self._velocity(place + step / 2 * k1, middle)
                k3 = self._velocity(place + step / 2 * k2, middle)
                k4 = self._velocity(place + step * k3, last)
                place = place + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
            result.append(place)
        return np.array(result)

    def _velocity(self, place: np.ndarray, rates: np.ndarray) -> np.ndarray:
        extension = self._extension(place)
        response = mobility(place, self.radii, self.wall) @ extension.T
        wanted = np.concatenate([rates, np.zeros(len(extension) - len(rates))])
        return (response @ np.linalg.solve(extension @ response, wanted)).reshape(-1, 3)

    def _extension(self, place: np.ndarray) -> np.ndarray:
        """E: rates of change of the arms from velocities, then those of the kinks, shape (constraints, 3 beads)."""
        rows = []
        for i, j in self.arms:
            row = np.zeros((len(place), 3))
            row[j] = _unit(place[j] - place[i])
            row[i] = -row[j]
            rows.append(row)
        for i, j, k in self.straight:
            first, second = np.linalg.norm(place[j] - place[i]), np.linalg.norm(place[k] - place[j])
            along = _unit(place[k] - place[i])
            across = _unit(np.cross(along, np.eye(3)[np.argmin(np.abs(along))]))
            for direction in (across, np.cross(along, across)):
                row = np.zeros((len(place), 3))
                row[i], row[k] = direction / first, direction / second
                row[j] = -row[i] - row[k]
                rows.append(row)
        return np.array(rows).reshape(len(rows), -1)

    def _adjusted(self, lengths: np.ndarray) -> np.ndarray:
        """The places moved along the arms, in equal and opposite shares, until the arms have these lengths."""
        place = np.array(self.places, float)
        for _ in range(20):
            now = np.array([np.linalg.norm(place[j] - place[i]) for i, j in self.arms])
            missing = np.concatenate([lengths - now, np.zeros(2 * len(self.straight))])
            place = place + (np.linalg.pinv(self._extension(place)) @ missing).reshape(-1, 3)
        return place


def _unit(vector: np.ndarray) -> np.ndarray:
    return vector / np.linalg.norm(vector)


def _at(values: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """Functions of period 1 at other times, by their Fourier series; the last axis is one period."""
    samples = values.shape[-1]
    waves = np.fft.rfft(values) / samples
    orders = np.arange(waves.shape[-1])
    weights = np.where((orders == 0) | ((samples % 2 == 0) & (orders == samples // 2)), 1.0, 2.0)
    return np.real((waves * weights) @ np.exp(2j * np.pi * np.outer(orders, nodes)))


def rotation_about_z(before: np.ndarray, after: np.ndarray) -> float:
    """Angle of the best rigid motion in the x-y plane between two sets of places, shape (beads, 3) [rad]."""
    first, second = (places[:, :2] - places[:, :2].mean(axis=0) for places in (before, after))
    turned = np.sum(np.conj(first @ [1, 1j]) * (second @ [1, 1j]))
    return float(np.angle(turned))


def turning_at_a_wall(dipole: float, height: float, pitch: float, viscosity: float) -> float:
    """Rate of the pitch of a slender swimmer of force dipole p far from a no-slip wall.

        θ̇ = −3p/(128πηh³) sin 2θ (1 + (1 + sin²θ)/2)

    [Berke et al., Phys. Rev. Lett. 101, 038102 (2008); Spagnolie & Lauga, J. Fluid Mech. 700, 105 (2012); their
    shape factor Γ = 1]. p > 0 is a pusher: it pushes the fluid away in front and behind.

    @param pitch  θ between the swimmer and the wall, positive away from it [rad]
    """
    strength = 3 * dipole / (128 * np.pi * viscosity * height**3)
    return float(-strength * np.sin(2 * pitch) * (1 + (1 + np.sin(pitch) ** 2) / 2))
