"""The documentation before it is built: what it names exists, what it runs compiles, and no public name is left out."""

from __future__ import annotations

import ast
import csv
import importlib
import inspect
import json
import pydoc
import re
import shlex
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from cyclopts import CycloptsError, MissingArgumentError

import springpot as sp
from springpot import cli, figures
from springpot.evidence.reliability import PAPER_MAP, SYSTEMS_MAP
from springpot.problem import parts
from springpot.studies.question import read_study

DOCS = Path(__file__).resolve().parents[1] / "docs"
FOLDERS = ("*.md", "api/*.rst", "how_to/*.md", "theory/*.md")
PAGES = sorted(page for pattern in FOLDERS for page in DOCS.glob(pattern) if page.is_file())
EXAMPLES = sorted((DOCS / "gallery").glob("*.py"))
PUBLIC = (
    "springpot", "springpot.problem.spectral_density", "springpot.simulation", "springpot.theory",
    "springpot.theory.fourier", "springpot.evidence.comparison", "springpot.designing", "springpot.fitting",
    "springpot.figures", "springpot.memory", "springpot.paper", "springpot.studies",
)  # fmt: skip


WHOLE_FIGURES = {
    f"sp.figures.{name}" for name in figures.__all__
    if inspect.isfunction(function := getattr(figures, name)) and function.__annotations__["return"] == "Figure"
}  # fmt: skip


def name_of(page: Path) -> str:
    return page.relative_to(DOCS).as_posix()


def cells(page: Path) -> list[str]:
    """Blocks of Python that run when the page is built."""
    found = re.findall(r"^```\{code-cell\} python\n(.*?)^```$", page.read_text(encoding="utf-8"), flags=re.M | re.S)
    return [re.sub(r"^:tags:.*\n", "", cell) for cell in found]


def there(target: str, page: Path) -> bool:
    """Whether a page or a file is there."""
    path = (page.parent / target).resolve()
    return any(path.with_name(path.name + ending).is_file() for ending in ("", ".md", ".rst"))


def contents(page: Path) -> list[str]:
    """What a page lists in its tables of contents."""
    blocks = re.findall(r"^```\{toctree\}\n(.*?)^```$", page.read_text(encoding="utf-8"), flags=re.M | re.S)
    lines = [line for block in blocks for line in block.splitlines() if line and not line.startswith(":")]
    return [re.sub(r"^.*<(.*)>$", r"\1", line) for line in lines]


def test_the_configuration_parses() -> None:
    tree = ast.parse((DOCS / "conf.py").read_text(encoding="utf-8"))
    named = {target.id for node in ast.walk(tree) if isinstance(node, ast.Assign) for target in node.targets
             if isinstance(target, ast.Name)}  # fmt: skip
    assert {"extensions", "nitpicky", "nb_execution_raise_on_error", "html_theme"} <= named


@pytest.mark.parametrize("page", [page for page in PAGES if contents(page)], ids=name_of)
def test_every_page_in_a_table_of_contents_exists(page: Path) -> None:
    for entry in contents(page):
        assert there(entry, page) or entry == "auto_gallery/index", entry  # made of the examples


def test_every_page_is_in_a_table_of_contents() -> None:
    listed = {(page.parent / entry).resolve() for page in PAGES for entry in contents(page)}
    assert {page.with_suffix("") for page in PAGES} - {DOCS / "index"} <= listed


def without_code(page: Path) -> str:
    return re.sub(r"^```(?!\{glossary\}).*?^```$", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)


def anchors(page: Path) -> set[str]:
    """Names of the headings of a page, as built pages and a viewer of the repository both make them, and its labels."""
    text = without_code(page)
    headings = (
        re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", line).lower() for line in re.findall(r"^#+ (.*)$", text, flags=re.M)
    )
    labels = re.findall(r"^\(([\w-]+)\)=$", text, flags=re.M)
    return {re.sub(r"\s", "-", re.sub(r"[^\w\s-]", "", heading)) for heading in headings} | set(labels)


def lead_nowhere(page: Path) -> list[str]:
    """Links of a page whose file, or whose heading in the file, is not there, and files that it shows or offers."""
    text = page.read_text(encoding="utf-8")
    missing = []
    for link in re.findall(r"\]\((?!https?:|mailto:)([^)\s]+)\)", without_code(page)):
        target, _, anchor = link.partition("#")
        goal = page.parent / target if target else page
        file_is_there = not target or goal.is_dir() or there(target, page)
        if DOCS in page.parents and goal.suffix == ".md" and DOCS not in goal.resolve().parents:
            file_is_there = False  # not where the documentation is built
        if "auto_gallery" in goal.parts:
            file_is_there = False  # not in the repository: a link to the example itself is right in both
        if not file_is_there or (anchor and goal.suffix == ".md" and anchor not in anchors(goal)):
            missing.append(link)
    shown = re.findall(r"^```\{(?:literalinclude|include|image|figure)\} (\S+)", text, flags=re.M)
    offered = re.findall(r"\{download\}`(?:[^`<]*<)?([^`>]+)>?`", text)
    return missing + [name for name in shown + offered if not (page.parent / name).is_file()]


@pytest.mark.parametrize(
    "page",
    [
        *sorted(DOCS.parent.glob("*.md")),
        *sorted((DOCS.parent / "paper").glob("*.md")),
        *(p for p in PAGES if p.suffix == ".md"),
    ],
    ids=lambda page: page.relative_to(DOCS.parent).as_posix(),
)
def test_links_lead_somewhere(page: Path) -> None:
    assert lead_nowhere(page) == []


def test_no_line_is_hidden_as_a_comment() -> None:
    """A line that begins with a per cent sign is one."""
    pages = [page for page in PAGES if page.suffix == ".md"]
    assert {page.name: found for page in pages if (found := re.findall(r"^\s*%.*$", without_code(page), re.M))} == {}


def test_a_link_that_leads_nowhere_is_seen(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(
        "# A `first` heading\n\n[a](#a-first-heading) [b](#second) [c](gone.md) {download}`it <lost.csv>` "
        "[d](auto_gallery/plot_10_series.rst)\n",
        encoding="utf-8",
    )
    assert lead_nowhere(page) == ["#second", "gone.md", "auto_gallery/plot_10_series.rst", "lost.csv"]


def sentences(page: Path) -> set[str]:
    """Those of a page with a dozen words or more, in words alone."""
    text = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", without_code(page))
    pieces = re.split(r"(?<=[.:;!?])\s+|\n\n|\n- | \| ", text)
    return {" ".join(words) for piece in pieces if len(words := re.findall(r"[\w'-]+", piece)) >= 12}


def test_no_sentence_stands_on_two_pages() -> None:
    """But those of the front page, which is the README in short."""
    pages = [page for page in PAGES if page.suffix == ".md" and page.stem not in ("performance", "flags", "warnings")]
    found: dict[str, list[str]] = {}
    for page in (*pages, *(DOCS.parent / name for name in ("CONTRIBUTING.md", "SUPPORT.md", "paper/paper.md"))):
        for sentence in sentences(page):
            found.setdefault(sentence, []).append(page.name)
    assert {sentence: names for sentence, names in found.items() if len(names) > 1} == {}


def runs_of_words(page: Path, length: int) -> set[str]:
    """All of a page's prose with that many words in a row, within a paragraph, without formulas and citations."""
    text = re.sub(r"^---\n.*?^---$|\$\$.*?\$\$|\$[^$]*\$|\{[a-z:]+\}`[^`]*`", "", without_code(page), flags=re.M | re.S)
    text = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", text)
    paragraphs = [re.findall(r"[\w'-]+", part.lower()) for part in re.split(r"\n\n|\n- |\||\n\d\. ", text)]
    return {" ".join(each[i : i + length]) for each in paragraphs for i in range(len(each) - length + 1)}


def test_pages_do_not_repeat_each_other() -> None:
    """Not even a dozen words within longer sentences, but for the front page, which is the README in short."""
    pages = [page for page in PAGES if page.suffix == ".md" and page.stem not in ("flags", "index")]
    root = (*DOCS.parent.glob("*.md"), *DOCS.parent.glob("paper/*.md"))
    found: dict[str, set[str]] = {}
    for page in (*pages, *(page for page in root if page.stem != "CHANGELOG")):
        for words in runs_of_words(page, 13):
            found.setdefault(words, set()).add(page.relative_to(DOCS.parent).as_posix())
    assert {words: names for words, names in found.items() if len(names) > 1} == {}


def test_every_part_is_in_the_list_of_parts() -> None:
    page = (DOCS / "theory" / "systems.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`(?:sp\.)?([A-Z]\w+)", page)) | set(re.findall(r"\{py:class\}`~?springpot\.(\w+)`", page))
    assert set(parts.__all__) - named == set()


def test_the_flags_that_pages_name_exist() -> None:
    """Those in the text and those of commands; what flags there are is on a page that is made of them."""
    flags = {"--help", "--version", "--constraint"}  # the last is SLURM's
    flags |= set(re.findall(r"--[a-z][a-z-]+", (DOCS / "flags.md").read_text(encoding="utf-8")))
    pages = [*DOCS.parent.glob("*.md"), *PAGES, *EXAMPLES]  # the changelog has old names, the other page is of others
    pages = [page for page in pages if page.stem not in ("CHANGELOG", "performance")]
    text = "\n".join(page.read_text(encoding="utf-8") for page in pages)
    commands = re.findall(r"^springpot .*|`springpot [^`]*`|`--[^`]*`", text, flags=re.M)
    named = {flag for command in commands for flag in re.findall(r"(?<!\S)`?(--[a-z][a-z-]+)", command)}
    assert len(named) > 40
    assert named <= flags


def commands(page: Path) -> list[str]:
    """What a page tells to type after the name of the program, in blocks, scripts and the text."""
    text = page.read_text(encoding="utf-8").replace("\\\n", " ")
    blocks = "\n".join(re.findall(r"^```(?:console|shell|bash|sh)\n(.*?)^```$", text, flags=re.M | re.S))
    lines = re.findall(r"^(?:srun |python3 -m )?springpot (.*?)(?: &)?$", blocks, flags=re.M)
    return [*lines, *(" ".join(words.split()) for words in re.findall(r"(?<!`)`springpot ([^`]+)`", text))]


WITH_COMMANDS = [page for page in (*DOCS.parent.glob("*.md"), *PAGES, *EXAMPLES)
                 if page.stem not in ("CHANGELOG", "flags") and commands(page)]  # fmt: skip


@pytest.mark.parametrize("page", WITH_COMMANDS, ids=lambda page: page.stem)
def test_the_commands_of_a_page_are_understood(page: Path) -> None:
    """By the parser of the command; the values that a page leaves out may be missing."""
    for line in commands(page):
        words = [word for word in shlex.split(line) if word not in ("--help", "--version")]
        try:
            cli.app.parse_args(words, exit_on_error=False, print_error=False)
        except MissingArgumentError:
            assert len(words) <= 2, line


def test_a_command_that_does_not_exist_is_seen(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    for line in ("springpot simulat", "springpot simulate --ordr 0.5", "springpot simulate --order much"):
        page.write_text(f"```console\n{line}\n```\n", encoding="utf-8")
        with pytest.raises(CycloptsError):
            test_the_commands_of_a_page_are_understood(page)


def unknown_names(page: Path) -> list[str]:
    """Names of the library in the text, as `sp.simulate` or `springpot.theory.envelope`, that do not exist."""
    missing = []
    for code in re.findall(r"(?<!`)`{1,2}([^`\n]+)`{1,2}", without_code(page)):
        for name in re.findall(
            r"(?<![/\w-])(?:sp|springpot)\.([a-z_]+(?:\.[a-z_]+)*(?:\.[A-Z]\w*)?|[A-Z]\w*(?:\.\w+)*)", code
        ):
            try:
                pydoc.resolve(f"springpot.{name}")
            except ImportError:
                missing.append(name)
    return missing


def test_the_names_in_the_text_exist(tmp_path: Path) -> None:
    pages = (page for page in (*DOCS.parent.glob("*.md"), *PAGES, *EXAMPLES) if page.stem != "CHANGELOG")
    assert {page.name: names for page in pages if (names := unknown_names(page))} == {}
    wrong = tmp_path / "page.md"
    wrong.write_text(
        "`sp.simulat(device)`, `springpot.theory.envelop`, `sp.System.off` and `sp.simulate`\n", encoding="utf-8"
    )
    assert unknown_names(wrong) == ["simulat", "theory.envelop", "System.off"]


def test_each_source_is_cited_and_each_citation_has_a_source() -> None:
    given = re.findall(r"^@\w+\{(\w+),", (DOCS / "references.bib").read_text(encoding="utf-8"), flags=re.M)
    text = "\n".join(page.read_text(encoding="utf-8") for page in PAGES)
    cited = {key for keys in re.findall(r"\{cite:[pt]\}`([^`]+)`", text) for key in keys.split(",")}
    assert given == sorted(given)
    assert cited == set(given)


def test_each_source_can_be_found() -> None:
    """By a DOI, a number in an archive, or a volume, if it is no book; it has authors, a title and a year."""
    text = (DOCS / "references.bib").read_text(encoding="utf-8")
    entries = re.findall(r"^@(\w+)\{(\w+),(.*?)\}\}$", text, flags=re.M | re.S)
    assert len(entries) > 50
    for kind, key, fields in entries:
        names = set(re.findall(r"(\w+) = \{", fields))
        assert {"author", "title", "year"} <= names, key
        assert names & {"doi", "note", "volume", "publisher", "institution"}, key
        assert kind != "article" or names & {"doi", "note", "volume"}, key
        assert int(re.findall(r"\d{4}", key)[0]) == int(re.findall(r"year = \{(\d{4})", fields + "}")[0]), key
        assert all(re.fullmatch(r"10[.]\d{4,}/\S+", doi) for doi in re.findall(r"doi = \{([^}]*)", fields)), key


def test_the_front_page_has_a_picture_and_the_installation() -> None:
    """Before any list of pages; the package is in no registry, so it installs from a clone."""
    top = (DOCS / "index.md").read_text(encoding="utf-8").partition("- [Tutorials]")[0]
    (picture,) = re.findall(r"!\[[^]]*\]\((.*?)\)", top)
    assert (DOCS / picture).is_file()
    assert '```sh\npython3 -m pip install ".[all]"\n```' in top
    (example,) = re.findall(r"^```python\n(.*?)^```$", top, flags=re.M | re.S)
    compile(example, "index.md", "exec")
    pages = [DOCS.parent / "README.md", *PAGES]
    for command in re.findall(
        r"pip install (?!springpot` finds nothing)([^\s`]+)", "".join(map(Path.read_text, pages))
    ):
        assert not re.match(r'"?springpot(?!\[)', command), command  # but an extra of what is installed


def test_numbers_that_several_pages_state_are_those_measured() -> None:
    """Cells of the two validity maps, and bytes that a run holds for a path."""
    cells_of_the_map, systems = (
        len(each.file.read_text(encoding="utf-8").splitlines()) - 1 for each in (PAPER_MAP, SYSTEMS_MAP)
    )
    table = (DOCS.parent / "benchmarks" / "results" / "table.csv").read_text(encoding="utf-8")
    held = {round(float(number)) for number in re.findall(r"^memory held by a run,[^,]*,([\d.]+),", table, flags=re.M)}
    pages = [DOCS.parent / "README.md", *PAGES, *EXAMPLES]
    text = "\n".join(page.read_text(encoding="utf-8") for page in pages if page.stem != "performance")
    assert set(re.findall(r"\b(\d+) (?:cells|points) of the (?:dimensionless|validity)", text)) == {
        str(cells_of_the_map)
    }
    assert set(re.findall(r"\bmap of (\d+) cells", text)) == {str(cells_of_the_map)}
    assert set(re.findall(r"\b(?:on|map has|map, of) (\d+) (?:systems|cells)", text)) == {
        str(cells_of_the_map),
        str(systems),
    }
    assert {f"{number}" for number in held} == set(re.findall(r"\b(\d+) bytes for (?:a|each) path", text))


@pytest.mark.parametrize("page", [page for page in PAGES if cells(page)], ids=name_of)
def test_cells_compile(page: Path) -> None:
    for number, cell in enumerate(cells(page)):
        compile(cell, f"{page.name}, cell {number + 1}", "exec")


def blocks(page: Path, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", page.read_text(encoding="utf-8"), flags=re.M | re.S)


def test_python_that_does_not_run_when_a_page_is_built_compiles() -> None:
    pages = [page for page in (*DOCS.parent.glob("*.md"), *PAGES) if blocks(page, "py(?:thon)?")]
    assert len(pages) >= 6
    for page in pages:
        for block in blocks(page, "py(?:thon)?"):
            compile(block, page.name, "exec")


def test_the_files_of_a_run_are_those_of_the_reference(tmp_path: Path) -> None:
    """What the table of files says of a saved run: which files there are, and what is in them for other programs."""
    run = sp.simulate(sp.Oscillator(), paths=64, duration=20.0, record=1, seed=1)
    for ending in ("nc", "json", "csv"):
        run.save(tmp_path / f"run.{ending}")
    table = re.findall(r"^\| `run[^|]*\|", (DOCS / "reference.md").read_text(encoding="utf-8"), flags=re.M)
    assert set(re.findall(r"`([\w.]+)`", "".join(table))) == {file.name for file in tmp_path.iterdir()}
    with importlib.import_module("xarray").open_dataset(tmp_path / "run.nc") as opened:
        assert opened.equals(run.to_xarray())
    content = json.loads((tmp_path / "run.json").read_text(encoding="utf-8"))
    assert content["run"]
    header, *rows = csv.reader((tmp_path / "run.csv").read_text(encoding="utf-8").splitlines())
    columns = re.findall(r"^\| `run.csv`.*$", (DOCS / "reference.md").read_text(encoding="utf-8"), flags=re.M)
    assert header == [name for name in re.findall(r"`([a-z_]+)`", columns[0]) if name in header]
    assert len(set(header)) == len(header) >= 6
    assert set(run.estimates) <= {row[0] for row in rows}
    assert all(sp.load_run(tmp_path / f"run.{ending}").estimates == run.estimates for ending in ("nc", "json"))


def test_the_studies_from_python_run() -> None:
    (block,) = blocks(DOCS / "studies.md", "python")
    exec(block, {})


@pytest.mark.parametrize("page", [page for page in PAGES if blocks(page, "toml")], ids=name_of)
def test_the_files_in_the_text_are_read(page: Path, tmp_path: Path) -> None:
    """Parts beside a spring and noise, and studies, those of a device with one that has the parts that they name."""
    record = "time_s,acceleration_g\n0,0.1\n0.01,0\n"
    for name in ("north.csv", "east.csv"):
        (tmp_path / name).write_text(record, encoding="utf-8")
    for table in sorted((DOCS / "how_to").glob("*.csv")):
        (tmp_path / table.name).write_text(table.read_text(encoding="utf-8"), encoding="utf-8")
    named = {
        "mount": sp.Springpot(0.3, 150.0),
        "arm": sp.FractionalMaxwell(sp.Springpot(0.5, 100.0), sp.Spring(200.0)),
        "magnet": sp.PolynomialSpring((0.0, 0.0, 1e5)),
    }
    stop, two = {"stop": sp.Barrier(-0.006, 0.7)}, {"upper": sp.Barrier(0.006, 0.7), "lower": sp.Barrier(-0.007, 0.7)}
    for block in map(tomllib.loads, blocks(page, "toml")):
        if "parts" in block:
            kinds = {part["kind"] for part in block["parts"]}
            rest = [sp.Mass(1.0)] * ("mass" not in kinds) + [sp.Spring(100.0)]
            read = sp.read_system(
                {"parts": [*block["parts"], *tomllib.loads(sp.to_toml(sp.System(*rest)))["parts"]]}, tmp_path
            )
            assert len(read.parts) >= len(block["parts"])
        else:
            walls = two if "zipped" in block else stop
            device = sp.System(sp.Mass(0.8), sp.Spring(3200.0), sp.WhiteNoise(1.0), **named, **walls)
            asked = {"name": "asked", "methods": ["monte_carlo"], "axes": {"parts.mount.order": [0.2, 0.3]}} | block
            read_study(asked | ({"system": device} if "system" in asked or "name" not in block else {}))


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_compiles_and_says_what_it_is(example: Path) -> None:
    text = example.read_text(encoding="utf-8")
    tree = ast.parse(text)
    title, line, *_ = (ast.get_docstring(tree) or "").splitlines()
    assert len(line) >= len(title) > 0
    assert set(line) == {"="}
    assert re.fullmatch(r"plot_\d\d_\w+", example.stem)
    assert "plt.show()" in text
    # a figure that pyplot does not know is shown only if a variable of the page holds it
    calls = (node.value.func for node in tree.body if isinstance(node, ast.Expr) and isinstance(node.value, ast.Call))
    assert not {ast.unparse(call) for call in calls} & WHOLE_FIGURES


def test_the_gallery_is_a_gallery() -> None:
    assert len(EXAMPLES) >= 14
    assert len({example.stem[:7] for example in EXAMPLES}) == len(EXAMPLES)  # the numbers order it


# --- the reference ----------------------------------------------------------------------------------------------------


@cache
def reference() -> dict[str, Any]:
    """Every object on the reference page, by its full name."""
    found, module = {}, ""
    for line in (DOCS / "api" / "index.rst").read_text(encoding="utf-8").splitlines():
        if place := re.fullmatch(r"\.\. currentmodule:: (\S+)", line):
            module = place[1]
        elif name := re.fullmatch(r"   (\w+)", line):
            found[f"{module}.{name[1]}"] = getattr(importlib.import_module(module), name[1])
    return found


def members(kind: type) -> dict[str, Any]:
    """Public methods and properties of a class of ours."""
    return {
        name: getattr(member, "fget", None) or member
        for base in kind.__mro__
        if base.__module__.startswith("springpot")
        for name, member in vars(base).items()
        if not name.startswith("_") and (inspect.isfunction(member) or isinstance(member, property))
    }


def test_every_public_name_is_in_the_reference() -> None:
    shown = {id(thing) for thing in reference().values()}
    for module in map(importlib.import_module, PUBLIC):
        for name in module.__all__:
            thing = getattr(module, name)
            assert inspect.ismodule(thing) or id(thing) in shown, f"{module.__name__}.{name}"


FUNCTIONS = [name for name, thing in reference().items() if inspect.isfunction(thing)]
CLASSES = [name for name, thing in reference().items() if inspect.isclass(thing)]


def sections(text: str) -> set[str]:
    return set(re.findall(r"^(\w+)\n-+$", text, flags=re.M))


def lacks(function: Any, *, example: bool) -> set[str]:
    """Sections of numpydoc that a function should have and has not."""
    text = inspect.getdoc(function) or ""
    if re.search(r"(Parameters and errors are those of|which are the same)", text):
        return set() if not example or ">>>" in text else {"Examples"}
    signature = inspect.signature(function)
    missing = set()
    arguments = [name for name in signature.parameters if name not in ("self", "cls")]
    if arguments and "Parameters" not in sections(text):
        missing.add("Parameters")
    returned = str(signature.return_annotation)
    if returned not in ("None", "<class 'inspect._empty'>") and not sections(text) & {"Returns", "Yields"}:
        missing.add("Returns")
    tree = ast.parse(inspect.cleandoc("\n" + inspect.getsource(function)))
    if any(isinstance(node, ast.Raise) for node in ast.walk(tree)) and "Raises" not in sections(text):
        missing.add("Raises")
    if example and ">>>" not in text:
        missing.add("Examples")
    return missing


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_function_says_what_it_takes_gives_and_refuses(name: str) -> None:
    function = reference()[name]
    assert not lacks(function, example=True)
    text = inspect.getdoc(function) or ""
    if "Parameters" in sections(text):
        described = text.split("Parameters\n----------\n", 1)[1].split("\n\n", 1)[0]
        told = {word.strip("*") for line in described.splitlines() if line[:1].strip()
                for word in line.split(":")[0].replace(" ", "").split(",")}  # fmt: skip
        given = {name for name, kind in inspect.signature(function).parameters.items() if kind.kind != kind.VAR_KEYWORD}
        assert given <= told | {"progress"}


@pytest.mark.parametrize("name", CLASSES)
def test_a_class_says_what_it_holds(name: str) -> None:
    kind = reference()[name]
    text = inspect.getdoc(kind) or ""
    assert text
    if hasattr(kind, "__dataclass_fields__") and "those of `" not in text:
        assert sections(text) & {"Parameters", "Attributes"}
    for member, function in members(kind).items():
        assert inspect.getdoc(function), f"{name}.{member}"
        said = inspect.getdoc(function).split("Examples\n---")[0]
        assert not re.search(r"(?<![\\`\w])\|\w", said), f"{name}.{member}"  # a bar begins a substitution


METAPHORS = r"\b(dice|the ear|ears|hears?|heard|astray|owes?|owed|whom to believe)\b"


@pytest.mark.parametrize(
    "text",
    [*PAGES, *EXAMPLES, DOCS.parent / "README.md", DOCS.parent / "CONTRIBUTING.md"],
    ids=lambda text: text.name,
)
def test_the_prose_has_no_metaphors(text: Path) -> None:
    assert re.findall(METAPHORS, text.read_text(encoding="utf-8"), flags=re.I) == []


def test_the_source_has_no_metaphors() -> None:
    source = DOCS.parent / "src" / "springpot"
    found = {
        file.relative_to(source).as_posix(): words
        for file in [*source.rglob("*.py"), *source.rglob("*.js")]
        if "vendor" not in file.parts and (words := re.findall(METAPHORS, file.read_text(encoding="utf-8"), flags=re.I))
    }
    assert found == {}
