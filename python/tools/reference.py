#!/usr/bin/env python3
"""Prints the page docs/reference/python.md, made from the docstrings of the package."""
import dataclasses
import importlib
import inspect
import re

import lcpbench


def block(text):
    return "```text\n" + inspect.cleandoc(text or "").strip() + "\n```\n"


class Annotation(str):
    __repr__ = str.__str__  # without quotes


def signature(item):
    try:
        shape = inspect.signature(item)
    except (TypeError, ValueError):
        return ""
    bare = [each if each.annotation is each.empty else each.replace(annotation=Annotation(each.annotation))
            for each in shape.parameters.values() if each.name not in ("self", "cls")]
    result = shape.return_annotation
    return str(shape.replace(parameters=bare,
                             return_annotation=result if result is shape.empty else Annotation(result)))


def members(cls):
    if dataclasses.is_dataclass(cls):
        yield block("\n".join(map(": ".join, re.findall(r"^    (\w+): .*?  #: (.*)$", inspect.getsource(cls), re.M))))
    for name, item in vars(cls).items():
        inner = item.__func__ if isinstance(item, (classmethod, staticmethod)) else item
        if name.startswith("_") or not (inspect.isfunction(inner) or isinstance(inner, property)) or not inner.__doc__:
            continue
        shape = "" if isinstance(inner, property) else signature(inner)
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
