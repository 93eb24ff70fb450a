"""The notebooks in `examples/` say what they print."""

import os
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def printed(cell) -> str:
    """What a cell prints, pictures left out."""
    texts = []
    for output in cell.get("outputs", []):
        texts.append(output.get("text") or output.get("data", {}).get("text/plain", ""))
    return "".join("".join(text) for text in texts)


@pytest.mark.parametrize("folder", [ROOT, ROOT / "examples"], ids=["root", "examples"])
@pytest.mark.parametrize("notebook", sorted((ROOT / "examples").glob("*.ipynb")), ids=lambda path: path.name)
def test_notebooks_print_what_stands_in_them(notebook: Path, folder: Path, program: Path):
    """Run in the root, and in their own folder, as Jupyter does."""
    nbformat = pytest.importorskip("nbformat", reason="nbformat is not installed")
    nbclient = pytest.importorskip("nbclient", reason="nbclient is not installed")
    stored = nbformat.read(notebook, as_version=4)
    run = nbformat.read(notebook, as_version=4)
    nbclient.NotebookClient(run, timeout=120, resources={"metadata": {"path": folder}}).execute()
    if os.environ.get("RAYREEL_BLESS"):
        for cell in run.cells:
            cell.metadata = {}
        run.metadata = {"kernelspec": stored.metadata["kernelspec"]}
        nbformat.write(run, notebook)
        return
    code = [(i, a, b) for i, (a, b) in enumerate(zip(stored.cells, run.cells)) if a.cell_type == "code"]
    assert code
    for i, a, b in code:
        assert printed(a) == printed(b), f"cell {i}; RAYREEL_BLESS=1 writes what it prints now"
