#!/usr/bin/python3
"""The project keeps its include and name rules, and the checks of both see every kind of violation.

The rules are those of the design, section 2, and the style's list of words; .ci/check_includes and .ci/check_names
hold them. Here each check runs over the project, and over small trees with one planted violation each.
"""

import subprocess
import tempfile
import unittest
from pathlib import Path

import structure

ROOT = Path(__file__).resolve().parents[2]


def run_check(name, root):
    """Exit code and output of one check over the tree `root`."""
    result = subprocess.run([ROOT / ".ci" / name, root], capture_output=True, text=True, check=False)
    return result.returncode, result.stdout + result.stderr


class PlantedTree(unittest.TestCase):
    """A small project that keeps every rule, and room to break one."""

    SOUND = {
        "proto/contract/loads.hpp": "#include <vector>\n",
        "proto/session/table.hpp": '#include "contract/loads.hpp"\n',
        "proto/transport/lane.cpp": '#include <zmq.hpp>\n#include "contract/loads.hpp"\n',
        "proto/conversion/encode.cpp": '#include "copepod/v1/copepod.pb.h"\n',
        "fluid_service/ranks/communicator.hpp": "#include <mpi.h>\n",
        "fluid_service/files/write.cpp": '#include <hdf5.h>\n#include "ranks/communicator.hpp"\n',
        "body_service/main.cpp": '#include "contract/loads.hpp"\n#include "model/state.hpp"\n',
        "body_service/model/state.hpp": "#include <Eigen/Core>\n",
        "coupler/config/read.cpp": "#include <yaml-cpp/yaml.h>\n",
        "coupler/main.cpp": '#include "session/table.hpp"\n#include "config/case.hpp"\n',
        "coupler/config/case.hpp": "",
    }

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)
        for path, text in self.SOUND.items():
            self.plant(path, text)

    def plant(self, path, text):
        """Adds a line or a file to the tree."""
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        with file.open("a", encoding="utf-8") as stream:
            stream.write(text)

    def expect_refusal(self, check, path, line, message):
        """The check refuses the tree once `line` stands in `path`, and prints where."""
        self.plant(path, line)
        code, output = run_check(check, self.root)
        self.assertEqual(code, 1, output)
        self.assertIn(path, output)
        self.assertIn(message, output)
        self.assertEqual(output.count(": error: "), 1, output)


class IncludeRules(PlantedTree):
    def test_the_project_keeps_them(self):
        code, output = run_check("check_includes", ROOT)
        self.assertEqual(code, 0, output)

    def test_a_sound_tree_passes(self):
        code, output = run_check("check_includes", self.root)
        self.assertEqual(code, 0, output)
        self.assertIn(f"{len(self.SOUND)} files", output)

    def test_folders_that_include_each_other_are_refused(self):
        self.plant("body_service/forces/spring.hpp", '#include "model/state.hpp"\n')
        self.plant("body_service/contact/pairs.hpp", '#include "forces/spring.hpp"\n')
        line = '#include "contact/pairs.hpp"\n'
        self.expect_refusal("check_includes", "body_service/model/state.hpp", line, "include each other in a circle")

    def test_components_must_not_know_each_other(self):
        for path, header in (
            ("proto/contract/wrong.hpp", "model/state.hpp"),
            ("proto/component/wrong.cpp", "config/case.hpp"),
            ("proto/component/wrong.cpp", "ranks/communicator.hpp"),
            ("fluid_service/lattice_boltzmann/kernel/wrong.cpp", "model/state.hpp"),
            ("fluid_service/lattice_boltzmann/kernel/wrong.cpp", "config/case.hpp"),
            ("body_service/model/wrong.cpp", "ranks/communicator.hpp"),
            ("body_service/model/wrong.cpp", "config/case.hpp"),
            ("coupler/run/wrong.cpp", "model/state.hpp"),
            ("coupler/run/wrong.cpp", "ranks/communicator.hpp"),
        ):
            with self.subTest(f"{path} includes {header}"):
                self.expect_refusal("check_includes", path, f'#include "{header}"\n', f'"{header}"')
                (self.root / path).unlink()

    def test_paths_around_the_rule_are_seen(self):
        self.expect_refusal(
            "check_includes",
            "body_service/model/wrong.cpp",
            '  #  include "../../coupler/config/case.hpp"\n',
            "coupler/config/case.hpp",
        )

    def test_angle_brackets_do_not_hide_a_header_of_ours(self):
        self.expect_refusal(
            "check_includes", "body_service/model/wrong.cpp", "#include <config/case.hpp>\n", "config/case.hpp"
        )

    def test_third_party_headers_stay_with_their_wrapper(self):
        for path, header in (
            ("fluid_service/lattice_boltzmann/kernel/wrong.cpp", "mpi.h"),
            ("coupler/run/wrong.cpp", "mpi.h"),
            ("proto/component/wrong.cpp", "zmq.hpp"),
            ("coupler/run/wrong.cpp", "zmq.h"),
            ("coupler/run/wrong.cpp", "yaml-cpp/yaml.h"),
            ("body_service/model/wrong.cpp", "yaml-cpp/yaml.h"),
            ("proto/component/wrong.cpp", "copepod/v1/copepod.pb.h"),
            ("coupler/run/wrong.cpp", "google/protobuf/arena.h"),
            ("fluid_service/lattice_boltzmann/kernel/wrong.cpp", "hdf5.h"),
            ("coupler/run/wrong.cpp", "H5Cpp.h"),
            ("body_service/model/wrong.cpp", "hdf5_hl.h"),
            ("body_service/model/wrong.cpp", "btBulletDynamicsCommon.h"),
            ("coupler/run/wrong.cpp", "LinearMath/btVector3.h"),
            ("body_service/engine/wrong.cpp", "mujoco/mujoco.h"),
            ("body_service/model/wrong.cpp", "immintrin.h"),
            ("proto/geometry/wrong.hpp", "arm_neon.h"),
        ):
            with self.subTest(f"{path} includes {header}"):
                self.expect_refusal("check_includes", path, f"#include <{header}>\n", f"<{header}> outside")
                (self.root / path).unlink()

    def test_quotes_do_not_hide_a_third_party_header(self):
        self.expect_refusal("check_includes", "coupler/run/wrong.cpp", '#include "mpi.h"\n', "<mpi.h> outside")

    def test_contract_and_state_machines_know_no_technology(self):
        self.plant("proto/transport/lane.hpp", "")
        self.expect_refusal(
            "check_includes", "proto/session/wrong.hpp", '#include "transport/lane.hpp"\n', "in proto/session"
        )


class ImportCycles(PlantedTree):
    """Python packages and modules; the folders of C++ are checked with the include rules."""

    def cycles(self, root, depth=None):
        return structure.cycles(structure.grouped(structure.import_edges(structure.sources(root)), depth))

    def test_trips_are_those_of_this_tree(self):
        self.assertEqual([trip for trip, number in structure.trips_of(ROOT) if number == "?"], [])

    def test_the_project_has_none(self):
        self.assertGreater(len(structure.import_edges(structure.sources(ROOT))), 100)
        self.assertEqual(self.cycles(ROOT, depth=1), [])
        self.assertEqual(self.cycles(ROOT), [])

    def test_modules_that_import_each_other_are_found(self):
        self.plant("deploy/copepod_a/__init__.py", "")
        self.plant("deploy/copepod_a/one.py", "from copepod_a import two\n")
        self.plant("deploy/copepod_a/two.py", "def late():\n    from .one import x\n")
        self.assertEqual(self.cycles(self.root), [["copepod_a.one", "copepod_a.two"]])

    def test_packages_that_import_each_other_are_found(self):
        self.plant("deploy/copepod_a/one.py", "import copepod_b.three\n")
        self.plant("deploy/copepod_a/two.py", "")
        self.plant("proto/python/copepod_b/three.py", "")
        self.plant("proto/python/copepod_b/four.py", "from copepod_a.two import x\n")
        self.assertEqual(self.cycles(self.root), [])
        self.assertEqual(self.cycles(self.root, depth=1), [["copepod_a", "copepod_b"]])


class NameRules(PlantedTree):
    def test_the_project_keeps_them(self):
        code, output = run_check("check_names", ROOT)
        self.assertEqual(code, 0, output)

    def test_a_sound_tree_passes(self):
        code, output = run_check("check_names", self.root)
        self.assertEqual(code, 0, output)

    def test_empty_words_are_refused_in_every_spelling(self):
        for path in (
            "coupler/run/run_manager.cpp",
            "proto/utils/text.hpp",
            "deploy/copepod_helper.py",
            "tests/common.hpp",
            "fluid_service/CellData.hpp",
            "body_service/tick-count.cpp",
            "coupler/scheme/slave.cpp",
        ):
            with self.subTest(path):
                self.expect_refusal("check_names", path, "", "in its name")
                (self.root / path).unlink()

    def test_words_that_only_contain_them_are_fine(self):
        self.plant("fluid_service/metadata.cpp", "")
        self.plant("coupler/sticky.hpp", "")
        code, output = run_check("check_names", self.root)
        self.assertEqual(code, 0, output)


if __name__ == "__main__":
    unittest.main()
