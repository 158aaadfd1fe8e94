#!/usr/bin/env python3
"""Prints the page docs/reference/python.md, made from the docstrings of the package."""
import importlib
import inspect

import lcpbench


def block(text):
    return "```text\n" + inspect.cleandoc(text or "").strip() + "\n```\n"


def signature(item):
    try:
        return str(inspect.signature(item)).replace("'", "").replace("self, ", "").replace("(self)", "()")
    except (TypeError, ValueError):
        return ""


def members(cls):
    for name, item in vars(cls).items():
        inner = item.__func__ if isinstance(item, (classmethod, staticmethod)) else item
        if name.startswith("_") or not (inspect.isfunction(inner) or isinstance(inner, property)) or not inner.__doc__:
            continue
        shape = "" if isinstance(inner, property) else signature(inner).replace("cls, ", "")
        yield f"`{cls.__name__}.{name}{shape}`\n\n" + block(inner.__doc__)


def section(name, item):
    shape = signature(item) if not (inspect.isclass(item) and issubclass(item, Exception)) else ""
    yield f"## lcpbench.{name}\n\n" + (f"`lcpbench.{name}{shape}`\n\n" if callable(item) else "") + block(item.__doc__)
    if inspect.isclass(item):
        yield from members(item)


def page():
    yield ("# The Python package\n\nMade from the docstrings by `python/tools/reference.py`. How to install it and how "
           "to begin: [Python](../howto/python.md).\n")
    yield block(lcpbench.__doc__)
    for name in sorted(lcpbench.__all__, key=str.lower):
        yield from section(name, getattr(lcpbench, name))
    for name in ("mujoco", "pybullet", "drake", "pinocchio"):
        module = importlib.import_module("lcpbench." + name)
        yield from section(name, module)
        for each in module.__all__:
            yield from section(f"{name}.{each}", getattr(module, each))


print("\n".join(page()).rstrip())
