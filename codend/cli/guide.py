"""The command ``codend guide``: the manual, in the terminal or as a site."""

import sys
from importlib import resources
from pathlib import Path

import click

from codend.errors import OPTIONS, InputError

PAGES = {
    "index": "what there is",
    "first-study": "a first study in five minutes",
    "tasks": "twenty tasks, and the page that answers each",
    "plans": "plans in words",
    "plan-keys": "every key of a plan",
    "running": "runs, tables and folders",
    "columns": "every column of every table",
    "commands": "every command and option",
    "model": "the model, its equations and their sources",
    "choosing-a-model": "which model and method, and what they cost",
    "trust": "what to trust",
    "stability": "what a net may do that is not the same all round",
    "selectivity": "from meshes to L50, and curves from hauls",
    "studies": "many designs: sweeps, sensitivities, search",
    "scenes": "trawls, cables and cages",
    "python": "the same from Python",
    "species-keys": "every key of a species file",
    "scene-keys": "every key of a scene",
    "coming-from": "for users of AxiCodend, selfisher and trawlkit",
    "glossary": "the trade's words and ours",
}
"""Pages of the manual in the order they are read in, and what each is."""


@click.command()
@click.argument("page", metavar="[PAGE]", default="index", type=click.Choice(list(PAGES)))
@click.option("--site", metavar="DIR", type=click.Path(path_type=Path), help="Build the manual as a site into DIR.")
def guide(page: str, site: Path | None) -> None:
    """Read the manual: one PAGE of it, or the whole as a site."""
    folder = resources.files("codend.guide")
    if site is None:
        text = (folder / f"{page}.md").read_text(encoding="utf-8")
        if not sys.stdout.isatty():
            click.echo(text, nl=False)
            return
        from rich.console import Console
        from rich.markdown import Markdown

        console = Console()
        with console.pager(styles=True):
            console.print(Markdown(text))
        return
    with resources.as_file(folder) as pages:
        _build(pages, site)
    click.echo(f"written: {site / 'index.html'}")


def _build(pages: Path, site: Path) -> None:
    """Build the site with MkDocs; a link that leads nowhere ends it.

    Raises:
        InputError: MkDocs is not installed, or a link leads nowhere.
    """
    try:
        from mkdocs.commands.build import build
        from mkdocs.config import load_config
        from mkdocs.exceptions import Abort
    except ModuleNotFoundError:
        allowed = "pip install 'codend[guide]', which brings MkDocs"
        raise InputError(OPTIONS, "--site", str(site), allowed, "needs MkDocs") from None
    from tempfile import NamedTemporaryFile

    with NamedTemporaryFile("w", suffix=".yml", encoding="utf-8") as settings:
        settings.write("site_name: codend\n")
        settings.flush()
        config = load_config(
            settings.name,
            docs_dir=str(pages),
            site_dir=str(site.resolve()),
            nav=[{words.capitalize(): f"{name}.md"} for name, words in PAGES.items()],
            theme={"name": "readthedocs", "highlightjs": False},
            use_directory_urls=False,
            plugins=[],
            strict=True,
            exclude_docs="*.py\n*.toml\n__pycache__/",
        )
    try:
        build(config)
    except Abort as error:
        raise InputError(OPTIONS, "--site", str(site), "pages whose links lead somewhere", str(error)) from None
