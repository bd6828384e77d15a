"""Docstrings of everything public: each exists, gives units of quantities and names raised errors."""

import ast
import inspect
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import narx

PACKAGE = Path(narx.__file__).parent
UNIT = re.compile(
    r"(?<![\w'])(s|ms|us|V|N m|ohm|H|Hz|rpm|mm|bit/s|rev/s|kg m2|°C|degrees( Celsius)?|periods?|units?|Kp|Ki|volts|fractions?|counts|within a second|numpy arrays?)(?!\w)"
    r"|in (its|their) units?"
)


def public() -> Iterator[tuple[str, Any]]:
    """Yields everything that `__all__` names and the public members of its classes, with full names."""
    for module in (narx, narx.blocks, narx.experiments):
        for name in module.__all__:
            thing = getattr(module, name)
            yield f"{module.__name__}.{name}", thing
            if inspect.isclass(thing):
                members = (member for member in vars(thing) if not member.startswith("_"))
                yield from ((f"{module.__name__}.{name}.{member}", vars(thing)[member]) for member in members)


NAMES = dict(public())


def signatures() -> dict[str, ast.FunctionDef]:
    """Returns the annotated functions of the package by full name without the module.

    Those of the compiled part are in its stub.
    """
    found: dict[str, ast.FunctionDef] = {}
    for file in [*sorted(PACKAGE.glob("*.py")), PACKAGE / "_core.pyi"]:
        for node in ast.parse(file.read_text(encoding="utf-8")).body:
            functions = node.body if isinstance(node, ast.ClassDef) else [node]
            prefix = f"{node.name}." if isinstance(node, ast.ClassDef) else ""
            for function in functions:
                if isinstance(function, ast.FunctionDef):
                    found.setdefault(prefix + function.name, function)
    return found


SIGNATURES = signatures()


def documentation(name: str, thing: Any) -> str:
    """Returns the docstring of a thing."""
    target = thing.fget if isinstance(thing, property) else getattr(thing, "__func__", thing)
    return inspect.getdoc(target) or ""


def signature(name: str, thing: Any) -> ast.FunctionDef | None:
    """Returns the signature of a function, or of a class's constructor."""
    local = name.removeprefix("narx.").removeprefix("blocks.").removeprefix("experiments.")
    if inspect.isclass(thing):
        return SIGNATURES.get(f"{local}.__init__") or SIGNATURES.get(f"{local}.__new__")
    return SIGNATURES.get(local)


def is_value(thing: Any) -> bool:
    """Returns whether a thing is a value, which has no docstring of its own at run time.

    Values are modules, members of enumerations and defaults of fields.
    """
    return not callable(getattr(thing, "__func__", thing)) and not isinstance(thing, property) and not inspect.isdatadescriptor(thing)


@pytest.mark.parametrize("name", [name for name, thing in NAMES.items() if not is_value(thing)])
def test_it_has_a_docstring(name: str) -> None:
    text = documentation(name, NAMES[name])
    inherited = inspect.isclass(NAMES[name]) and any(text == inspect.getdoc(base) for base in NAMES[name].__mro__[1:-1])
    assert text and not inherited, f"{name} has no docstring"
    assert text[0].isupper() or text[0] in "`\"", f"{name}: {text[:40]}"


def takes_floats(function: ast.FunctionDef) -> bool:
    arguments = [argument.annotation for argument in (*function.args.args, *function.args.kwonlyargs)]
    return any(annotation is not None and "float" in ast.unparse(annotation) for annotation in (*arguments, function.returns))


@pytest.mark.parametrize(
    "name", [name for name, thing in NAMES.items() if (found := signature(name, thing)) and takes_floats(found)]
)
def test_a_quantity_has_a_unit(name: str) -> None:
    text = documentation(name, NAMES[name])
    # The docstring of the class may give the unit for a member.
    owner = documentation(name, NAMES.get(name.rpartition(".")[0]))
    assert UNIT.search(text) or UNIT.search(owner), f"{name} takes or gives numbers, and says nothing of their unit: {text}"


@pytest.mark.parametrize("name", [name for name, thing in NAMES.items() if signature(name, thing)])
def test_errors_that_it_raises_are_named(name: str) -> None:
    function = signature(name, NAMES[name])
    assert function is not None
    raised = {
        ast.unparse(node.exc).partition("(")[0]
        for node in ast.walk(function)
        if isinstance(node, ast.Raise) and node.exc is not None
    }
    owner = documentation(name, NAMES.get(name.rpartition(".")[0]))
    named = set(re.findall(r"\w+", f"{documentation(name, NAMES[name])} {owner}"))
    unnamed = {error for error in raised if error in vars(narx)} - named
    assert not unnamed, f"{name} raises {', '.join(sorted(unnamed))} and does not say so"


def test_the_rules_can_be_broken() -> None:
    assert not UNIT.search("Asks for the drive's speed at once, as a master does.") and UNIT.search("For so long, s.")
    text = 'def read(self, wait: float) -> None:\n    raise NoAnswerError("no")'
    [function] = ast.parse(text).body
    assert isinstance(function, ast.FunctionDef) and takes_floats(function)
