"""CITATION.cff says what CFF 1.2.0 requires, and of the release that this is."""

from pathlib import Path
import re

import refimpl

ROOT = Path(refimpl.__file__).parent.parent
TEXT = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
TOP = dict(re.findall(r"^([a-z-]+): *(.*)$", TEXT, re.MULTILINE))
PAPERS = TEXT.partition("references:\n")[2].split("  - type: ")[1:]


def test_every_line_is_a_key_or_an_item():
    for line in TEXT.splitlines():
        assert re.fullmatch(r'(  )*(- )?[a-z-]+:( ("[^"]+"|[^":#]+))?', line), line


def test_the_required_keys_and_the_release():
    assert {"cff-version", "message", "title", "authors"} <= set(TOP)
    assert TOP["cff-version"] == "1.2.0"
    assert TOP["version"] == refimpl.__version__ and TOP["license"] == "MIT"
    assert '  - name: "The refimpl authors"\n' in TEXT


def test_each_paper_has_title_authors_and_year():
    assert [re.findall("family-names: (.*)", paper) for paper in PAPERS] == [
        ["Holden", "Habibie", "Kusajima", "Komura"], ["Holden", "Saito", "Komura"],
        ["Torresani", "Hackney", "Bregler"],
        ["Kobayashi", "Liao", "Inoue", "Yojima", "Takahashi"]]
    for paper in PAPERS:
        assert len(re.findall("given-names: ", paper)) == len(re.findall("family-names: ", paper))
        assert 'title: "' in paper and re.search(r"    year: 20\d\d\n", paper)
    assert [re.findall(r"doi: (10\.\d{4,}/\S+)", paper) for paper in PAPERS] == [
        ["10.1109/MCG.2017.3271464"], ["10.1145/2897824.2925975"], [],
        ["10.48550/arXiv.2306.08861"]]
    assert "papers.nips.cc/paper/2006/" in PAPERS[2]             # its DOI is not certain


def test_the_package_page_links_what_is_cited():
    package = (ROOT / "PACKAGE.md").read_text(encoding="utf-8")
    metadata = (ROOT / "setup.cfg").read_text(encoding="utf-8")
    for paper in PAPERS:
        found, = re.findall(r"doi: (\S+)|url: \"(\S+)\"", paper)
        link = found[1] or f"https://doi.org/{found[0]}".replace("doi.org/10.48550/arXiv.",
                                                                 "arxiv.org/abs/")
        assert link in package and link in metadata
