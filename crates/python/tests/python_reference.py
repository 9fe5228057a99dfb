#!/usr/bin/env python3
"""Prints docs/python_reference.md: the public names of the package with their signatures and docstrings.

    crates/python/tests/python_reference.py > docs/python_reference.md

It reads the source, so that neither the package nor its libraries need to be installed; test_documents.py compares the page.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1] / "python/column_twin"

HEAD = """# Python reference

This page is generated from the docstrings of `crates/python/python/column_twin`; do not edit it.
[python.md](python.md) shows how the parts belong together.
All quantities are in SI units.
"""

# The types in signatures that have no heading of their own.
TYPES = ("Model", "Value", "Setting", "AxisNumbers", "AxisNames", "AxisValues")

TYPES_HEAD = """
## Types in signatures

`**overrides: Unpack[ParameterKeywords]` are keywords for all [parameters](parameters.md), and `**ranges: Unpack[AxisKeywords]` for the
parameters that are numbers, and for mass, velocity, height, direction and section; two underscores are a dot.

| name | definition | meaning |
|---|---|---|
"""

Definition = ast.ClassDef | ast.FunctionDef


def text_of(node: ast.stmt | None) -> str | None:
    """The docstring that follows a field or a constant."""
    is_text = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
    return " ".join(node.value.value.split()) if is_text else None


def values(body: list[ast.stmt]) -> Iterator[tuple[str, str, str]]:
    """The documented fields or constants: name, type, meaning."""
    for node, after in zip(body, [*body[1:], None]):
        meaning = text_of(after)
        if meaning is None:
            continue
        if isinstance(node, ast.AnnAssign):
            yield ast.unparse(node.target), ast.unparse(node.annotation), meaning
        elif isinstance(node, ast.Assign):
            yield ast.unparse(node.targets[0]), "", meaning


def documented(node: Definition) -> str:
    return f"```text\n{ast.get_docstring(node) or ''}\n```\n"


def function(node: ast.FunctionDef, owner: str) -> str:
    decorators = [ast.unparse(it) for it in node.decorator_list]
    returns = f" -> {ast.unparse(node.returns)}" if node.returns else ""
    if "property" in decorators:
        signature = f"{owner}{node.name}{returns}"
    else:
        arguments = ast.unparse(node.args).removeprefix("self, ").removeprefix("cls, ")
        arguments = "" if arguments in ("self", "cls") else arguments
        signature = f"{owner}{node.name}({arguments}){returns}"
    return f"`{signature}`\n\n{documented(node)}"


def definition(node: Definition) -> str:
    if isinstance(node, ast.FunctionDef):
        return function(node, "")
    text = documented(node)
    fields = [it for it in values(node.body) if not it[0].startswith("_")]
    if fields:
        text += "\n| field | type | meaning |\n|---|---|---|\n"
        cells = [[cell.replace("|", "\\|") for cell in field] for field in fields]
        text += "".join(f"| `{name}` | {kind and f'`{kind}`'} | {meaning} |\n" for name, kind, meaning in cells)
    for part in node.body:
        if isinstance(part, ast.FunctionDef) and not part.name.startswith("_") and ast.get_docstring(part):
            text += "\n" + function(part, f"{node.name}.")
    return text


def types(body: list[ast.stmt]) -> Iterator[str]:
    """The rows of the types in signatures."""
    for node, after in zip(body, body[1:]):
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) in TYPES:
            yield f"| `{ast.unparse(node.targets[0])}` | `{ast.unparse(node.value)}` | {text_of(after)} |\n"


def page() -> str:
    modules = [ast.parse(path.read_text()) for path in sorted(PACKAGE.glob("*.py"))]
    package = ast.parse((PACKAGE / "__init__.py").read_text())
    named = next(it for it in package.body if isinstance(it, ast.Assign) and ast.unparse(it.targets[0]) == "__all__")
    text = HEAD
    for name in ast.literal_eval(named.value):
        nodes = [it for module in modules for it in module.body]
        found = next((it for it in nodes if isinstance(it, Definition) and it.name == name), None)
        constant = next((it for module in modules for it in values(module.body) if it[0] == name), None)
        if found:
            text += f"\n## {name}\n\n{definition(found)}"
        elif constant:
            text += f"\n## {name.replace('_', chr(92) + '_')}\n\n{constant[2]}\n"
    return text + TYPES_HEAD + "".join(row for module in modules for row in types(module.body))


if __name__ == "__main__":
    print(page(), end="")
