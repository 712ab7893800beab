"""Formulas of swimming against the motion that follows from the same stroke by integration."""

import sys
import unittest
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent.parent / "deploy"))

from copepod_swimmers.theory import (  # noqa: E402
    Stroke,
    any_stroke_velocity,
    derivative,
    images,
    mobility,
    rotation_about_z,
    small_stroke_velocity,
    triangle_rotation,
    turning_at_a_wall,
)

PHASE = 2 * np.pi * np.arange(48) / 48


def row(radii, arms):
    """Mean velocity of three spheres in a row along z, the period being 1, by integration."""
    places = np.zeros((3, 3))
    places[1:, 2] = arms[0, 0], arms[:, 0].sum()
    moved = Stroke(places, np.array(radii), ((0, 1), (1, 2)), arms).motion(parts=60)
    return (moved[1] - moved[0])[:, 2].mean()


def triangle(radius, arms):
    """Rotation of an equilateral triangle in one period, by integration."""
    angles = 2 * np.pi * np.arange(3) / 3
    places = np.column_stack([np.cos(angles), np.sin(angles), 0 * angles]) / np.sqrt(3)
    moved = Stroke(places, np.full(3, radius), ((0, 1), (1, 2), (2, 0)), arms).motion(parts=60)
    return rotation_about_z(moved[0], moved[1])


class ThreeInARow(unittest.TestCase):
    def test_small_strokes_of_small_unequal_spheres_swim_as_golestanian_and_ajdari_say(self):
        arms = np.array([1 + 0.01 * np.cos(PHASE + 1), 1.5 + 0.02 * np.cos(PHASE)])
        for scale, tolerance in ((1e-3, 1e-3), (1e-2, 5e-3)):
            radii = scale * np.array([1, 1.3, 0.7])
            self.assertAlmostEqual(row(radii, arms) / small_stroke_velocity(radii, arms, 1), 1, delta=tolerance)

    def test_higher_harmonics_of_the_arms_count_with_their_frequency(self):
        arms = np.array([1 + 0.01 * np.cos(2 * PHASE + 0.5), 1.5 + 0.02 * np.cos(2 * PHASE)])
        slow = np.array([1 + 0.01 * np.cos(PHASE + 0.5), 1.5 + 0.02 * np.cos(PHASE)])
        doubled = small_stroke_velocity([1e-3] * 3, arms, 1) / small_stroke_velocity([1e-3] * 3, slow, 1)
        self.assertAlmostEqual(doubled, 2, delta=1e-12)

    def test_large_strokes_need_the_full_expression(self):
        arms = np.array([1 + 0.4 * np.cos(PHASE + 1), 1.5 + 0.3 * np.cos(PHASE)])
        radii = 1e-3 * np.array([1, 1.3, 0.7])
        exact = row(radii, arms)
        self.assertAlmostEqual(exact / any_stroke_velocity(radii, arms, 1), 1, delta=2e-3)
        self.assertGreater(abs(exact / small_stroke_velocity(radii, arms, 1) - 1), 0.05)

    def test_equal_spheres_have_the_published_closed_form(self):
        """a/6 ⟨(l̇₂ − l̇₁)/(l₁+l₂) + 2 (l̇₁/l₂ − l̇₂/l₁)⟩"""
        arms = np.array([1 + 0.4 * np.cos(PHASE + 1), 1.5 + 0.3 * np.cos(PHASE)])
        first, second = derivative(arms, 1)
        published = 0.1 / 6 * np.mean((second - first) / arms.sum(axis=0) + 2 * (first / arms[1] - second / arms[0]))
        self.assertAlmostEqual(any_stroke_velocity([0.1] * 3, arms, 1) / published, 1, delta=1e-12)


class InATriangle(unittest.TestCase):
    def test_a_wave_around_the_triangle_turns_it_by_an_area(self):
        wave = np.array([1 + 0.01 * np.cos(PHASE - 2 * np.pi * k / 3) for k in range(3)])
        self.assertAlmostEqual(triangle_rotation(wave, 1) / (2 * np.pi * 1e-4), 1, delta=1e-12)
        self.assertAlmostEqual(triangle(1e-5, wave) / triangle_rotation(wave, 1), 1, delta=1e-4)
        self.assertAlmostEqual(triangle(1e-5, wave[::-1]) / triangle_rotation(wave, 1), -1, delta=1e-4)
        # Interaction of the beads slows the rotation: 1 − 0.57 a/L.
        self.assertAlmostEqual(triangle(1e-2, wave) / triangle_rotation(wave, 1), 1 - 0.0057, delta=2e-4)

    def test_unequal_arms_turn_it_by_the_sum_of_their_areas(self):
        arms = np.array([1 + d * np.cos(PHASE + p) for d, p in ((0.01, 0.3), (0.02, 1.5), (0.005, 4.0))])
        self.assertAlmostEqual(triangle(1e-5, arms) / triangle_rotation(arms, 1), 1, delta=1e-2)


class Interaction(unittest.TestCase):
    def test_far_spheres_interact_as_oseen_says_and_a_pair_is_symmetric(self):
        matrix = mobility(np.array([[0, 0, 0], [0, 0, 50.0]]), np.array([1.0, 2.0]))
        np.testing.assert_allclose(matrix, matrix.T)
        self.assertAlmostEqual(matrix[2, 5] * 4 * np.pi * 50, 1, delta=1e-3)
        self.assertAlmostEqual(matrix[0, 3] * 8 * np.pi * 50, 1, delta=1e-3)
        self.assertAlmostEqual(matrix[5, 5] * 6 * np.pi * 2, 1, delta=1e-12)


class AtAWall(unittest.TestCase):
    def test_images_cancel_the_flow_on_the_wall(self):
        source, force = np.array([0.3, 0, 2]), np.array([1.0, -2, 3])
        for place in np.array([[1.0, 2, 0], [0, 0, 0], [-3, 1, 0]]):
            apart = place - source
            r = np.linalg.norm(apart)
            direct = (force / r + apart * (apart @ force) / r**3) / (8 * np.pi)
            np.testing.assert_allclose(images(place, source) @ force, -direct, atol=1e-14)

    def test_a_dipole_turns_as_the_flow_of_its_images(self):
        """A slender body turns with the component across it of the flow's gradient along it."""
        height, dipole, step = 3.0, 1.7, 1e-3
        for pitch in (-0.9, 0.0, 0.4, np.pi / 2):
            along = np.array([np.cos(pitch), 0, np.sin(pitch)])
            across = np.array([-np.sin(pitch), 0, np.cos(pitch)])
            middle = np.array([0, 0, height])

            def flow(place):
                forces = (dipole / (2 * step) * along, -dipole / (2 * step) * along)
                return sum(images(place, middle + side * step * along) @ f for side, f in zip((1, -1), forces))

            turning = across @ (flow(middle + step * along) - flow(middle - step * along)) / (2 * step)
            self.assertAlmostEqual(turning_at_a_wall(dipole, height, pitch, 1.0), turning, delta=1e-7)

    def test_a_pusher_turns_by_its_dipole_and_by_what_is_the_same_towards_and_away_from_the_wall(self):
        """Far away the part that is odd in the pitch is that of the dipole; the rest falls with the fourth power."""
        arms = np.array([14 + 2.5 * np.cos(PHASE + 1.25), 28 + 4 * np.cos(PHASE)])
        turned = {}
        for height in (480.0, 960.0):
            for pitch in (-0.5, 0.5):
                along = np.array([np.cos(pitch), 0, np.sin(pitch)])
                places = np.outer([0, arms[0, 0], arms[:, 0].sum()], along)
                places += [0, 0, height] - places.mean(axis=0)
                stroke = Stroke(places, np.full(3, 4.0), ((0, 1), (1, 2)), arms, straight=((0, 1, 2),), wall=True)
                ends = [place[2] - place[0] for place in stroke.motion(parts=24)]
                turned[height, pitch] = np.diff([np.arctan2(end[2], end[0]) for end in ends])[0]
        odd, even = (
            [(turned[height, 0.5] + sign * turned[height, -0.5]) / 2 for height in (480.0, 960.0)] for sign in (-1, 1)
        )
        self.assertAlmostEqual(odd[0] / odd[1], 8, delta=0.1)
        self.assertAlmostEqual(even[0] / even[1], 16, delta=0.3)
        per_dipole = turning_at_a_wall(1.0, 960.0, 0.5, 1.0)
        self.assertAlmostEqual(odd[1] / per_dipole / mean_dipole(arms, 4.0), 1, delta=1e-2)


def mean_dipole(arms, radius):
    """Mean of Σ f·x over a period of three spheres in a row, f the forces on the fluid, viscosity and period 1."""
    rates = derivative(arms, 1)
    total = 0.0
    for length, rate in zip(arms.T, rates.T):
        places = np.zeros((3, 3))
        places[1:, 2] = np.cumsum(length)
        pulls = np.array([[-1, 1, 0], [0, -1, 1]]) @ np.kron(np.eye(3), [[0, 0, 1]])
        total += np.linalg.solve(pulls @ mobility(places, np.full(3, radius)) @ pulls.T, rate) @ length
    return total / len(arms.T)


if __name__ == "__main__":
    unittest.main()
