# SPDX-License-Identifier: MIT
"""The stubs say what there is, and what there is says what it is."""

import ast
import importlib
import re
from pathlib import Path

import pytest

import handyar

FOLDER = Path(handyar.__file__).parent
MODULES = ["_core", "_io", "calibration", "draw"]


def stubbed(module):
    """Qualified name of everything in a stub, with a function's parameters, or None."""
    found = {}

    def walk(body, prefix):
        for node in body:
            if isinstance(node, ast.ClassDef):
                found[prefix + node.name] = None
                walk(node.body, prefix + node.name + ".")
            elif isinstance(node, ast.FunctionDef):
                is_property = any(getattr(d, "id", "") == "property" for d in node.decorator_list)
                arguments = [a.arg for a in node.args.args + node.args.kwonlyargs if a.arg != "self"]
                found[prefix + node.name] = None if is_property else arguments

    walk(ast.parse((FOLDER / f"{module}.pyi").read_text()).body, "")
    return found


def public(module):
    """The same names as they are."""
    found = {}
    for name, value in vars(importlib.import_module("handyar." + module)).items():
        if name.startswith("_") or name in ("ATTACHMENTS", "FINGERS"):
            continue
        found[name] = value
        if isinstance(value, type) and not issubclass(value, Exception):
            for member in vars(value):
                if not member.startswith("_") or member in ("__iter__", "__next__", "__enter__"):
                    found[f"{name}.{member}"] = getattr(value, member)
    return found


@pytest.mark.parametrize("module", MODULES)
def test_stubs_and_modules_have_the_same_names(module):
    stubs = {name for name in stubbed(module) if not name.endswith(("__init__", "__exit__"))}
    assert stubs == set(public(module))


@pytest.mark.parametrize("module", MODULES)
def test_stubs_have_the_parameters(module):
    everything = public(module)
    for name, parameters in stubbed(module).items():
        if parameters is None or name not in everything:
            continue
        signature = everything[name].__doc__.splitlines()[0] if everything[name].__doc__ else ""
        if not (match := re.match(r"\w+\((.*)\) ->", signature)):
            continue
        named = re.findall(r"(?:^|, )(\w+): ", match.group(1))
        assert [n for n in named if n not in ("self", "arg0")] == parameters, name


@pytest.mark.parametrize("module", MODULES)
def test_everything_is_documented(module):
    for name, value in public(module).items():
        if name.split(".")[-1].startswith("__"):
            continue
        text = value.__doc__ or ""
        lines = text.splitlines()
        if lines and re.match(r"\w+\(.*\) ->", lines[0]):  # pybind11's signature
            lines = lines[1:]
        assert "".join(lines).strip(), f"{name} is not documented"


def test_the_examples_and_the_package_are_typed(tmp_path):
    api = pytest.importorskip("mypy.api")
    examples = sorted((Path(__file__).parent.parent / "examples").glob("*.py"))
    assert examples
    text, faults, code = api.run(
        ["--strict", "--cache-dir", str(tmp_path), "--ignore-missing-imports",
         "--follow-imports=silent", *map(str, examples), *map(str, FOLDER.glob("*.py"))]
    )
    assert code == 0, text + faults
