"""What comes with the workflow fits together: configuration, table, environment, profiles."""

import json
import re
import tomllib
from pathlib import Path

import pytest
import yaml

from roughcontact.arguments.settings.resolve import resolve
from roughcontact.study.table.read import read_surfaces

ROOT = Path(__file__).parents[2]


def test_the_shipped_configuration_names_maps_that_are_there():
    (settings,) = resolve(yaml.safe_load((ROOT / "config/config.yaml").read_text())).values()
    surfaces = read_surfaces(ROOT / settings["surfaces"], [ROOT])
    assert len(surfaces) >= 3
    assert len({surface.path.suffix for surface in surfaces.values()}) >= 3
    for surface in surfaces.values():
        assert surface.path.is_file()
        assert surface.path.stat().st_size < 1e6


def test_the_study_of_the_tests_names_a_map_that_is_there():
    (settings,) = resolve(yaml.safe_load((ROOT / ".test/config/config.yaml").read_text())).values()
    assert list(read_surfaces(ROOT / ".test" / settings["surfaces"], [ROOT])) == ["periodic"]


def test_the_conda_environment_has_the_packages_of_the_project():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    environment = yaml.safe_load((ROOT / "workflow/envs/roughcontact.yaml").read_text())["dependencies"]
    lines = [line for line in environment if isinstance(line, str)] + environment[-1]["pip"]
    names = {"matplotlib-base": "matplotlib"}
    versions = {}
    for line in lines:
        name, lowest = re.fullmatch(r"([\w-]+) *(>=[\d.]+)?.*", line).groups()
        versions[names.get(name, name).lower()] = lowest
    requirements = [f"python{project['requires-python']}", *project["dependencies"]]
    lowest_wanted = dict(re.match(r"([\w-]+)(>=[\d.]+)", line).groups() for line in requirements)
    assert versions == {name.lower(): lowest for name, lowest in lowest_wanted.items()} | {"pip": None}


def test_the_recipe_has_the_packages_of_the_project():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    recipe = yaml.safe_load((ROOT / "recipe/recipe.yaml").read_text())
    assert recipe["context"]["version"] == project["version"]
    names = {"matplotlib-base": "matplotlib", "snakemake-minimal": "snakemake"}
    limits_of_recipe = dict(line.split(" ", 1) for line in recipe["requirements"]["run"])
    requirements = [*project["dependencies"], *project["optional-dependencies"]["workflow"]]
    limits = dict(re.match(r"([\w-]+)(>=[\d.]+(?:,<[\d.]+)?)", line).groups() for line in requirements)
    limits["python"] = project["requires-python"]
    assert {names.get(name, name): limit for name, limit in limits_of_recipe.items()} == {
        name.lower(): limit for name, limit in limits.items()
    }


def test_the_version_is_the_same_everywhere():
    version = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    archive = json.loads((ROOT / ".zenodo.json").read_text())
    paper = yaml.safe_load((ROOT / "paper/paper.md").read_text(encoding="utf-8").split("---\n")[1])
    assert citation["version"] == version
    assert (ROOT / "CHANGELOG.md").read_text(encoding="utf-8").splitlines()[2].startswith(f"## {version} ")
    assert archive["title"] == citation["title"]
    assert archive["keywords"] == citation["keywords"]
    assert archive["license"] == citation["license"]
    authors = [author["name"] for author in citation["authors"]]
    assert [author["name"] for author in archive["creators"]] == authors
    assert [author["name"] for author in paper["authors"]] == authors


def test_the_paper_is_short_and_every_source_has_an_entry():
    text = (ROOT / "paper/paper.md").read_text(encoding="utf-8").split("---\n", 2)[2]
    assert len(text.split()) <= 1000
    entries = re.findall(
        r"^@\w+\{(\w+),(.*?)^\}", (ROOT / "paper/paper.bib").read_text(), re.MULTILINE | re.DOTALL
    )
    assert {name for name, _ in entries} == set(re.findall(r"@(\w+)", text))
    assert all(re.search(r"doi = \{10\.\d+/\S+\}", body) for _, body in entries)


def test_a_wheel_has_every_file_that_the_package_reads():
    package, project = (
        ROOT / "workflow/lib/roughcontact",
        tomllib.loads((ROOT / "pyproject.toml").read_text()),
    )
    patterns = project["tool"]["setuptools"]["package-data"]["roughcontact"]
    shipped = {path for pattern in patterns for path in package.glob(pattern)}
    modules = {path for path in package.rglob("*.py*") if path.suffix in (".py", ".pyc")}
    compiled = set((package / "kernels").rglob("*"))  # the library of the C source is added by setup.py
    assert {path for path in package.rglob("*") if path.is_file()} - modules - compiled == shipped


def test_every_platform_of_setup_is_run_before_a_release():
    targets = (ROOT / "setup.py").read_text().partition("TARGETS = {")[2].partition("}")[0]
    workflow = yaml.safe_load((ROOT / ".github/workflows/release.yml").read_text())["jobs"]
    matrices = [workflow[job]["strategy"]["matrix"]["include"] for job in ("run", "run-musl")]
    assert sorted(row_of_matrix["wheel"] for rows in matrices for row_of_matrix in rows) == sorted(
        re.findall(r'"(\w+)":', targets)
    )
    assert set(workflow["publish"]["needs"]) == {"run", "run-musl"}


def test_actions_are_pinned_by_commit_and_kept_up_to_date():
    workflows = sorted((ROOT / ".github/workflows").glob("*.yml"))
    used = [line for path in workflows for line in re.findall(r"uses: (.+)", path.read_text())]
    assert len(used) > 20
    assert [line for line in used if not re.fullmatch(r"[\w./-]+@[0-9a-f]{40} # v[\d.]+", line)] == []
    updates = yaml.safe_load((ROOT / ".github/dependabot.yml").read_text())["updates"]
    assert {update["package-ecosystem"] for update in updates} == {"github-actions", "pip", "docker"}


def test_pull_requests_run_on_the_three_systems():
    workflow = yaml.safe_load((ROOT / ".github/workflows/ci.yml").read_text())
    assert "pull_request" in workflow[True]  # YAML 1.1 reads the key `on` as a truth value
    systems = {*workflow["jobs"]["systems"]["strategy"]["matrix"]["system"]}
    assert systems | {workflow["jobs"]["everything"]["runs-on"]} == {
        "ubuntu-latest",
        "macos-latest",
        "windows-latest",
    }


def test_the_lowest_versions_are_the_same_everywhere():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    requirements = " ".join(project["optional-dependencies"]["workflow"])
    lowest = {
        "Python": project["requires-python"].removeprefix(">="),
        "Snakemake": re.match(r"snakemake>=([\d.]+),<\d+$", requirements)[1],
    }
    assert f'\nmin_version("{lowest["Snakemake"]}")\n' in (ROOT / "workflow/Snakefile").read_text()
    pages = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").rglob("*.md")]
    text = "\n".join(page.read_text(encoding="utf-8") for page in pages)
    named = re.findall(r"(Python|Snakemake)\s+(\d[\d.]*\d)\s+or\s+later", text)
    assert {name for name, _ in named} == set(lowest)
    assert all(lowest[name] == version for name, version in named)


def test_the_container_installs_what_is_here():
    """No test builds it; its own commands are those by which `.ci/run` installs the wheel."""
    recipe = (ROOT / "Dockerfile").read_text()
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    lowest = project["requires-python"].removeprefix(">=")
    versions = re.findall(r"^FROM python:(\d+)\.(\d+)-", recipe, re.MULTILINE)
    assert versions
    assert all([int(n) for n in version] >= [int(n) for n in lowest.split(".")] for version in versions)


@pytest.mark.parametrize("rules", sorted((ROOT / "workflow/rules").glob("*.smk")), ids=lambda path: path.stem)
def test_every_rule_has_the_script_and_the_log_of_its_name(rules):
    for rule in re.findall(
        r"^ *rule (\w+):\n(.*?)(?=^ *rule |\Z)", rules.read_text(), re.DOTALL | re.MULTILINE
    ):
        name, body = rule
        assert '"""' in body
        assert f'"../scripts/{name}.py"' in body
        assert f"{name}.log" in body
        assert (ROOT / f"workflow/scripts/{name}.py").is_file()


@pytest.mark.parametrize(
    "script", sorted((ROOT / "workflow/scripts").glob("[a-z]*.py")), ids=lambda p: p.stem
)
def test_scripts_are_thin(script):
    assert len(script.read_text().splitlines()) < 60
