#!/usr/bin/env python3
"""Prints the page docs/reference/python.md, made from the docstrings of the package."""
import dataclasses
import inspect
import re

import lcpbench
import lcpbench.fclib
import lcpbench.mujoco


def block(text):
    """Without what is raised: the page says at its beginning which errors there are."""
    said = inspect.cleandoc(text or "").strip()
    return "```text\n" + re.sub(r"\n\nRaises:\n(?:    .*\n?)+", "", said).strip() + "\n```\n"


def signature(item):
    """Without types: the text says them."""
    try:
        shape = inspect.signature(item)
    except (TypeError, ValueError):
        return ""
    bare = [each.replace(annotation=each.empty)
            for each in shape.parameters.values() if each.name not in ("self", "cls")]
    return str(shape.replace(parameters=bare, return_annotation=shape.empty))


def members(cls):
    if dataclasses.is_dataclass(cls):
        yield block("\n".join(map(": ".join, re.findall(r"^    (\w+): .*?  #: (.*)$", inspect.getsource(cls), re.M))))
    for name, item in vars(cls).items():
        inner = item.__func__ if isinstance(item, (classmethod, staticmethod)) else item
        if name.startswith("_") or not (inspect.isfunction(inner) or isinstance(inner, property)) or not inner.__doc__:
            continue
        shape = "" if isinstance(inner, property) else signature(inner)
        said = inner.__doc__.strip()
        yield f"`{cls.__name__}.{name}{shape}`" + (": " + said + "\n" if "\n" not in said else "\n\n" + block(said))


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
    for name in ("fclib", "mujoco"):
        yield from section(name, module := getattr(lcpbench, name))
        for each in module.__all__:
            yield from section(f"{name}.{each}", getattr(module, each))
    yield "`help(lcpbench.pybullet)`, `help(lcpbench.drake)` and `help(lcpbench.pinocchio)` say the same of other engines."


print("\n".join(page()).rstrip())
