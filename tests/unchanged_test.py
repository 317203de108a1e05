"""What tests/unchanged.py leaves out, and what it must not."""

import pathlib
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
import unchanged

REPORT = """<testsuite><testcase name="a" status="run"/><testcase name="b" status="fail"><failure message=""/></testcase>
<testcase name="c" status="notrun"><skipped message=""/></testcase><testcase name="sources" status="run"/></testsuite>"""
DAY = 24 * 3600


class Keys(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.tree = pathlib.Path(scratch.name)
        (self.tree / "bin").mkdir()
        for name in ("x_tests", "y_tests", "revisit", "x_bench"):
            self.write(name, name)
        self.tests = [self.listed("unit", "x_tests", ["unit"]), self.listed("walk", "y_tests", ["data", "programs"])]

    def write(self, name, text):
        (self.tree / "bin" / name).write_text(text)

    def listed(self, name, program, labels):
        return {"name": name, "command": [str(self.tree / "bin" / program), "--gtest_filter=" + name],
                "properties": [{"name": "LABELS", "value": labels}]}

    def changed_by(self, change):
        """The names whose keys are others afterwards."""
        before = unchanged.keys_of(self.tests, self.tree)
        change()
        after = unchanged.keys_of(self.tests, self.tree)
        return [name for name in after if after[name] != before[name]]

    def test_nothing_changes_by_itself(self):
        self.assertEqual(self.changed_by(lambda: self.write("x_bench", "other")), [])

    def test_a_program_changes_its_own_tests(self):
        self.assertEqual(self.changed_by(lambda: self.write("x_tests", "other")), ["unit"])

    def test_what_is_started_changes_those_that_may_start_it(self):
        self.assertEqual(self.changed_by(lambda: self.write("revisit", "other")), ["walk"])

    def test_a_library_changes_all(self):
        def change():
            (self.tree / "lib").mkdir()
            (self.tree / "lib" / "libfilm.so").write_text("other")
        self.assertEqual(self.changed_by(change), ["unit", "walk"])

    def test_properties_and_environment_count(self):
        def change():
            self.tests[0]["properties"].append({"name": "ENVIRONMENT", "value": ["A=1"]})
        self.assertEqual(self.changed_by(change), ["unit"])
        self.addCleanup(unchanged.os.environ.pop, "VK_DRIVER_FILES_OF_A_TEST", None)
        self.assertEqual(self.changed_by(lambda: unchanged.os.environ.update(VK_DRIVER_FILES_OF_A_TEST="1")),
                         ["unit", "walk"])

    def test_what_reads_the_sources_has_no_key(self):
        self.tests.append({"name": "arrows", "command": ["/usr/bin/cmake", "-P", "arrows.cmake"], "properties": []})
        self.assertIsNone(unchanged.keys_of(self.tests, self.tree)["arrows"])


class Passed(unittest.TestCase):
    KEYS = {"a": "1", "b": "2", "c": "3", "sources": None}

    def test_only_what_passed_is_left_out(self):
        passed = unchanged.after_run(self.KEYS, {}, REPORT, 5 * DAY)
        self.assertEqual(unchanged.must_run(self.KEYS, passed, 6 * DAY), ["b", "c", "sources"])

    def test_another_key_runs(self):
        passed = unchanged.after_run(self.KEYS, {}, REPORT, 0)
        self.assertEqual(unchanged.must_run({"a": "2"}, passed, 0), ["a"])

    def test_a_week_later_all_run(self):
        passed = unchanged.after_run(self.KEYS, {}, REPORT, 0)
        self.assertEqual(unchanged.must_run(self.KEYS, passed, 8 * DAY), list(self.KEYS))

    def test_what_fails_with_a_key_that_passed_is_not_known_any_more(self):
        before = {"b": {"key": "2", "when": 0}, "gone": {"key": "4", "when": 0}, "unasked": {"key": "5", "when": 0}}
        passed = unchanged.after_run({**self.KEYS, "unasked": "5"}, before, REPORT, 0)
        self.assertEqual(sorted(passed), ["a", "unasked"])


if __name__ == "__main__":
    unittest.main()
