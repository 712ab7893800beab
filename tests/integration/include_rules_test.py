"""The include rules: the sources keep them, and .ci/check_includes sees every kind of violation."""

import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent


def check(root):
    answer = subprocess.run([ROOT / ".ci/check_includes", root], stdout=subprocess.PIPE, text=True)
    return answer.returncode, answer.stdout


class IncludeRules(unittest.TestCase):

    def test_sources_keep_the_rules(self):
        code, text = check(ROOT)
        self.assertEqual(code, 0, text)

    def verdict_on(self, path, line):
        """Answer on a small tree in which the file `path` holds the one include `line`."""
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder)
            for header in ("proto/contract/a.hpp", "proto/session/s.hpp", "proto/transport/t.hpp", "coupler/run/r.hpp",
                           "fluid_service/lattice/l.hpp", "body_service/model/m.hpp"):
                (root / header).parent.mkdir(parents=True, exist_ok=True)
                (root / header).write_text("#pragma once\n")
            (root / path).parent.mkdir(parents=True, exist_ok=True)
            (root / path).write_text(f"// first line\n{line}\n")
            return check(root)

    def assert_forbidden(self, path, line):
        code, text = self.verdict_on(path, line)
        self.assertEqual(code, 1, text)
        self.assertIn(f"{path}:2: error:", text)

    def assert_allowed(self, path, line):
        code, text = self.verdict_on(path, line)
        self.assertEqual(code, 0, text)

    def test_components_know_proto_and_themselves(self):
        self.assert_allowed("coupler/run/x.cpp", '#include "contract/a.hpp"')
        self.assert_allowed("fluid_service/kernel/x.cpp", '#include "lattice/l.hpp"')
        self.assert_allowed("body_service/x.cpp", "#include <vector>")

    def test_components_do_not_know_each_other(self):
        self.assert_forbidden("coupler/run/x.cpp", '#include "lattice/l.hpp"')
        self.assert_forbidden("fluid_service/x.cpp", '#include "model/m.hpp"')
        self.assert_forbidden("body_service/x.cpp", '#  include "run/r.hpp"')

    def test_proto_knows_nothing_of_ours(self):
        self.assert_forbidden("proto/component/x.cpp", '#include "run/r.hpp"')

    def test_contract_and_state_machines_are_free_of_technology(self):
        self.assert_forbidden("proto/contract/x.hpp", '#include "session/s.hpp"')
        self.assert_forbidden("proto/session/x.cpp", '#include "transport/t.hpp"')
        self.assert_allowed("proto/session/x.cpp", '#include "contract/a.hpp"')

    def test_third_party_headers_stay_in_their_folders(self):
        for header, home, elsewhere in (("mpi.h", "fluid_service/communication", "fluid_service/kernel"),
                                        ("zmq.hpp", "proto/transport", "proto/session"),
                                        ("yaml-cpp/yaml.h", "coupler/config", "coupler/run"),
                                        ("google/protobuf/arena.h", "proto/conversion", "coupler/run")):
            self.assert_allowed(f"{home}/x.cpp", f"#include <{header}>")
            self.assert_forbidden(f"{elsewhere}/x.cpp", f"#include <{header}>")
        self.assert_allowed("proto/conversion/x.cpp", '#include "copepod/v1/envelope.pb.h"')
        self.assert_forbidden("coupler/run/x.cpp", '#include "copepod/v1/envelope.pb.h"')

    def test_header_that_does_not_exist_is_reported(self):
        self.assert_forbidden("coupler/run/x.cpp", '#include "nowhere/n.hpp"')


if __name__ == "__main__":
    unittest.main()
