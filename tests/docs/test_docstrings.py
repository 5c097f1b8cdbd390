"""Every public function says in its docstring what goes in and what comes out, in numpydoc's form."""

import importlib
import inspect
import sys
from pathlib import Path
from typing import NoReturn

import pytest
from numpydoc.docscrape import NumpyDocString

import roughcontact
from roughcontact.kernels import array_api, compiled

sys.path.insert(0, str(Path(__file__).parents[2] / "docs"))
import generated

# the modules of the documented interface; others say in a sentence what goes in and what comes out
MODULES = sorted(
    {f"roughcontact.{name}" for name in generated.MODULES}
    | {getattr(roughcontact, name).__module__ for name in roughcontact.__all__ if name != "__version__"}
)
IMPLEMENTED = {compiled.Compiled: array_api}


def public_functions(module):
    """Yield the public functions of a module, and the methods of its public classes with the class's name."""
    for name, member in vars(module).items():
        if name.startswith("_") or getattr(member, "__module__", None) != module.__name__:
            continue
        if inspect.isclass(member):
            yield from (
                (f"{name}.{method}", function, member)
                for method, function in vars(member).items()
                if inspect.isfunction(function) and not method.startswith("_")
            )
        elif inspect.isroutine(member) or hasattr(member, "__wrapped__"):
            yield name, member, None


def docstring_of(function, of_class):
    """Return its docstring, or that of the method which it overrides or implements."""
    overrides = [function]
    if of_class is not None:
        described = IMPLEMENTED.get(of_class, of_class)
        overrides.append(getattr(described, function.__name__))
        assert arguments(overrides[-1]) == arguments(function)
    return NumpyDocString(next(filter(None, map(inspect.getdoc, overrides))))


def arguments(function):
    return set(inspect.signature(function).parameters) - {"self", "cls"}


@pytest.mark.parametrize("name", MODULES)
def test_every_public_function_describes_its_arguments_and_what_it_gives(name):
    is_complete = name.removeprefix("roughcontact.") in generated.MODULES
    for function_name, function, of_class in public_functions(importlib.import_module(name)):
        if not is_complete and function_name not in roughcontact.__all__:
            continue
        docstring = docstring_of(function, of_class)
        described = {
            parameter_name.strip().lstrip("*")
            for entry in docstring["Parameters"]
            for parameter_name in entry.name.split(",")
        }
        missing = arguments(function) - described
        assert not missing, f"{function_name}: {missing} not described"
        gives = inspect.signature(function).return_annotation
        if gives not in (None, NoReturn, inspect.Signature.empty, "None", "NoReturn"):
            assert docstring["Returns"] or docstring["Yields"], (
                f"{function_name} does not say what it returns"
            )


def test_functions_and_methods_are_found():
    functions = {name for name, *_ in public_functions(compiled)} | {
        name for name, *_ in public_functions(array_api)
    }
    assert {"library", "Compiled.measure", "CompiledSmallGrids.restrict", "small_grids"} <= functions
