"""Every example runs, and the numbers it asserts hold."""

from pkgutil import iter_modules
from runpy import run_module

import pytest

from validation import examples


@pytest.mark.parametrize("name", [module.name for module in iter_modules(examples.__path__)])
def test_the_numbers_that_an_example_asserts_hold(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run_module(f"validation.examples.{name}")
