"""The interactive view of a run: its numbers, and that Chromium draws, plays, turns and explains it."""

import base64
import itertools
import json
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import numpy as np

import copepod_session  # noqa: F401  (makes the command's modules importable)
from browser import CHROMIUM, Browser
from surfaces import with_surfaces
from copepod_report import page, view
from copepod_report.scene import MOST_SAMPLES, Samples, most_frames, scene_of
from copepod_report.trajectory import chosen_samples

BEADS = [
    {"shape": "sphere", "radius_m": 4e-6, "length_m": 0},
    {"shape": "capsule", "radius_m": 4e-6, "length_m": 8e-6},
    {"shape": "sphere", "radius_m": 4e-6, "length_m": 0},
]
CASE = {
    "fluid": {
        "domain_cells": [40, 40, 80],
        "boundaries": {
            "x": {"low": "no_slip", "high": {"velocity_m_per_s": [0, 0, 1]}},
            "y": {"low": "no_slip", "high": {"pressure_Pa": 0}},
            "z": {"low": "periodic", "high": "periodic"},
        },
        "symmetry_planes": ["x"],
    },
    "swimmers": [{"name": "swimmer", "beads": BEADS, "stroke": {"period_steps": 100}}],
}
# Brightest channel of the beads' colours: blue, red, green. Counts pixels of each, and sums up the picture.
PLAY_BUTTON = """(() => {
  const [button, path] = [".play", ".play path"].map((name) => document.querySelector(name));
  const {width, height} = path.getBoundingClientRect();
  return {text: button.textContent, shape: path.getAttribute("d"), width, height};
})()"""
PICTURE = """(() => {
  const view = window.copepod.views[0];
  view.drawNow();
  const copy = document.createElement("canvas");
  [copy.width, copy.height] = [view.canvas.width, view.canvas.height];
  const paint = copy.getContext("2d");
  paint.drawImage(view.canvas, 0, 0);
  const counts = {blue: 0, red: 0, green: 0, sum: 0};
  const pixels = paint.getImageData(0, 0, copy.width, copy.height).data;
  for (let at = 0; at < pixels.length; at += 4) {
    const [r, g, b, a] = pixels.slice(at, at + 4);
    counts.sum = (counts.sum * 31 + r + 2 * g + 3 * b) % 1000003;
    if (a < 255 || Math.max(r, g, b) - Math.min(r, g, b) < 60) continue;
    counts[b > r && b > g ? "blue" : r > g ? "red" : "green"]++;
  }
  return counts;
})()"""

# Of every body and image: where it is, and whether it is what the picture shows there; ends of the rods; a turned body.
IMAGES = """(() => {
  const {stage} = window.copepod.views[0];
  const bodies = stage.entries.map((entry) => {
    const place = stage.placeOf(entry);
    const {left, top} = stage.projected(place);
    return {image: entry.image, place, isSeen: stage.entryAt(2 * left - 1, 1 - 2 * top) === entry};
  });
  const rods = [...stage.rods.userData].map(({from, to, image}, number) => {
    const pose = new THREE.Matrix4();
    stage.rods.getMatrixAt(number, pose);
    const drawn = [-0.5, 0.5].map((z) => new THREE.Vector3(0, 0, z).applyMatrix4(pose).toArray());
    return {drawn, ends: [from, to].map((body) => stage.placeOf({body, image}))};
  });
  const {w, x, y, z} = stage.states[1].orientation;
  return {bodies, rods, turned: [w, x, y, z]};
})()"""


def samples_of(count=201):
    """Three beads in a row beside the mirror plane; the middle one turns about x."""
    steps = np.arange(count)
    angle = 2 * np.pi * steps / 100
    position = np.empty((count, 3, 3))
    position[..., 0], position[..., 1] = 20e-6, 20e-6
    position[:, 0, 2] = 24e-6 + 2e-6 * np.cos(angle)
    position[:, 1, 2] = 40e-6 + 2e-8 * steps
    position[:, 2, 2] = 56e-6 + 3e-6 * np.sin(angle)
    orientation = np.zeros((count, 3, 4))
    orientation[..., 0] = 1.0
    orientation[:, 1, 0], orientation[:, 1, 1] = np.cos(angle / 2), np.sin(angle / 2)
    velocity = np.broadcast_to([0, 0, 2e-3], (count, 3, 3))
    names = [f"swimmer.{bead}" for bead in ("B2", "B1", "B3")]
    return Samples(names, steps, 1e-9 * steps, position, orientation, velocity)


def numbers(text, kind):
    return np.frombuffer(base64.b64decode(text), kind)


class Scene(unittest.TestCase):
    def setUp(self):
        self.scene = scene_of("three beads", with_surfaces(CASE), 1e-6, samples_of())

    def test_positions_are_exact_to_a_ten_thousandth_of_the_motion(self):
        motion = self.scene["motion"]
        levels = numbers(motion["positions"], "<u2").reshape(201, 3, 3)
        found = np.array(motion["low"]) + np.array(motion["span"]) * levels / 65535
        np.testing.assert_allclose(found, 1e6 * samples_of().position_m, atol=1e-4 * 6)

    def test_speeds_are_shares_of_the_fastest_of_each_body(self):
        motion = self.scene["motion"]
        self.assertEqual(motion["fastest_m_per_s"], [2e-3] * 3)
        self.assertEqual(set(numbers(motion["speeds"], "<u2")), {65535})

    def test_only_bodies_that_turn_have_orientations_by_sample(self):
        motion = self.scene["motion"]
        self.assertEqual(motion["turning"], [1])
        vectors = numbers(motion["rotations"], "<i2").reshape(201, 1, 3) / 32767
        expected = samples_of().orientation_wxyz[:, 1]
        expected = expected * np.where(expected[:, :1] < 0, -1, 1)
        np.testing.assert_allclose(vectors[:, 0], expected[:, 1:], atol=1e-4)

    def test_shapes_arms_and_domain_come_from_the_case(self):
        self.assertEqual(self.scene["unit"], "µm")
        self.assertEqual(self.scene["arms"], [[0, 1], [1, 2]])
        surfaces = [self.scene["surfaces"][body["surface"]] for body in self.scene["bodies"]]
        points = [numbers(surface["points"], "<f4").reshape(-1, 3) for surface in surfaces]
        np.testing.assert_allclose(
            [np.abs(corners).max(axis=0) for corners in points], [[4, 4, 4], [4, 4, 8], [4, 4, 4]]
        )
        box = self.scene["box"]
        self.assertEqual(box["walls"], ["x_low", "x_high", "y_low"])
        self.assertEqual((box["periodic"], box["symmetry"]), (["z"], ["x"]))
        np.testing.assert_allclose(box["size"], [40, 40, 80])

    def test_rods_are_drawn_and_the_period_of_their_motion_is_a_cycle(self):
        rod = {"kind": "distance", "bodies": ["swimmer.B2", "swimmer.B3"], "signal": {"period_steps": 40}}
        hook = {"kind": "hinge", "bodies": ["swimmer.B1", "world"]}
        swimmer = {name: value for name, value in CASE["swimmers"][0].items() if name not in ("arms", "stroke")}
        scene = scene_of(
            "rods", with_surfaces({**CASE, "swimmers": [swimmer], "joints": [hook, rod]}), 1e-6, samples_of()
        )
        self.assertIn([0, 2], scene["arms"])
        self.assertEqual(scene["period_steps"], 40)

    def test_long_runs_and_swarms_are_thinned_and_keep_their_last_sample(self):
        shown = chosen_samples(5000, 100)
        self.assertLessEqual(len(shown), 101)
        self.assertEqual(shown[-1], 4999)
        self.assertLessEqual(300 * most_frames(300), MOST_SAMPLES)
        self.assertLessEqual(100 * 300 * most_frames(300, views=100), 4 * MOST_SAMPLES)

    def test_the_caption_names_what_is_shown_and_what_bounds_it(self):
        flow = {"title": "Speed in the plane at step 7", "most_m_per_s": 0.012345}
        wall = {"size": None, "walls": ["z_low"], "periodic": [], "symmetry": []}
        faces = "walls at x, y low; periodic along z; mirror planes across x"
        domain = f"3 bodies, 201 samples of the trajectory. Domain 40 × 40 × 80 µm; {faces}."
        open_box = {"size": [1.0, 2.0, 12345.6], "walls": [], "periodic": [], "symmetry": []}
        for changed, expected in (
            ({}, domain),
            (
                {"flow": flow},
                f"{domain} {flow['title']}: 0 <span class=\"scale\"></span> 0.0123 m/s, square-root scale.",
            ),
            ({"box": None, "bodies": self.scene["bodies"][:1]}, "1 body, 201 samples of the trajectory."),
            ({"box": wall}, "3 bodies, 201 samples of the trajectory. Wall at z = 0."),
            ({"box": open_box}, "… Domain 1 × 2 × 1.235e+04 µm; open on all sides."),
        ):
            html = view.figure({**self.scene, **changed})
            self.assertIn(f"{expected.removeprefix('…')}</figcaption>", html)

    def test_names_cannot_end_the_script(self):
        html = view.figure({**self.scene, "name": "</script><b>"})
        self.assertEqual(html.count("</script>"), 1)

    def test_missing_three_js_is_named(self):
        with mock.patch.object(view, "THREE_JS", Path("/nothing")):
            self.assertIn("libjs-three", view.figure(self.scene))
            self.assertEqual(view.scripts(), "")


@unittest.skipUnless(CHROMIUM, "chromium is not installed (deploy/copepod setup --ci installs it)")
class InChromium(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="copepod_view_")
        cls.addClassCleanup(folder.cleanup)
        cls.path = Path(folder.name) / "page.html"
        scene = {**scene_of("three beads", with_surfaces(CASE), 1e-6, samples_of()), "flow": None}
        cls.path.write_text(page.page("A view", [view.figure(scene), view.scripts()]))

    def opened(self, path=None, **how):
        browser = Browser(**how)
        self.addCleanup(browser.__exit__)
        browser.open(f"file://{path or self.path}")
        browser.wait_for("document.querySelector('.stage').dataset.drawn > 0")
        return browser

    def test_it_draws_plays_turns_and_explains(self):
        browser = self.opened()
        first = browser.value(PICTURE)
        for colour in ("blue", "red", "green"):
            self.assertGreater(first[colour], 300, first)

        with self.subTest("plays to the end"):
            browser.value("window.copepod.views[0].speed.value = 4")
            button = browser.value(PLAY_BUTTON)
            self.assertEqual(button["text"], "")  # a font may lack the character
            self.assertGreater(min(button["width"], button["height"]), 8)
            browser.value("document.querySelector('.play').click()")
            self.assertNotEqual(browser.value(PLAY_BUTTON)["shape"], button["shape"])
            browser.wait_for("window.copepod.views[0].at === 200 && !window.copepod.views[0].playing")
            self.assertIn("step 200", browser.value("document.querySelector('.clock').textContent"))
            played = browser.value(PICTURE)
            self.assertNotEqual(played["sum"], first["sum"])

        frame = browser.value("JSON.stringify(document.querySelector('canvas').getBoundingClientRect())")
        frame = json.loads(frame)
        with self.subTest("turns with the mouse"):
            height = browser.value("window.copepod.views[0].stage.camera.position.x")  # x is upwards
            browser.drag(frame["x"] + 30, frame["y"] + 30, 200, 40)
            self.assertNotEqual(browser.value(PICTURE)["sum"], played["sum"])
            self.assertGreater(browser.value("window.copepod.views[0].stage.camera.position.x"), height)

        with self.subTest("moves what is shown along with the mouse"):
            target = browser.value("window.copepod.views[0].orbit.target.toArray()")
            browser.drag(frame["x"] + 30, frame["y"] + 30, 60, -40, modifiers=8)
            browser.value("window.copepod.views[0].drawNow()")
            place = browser.value(f"window.copepod.views[0].stage.projected({target})")
            self.assertAlmostEqual((place["left"] - 0.5) * frame["width"], 60, delta=0.1)
            self.assertAlmostEqual((place["top"] - 0.5) * frame["height"], -40, delta=0.1)

        with self.subTest("zooms and plays with keys"):
            distance = browser.value("window.copepod.views[0].orbit.distance")
            browser.value("document.querySelector('canvas').focus()")
            browser.press("+")
            self.assertLess(browser.value("window.copepod.views[0].orbit.distance"), distance)
            browser.press(" ")
            browser.wait_for("window.copepod.views[0].playing")
            browser.press(" ")
            self.assertFalse(browser.value("window.copepod.views[0].playing"))

        with self.subTest("zooms with two fingers"):
            distance = browser.value("window.copepod.views[0].orbit.distance")
            browser.call("Emulation.setTouchEmulationEnabled", enabled=True, maxTouchPoints=2)
            middle = frame["x"] + frame["width"] / 2, frame["y"] + frame["height"] / 2
            for kind, apart in (("touchStart", 50), ("touchMove", 70), ("touchMove", 100), ("touchEnd", None)):
                places = [{"x": middle[0] + side, "y": middle[1]} for side in (-apart, apart)] if apart else []
                browser.call("Input.dispatchTouchEvent", type=kind, touchPoints=places)
            browser.call("Emulation.setTouchEmulationEnabled", enabled=False)
            self.assertAlmostEqual(browser.value("window.copepod.views[0].orbit.distance") / distance, 0.5, delta=0.05)

        with self.subTest("shows and hides, and looks at the bodies or at the whole domain"):
            isShown = "window.copepod.views[0].stage.pathLooks[0].visible"
            browser.value("document.querySelector('[name=paths]').click()")
            self.assertFalse(browser.value(isShown))
            browser.value("document.querySelector('[name=paths]').click()")
            self.assertTrue(browser.value(isShown))
            distances = []
            for name in ("bodies", "domain"):
                browser.value(f"document.querySelector('button[name={name}]').click()")
                distances.append(browser.value("window.copepod.views[0].orbit.distance"))
            self.assertLess(distances[0], distances[1])
            self.assertTrue(browser.value("document.querySelector('[name=flow]').parentElement.hidden"))

        with self.subTest("names what is under the pointer"):
            browser.value("window.copepod.views[0].goTo(0); window.copepod.views[0].drawNow()")
            place = browser.value("window.copepod.views[0].stage.projected([20, 20, 56])")
            browser.hover(frame["x"] + place["left"] * frame["width"], frame["y"] + place["top"] * frame["height"])
            browser.wait_for("!document.querySelector('.tip').hidden")
            tip = browser.value("document.querySelector('.tip').textContent")
            self.assertIn("swimmer.B3", tip)
            self.assertIn("20.00, 20.00, 56.00", tip)
            self.assertIn("2 mm/s", tip)

        with self.subTest("draws a capsule in its whole length"):
            heights = "window.copepod.views[0].stage.beads[1].geometry.attributes.position.array"
            ends = browser.value(f"[Math.min, Math.max].map((most) => most(...{heights}))")
            np.testing.assert_allclose(ends, [-8, 8], atol=1e-3)
        with self.subTest("draws the edges of the domain around all that the bodies sweep"):
            ends = browser.value(
                "[...window.copepod.views[0].stage.surroundings.line[0].geometry.attributes.position.array]"
            )
            ends = np.reshape(ends, (-1, 2, 3))
            self.assertEqual(len(np.unique(np.sort(ends, axis=1), axis=0)), 12)
            self.assertEqual(set(map(tuple, ends.reshape(-1, 3))), set(itertools.product((0, 40), (0, 40), (0, 80))))
            self.assertEqual(
                browser.value("window.copepod.views[0].stage.whole()"), {"low": [0] * 3, "high": [40, 40, 80]}
            )
            swept = browser.value("window.copepod.views[0].stage.extent")
            reach = max(np.hypot(4, 4), 8)  # of a capsule, whichever way it is turned
            np.testing.assert_allclose(swept["low"], [20 - reach, 20 - reach, 18], atol=1e-3)
            np.testing.assert_allclose(swept["high"], [20 + reach, 20 + reach, 63], atol=1e-3)
        self.assertEqual(browser.problems, [])
        self.assertEqual(browser.requests, [f"file://{self.path}"])

    def test_bodies_and_rods_have_images_behind_mirror_planes(self):
        beside = samples_of()
        beside.position_m[..., 0] -= 9e-6
        beside.position_m[:, 2, 1] += 5e-6  # no rod is along an axis
        scene = {**scene_of("images", with_surfaces(CASE), 1e-6, beside), "flow": None}
        path = self.path.with_name("images.html")
        path.write_text(page.page("A view", [view.figure(scene), view.scripts()]))
        browser = self.opened(path)
        browser.value("window.copepod.views[0].goTo(10.5); window.copepod.views[0].drawNow()")
        found = browser.value(IMAGES)
        self.assertEqual([entry["image"] for entry in found["bodies"]], [[], [0]] * 3)
        for entry in found["bodies"]:
            self.assertTrue(entry["isSeen"], entry)
            self.assertAlmostEqual(entry["place"][0], 29 if entry["image"] else 11, delta=1e-3)
        for rod in found["rods"]:
            np.testing.assert_allclose(rod["drawn"], rod["ends"], atol=1e-4)
        angle = np.pi * 10.5 / 100
        np.testing.assert_allclose(found["turned"], [np.cos(angle), np.sin(angle), 0, 0], atol=1e-4)

    def test_it_follows_the_theme_and_fits_a_narrow_window(self):
        browser = self.opened(width=390, height=800, dark=True)
        dark = browser.value(PICTURE)
        self.assertGreater(dark["red"], 50, dark)
        self.assertLessEqual(browser.value("document.documentElement.scrollWidth"), 390)
        light = [{"name": "prefers-color-scheme", "value": "light"}]
        browser.call("Emulation.setEmulatedMedia", features=light)
        browser.wait_for(f"{PICTURE}.sum !== {dark['sum']}")
        self.assertEqual(browser.problems, [])

    def test_without_webgl_the_page_refers_to_its_figures(self):
        with Browser(options=["--disable-3d-apis"]) as browser:
            browser.open(f"file://{self.path}")
            message = browser.wait_for("document.querySelector('.missing')?.textContent")
        self.assertIn("needs WebGL", message)


if __name__ == "__main__":
    unittest.main()
