"""`copepod export`: an RO-Crate whose description fits its files, and whose case gives the digest again."""

import json
import subprocess
import unittest

from copepod_session import PROGRAMS, ROOT, CommandTest

CASE = ROOT / "configs/quick/vacuum.yaml"
WHO = ("--author", "Ada Lovelace", "--license", "CC-BY-4.0")


class Export(CommandTest):
    programs = PROGRAMS

    def setUp(self):
        super().setUp()
        self.assert_ends(self.start("run", CASE, "--set", "run.steps=800", "--out", "run"), 0, timeout_s=60)
        (self.folder / "run/checkpoints").mkdir(exist_ok=True)
        (self.folder / "run/checkpoints/large").write_text("not for an archive")

    def refused(self, *arguments):
        session = self.start("export", *arguments)
        self.assert_ends(session, 2, timeout_s=30)
        return "".join(session.stderr)

    def test_description_fits_the_files(self):
        self.assert_ends(self.start("export", "run", *WHO), 0, timeout_s=30)
        crate = self.folder / "run.crate"
        description = json.loads((crate / "ro-crate-metadata.json").read_text())
        self.assertEqual(description["@context"][0], "https://w3id.org/ro/crate/1.1/context")
        entities = {entity["@id"]: entity for entity in description["@graph"]}
        self.assertEqual(len(entities), len(description["@graph"]))
        root = entities[entities["ro-crate-metadata.json"]["about"]["@id"]]
        self.assertLessEqual({"name", "description", "datePublished", "license"}, root.keys())
        for entity in entities.values():  # what is referred to is there
            for value in entity.values():
                for each in value if isinstance(value, list) else [value]:
                    if isinstance(each, dict) and not each["@id"].startswith("http"):
                        self.assertIn(each["@id"], entities)
        for entity in entities.values():
            if entity["@type"] == "File":
                self.assertEqual(int(entity["contentSize"]), (crate / entity["@id"]).stat().st_size)
        listed = {part["@id"].rstrip("/") for part in root["hasPart"]}
        self.assertEqual(listed | {"ro-crate-metadata.json", "sha256sums.txt"}, {path.name for path in crate.iterdir()})
        subprocess.run(["sha256sum", "--check", "--quiet", "sha256sums.txt"], cwd=crate, check=True)
        summary = json.loads((self.folder / "run/summary.json").read_text())
        self.assertEqual(entities["#digest"]["value"], summary["digest"])
        self.assertEqual(entities["#trajectory.vx_m_per_s"]["unitText"], "m/s")
        self.assertEqual(entities["#author"]["name"], "Ada Lovelace")
        run = entities["#run"]
        self.assertEqual((run["agent"], run["object"]), ({"@id": "#author"}, {"@id": "case.yaml"}))
        self.assertEqual(len(run["result"]), len(root["hasPart"]) - 1)  # all but the case
        self.assertEqual(entities[root["license"]["@id"]]["name"], "CC-BY-4.0")

    def test_exported_case_gives_the_digest_again(self):
        self.assert_ends(self.start("export", "run", *WHO, "--out", "archive/one"), 0, timeout_s=30)
        self.assert_ends(self.start("run", "archive/one/case.yaml", "--out", "again"), 0, timeout_s=60)
        one, other = (
            json.loads((self.folder / name / "summary.json").read_text())["digest"] for name in ("run", "again")
        )
        self.assertEqual(one, other)

    def test_refusals(self):
        (self.folder / "run.crate").mkdir()
        (self.folder / "empty").mkdir()
        self.assertIn("never replaces", self.refused("run", *WHO))
        self.assertIn("not a run", self.refused("empty", *WHO))
        provenance = self.folder / "run/provenance.json"
        provenance.write_text(provenance.read_text().replace('"status": "finished"', '"status": "failed"'))
        self.assertIn("has not finished", self.refused("run", *WHO, "--out", "elsewhere"))
        self.assertEqual([path.name for path in self.folder.glob("elsewhere*")], [])
        self.assertIn("--author", self.refused("run"))


if __name__ == "__main__":
    unittest.main()
