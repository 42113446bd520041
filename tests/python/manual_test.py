"""Everything has a docstring, and the stubs say what there is."""
import ast
import inspect
import pathlib
import unittest

import pvol


def public(thing):
    return {n for n in dir(thing) if not n.startswith("_")}


class Manual(unittest.TestCase):
    def test_everything_has_a_docstring(self):
        self.assertGreater(len(pvol.__doc__), 1000)
        for name in pvol.__all__:
            thing = getattr(pvol, name)
            if name == "__version__":
                continue
            self.assertTrue(inspect.getdoc(thing), name)
            if isinstance(thing, type) and thing is not pvol.Error:
                for member in public(thing):
                    self.assertTrue(inspect.getdoc(getattr(thing, member)), f"{name}.{member}")

    def test_stubs_are_complete(self):
        stub = ast.parse(pathlib.Path(pvol.__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
        found = {}
        for node in stub.body:
            if isinstance(node, (ast.ClassDef, ast.FunctionDef)):
                found[node.name] = node
        self.assertEqual(set(found) | {"__version__"}, set(pvol.__all__))
        for name, node in found.items():
            if not isinstance(node, ast.ClassDef) or name == "Error":
                continue
            members = {n.name for n in node.body if isinstance(n, ast.FunctionDef)} - {"__init__"}
            special = {n for n in members if n.startswith("__")}
            self.assertEqual(members - special, public(getattr(pvol, name)), name)
            self.assertLessEqual(special, set(dir(getattr(pvol, name))), name)


if __name__ == "__main__":
    unittest.main()
