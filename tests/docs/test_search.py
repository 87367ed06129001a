"""The search of the built pages leads to the page that a reader means, by the words of the trade (docs/search.toml)."""

from __future__ import annotations

import tomllib

import pytest

from .blocks import ROOT

WORDS = tomllib.loads((ROOT / "docs/search.toml").read_text("utf-8"))
PLAIN = {  # as readers type: in other letters, cut short, in other order, in words that no entry has
    "intelligent stepper": "reference/chips",
    "labview": "howto/old_programs",
    "rs-232 STEPPER": "howto/serve",
    "serial por": "howto/serve",
    "8255 ppi": "reference/parts",
    "recording of a logic analyser": "howto/measured_recordings",
    "bench files": "howto/bench_files",
}
INSIDE = (
    *("decisions/", "explanation/code_flow", "explanation/promises", "explanation/tour", "explanation/where"),
    "reference/conformance",
)
ORDINARY = ("velocity", "position", "baud", "timeout", "step", "reset", "pulse", "register", "interrupt", "crystal")

ASK = "words => { document.getElementById('search-results').replaceChildren(); Search.performSearch(words); }"
OVER = "/finished|did not match/.test(document.getElementById('search-results').innerText)"


@pytest.fixture(scope="module")
def search(built, browser):
    """Return the pages that a search finds, the best first."""
    page = browser.new_page()
    page.goto((built / "search.html").as_uri() + "?q=slewline")
    page.evaluate("DOCUMENTATION_OPTIONS.SHOW_SEARCH_SUMMARY = false")  # it fetches every page that it lists
    page.wait_for_function(OVER)  # else what is left of it would come among what the next one finds

    def found(words):
        page.evaluate(ASK, words)
        page.wait_for_function(OVER)
        links = page.locator("ul.search a").evaluate_all("all => all.map(one => one.getAttribute('href'))")
        return [link.partition(".html")[0] for link in links]

    yield found
    page.close()


@pytest.mark.parametrize("page", WORDS)
def test_each_word_of_the_trade_finds_its_page_first(search, page):
    assert {word: search(word)[0] for word in WORDS[page]} == dict.fromkeys(WORDS[page], page)


@pytest.mark.parametrize("words", PLAIN)
def test_other_words_find_the_intended_page(search, words):
    assert search(words)[0] == PLAIN[words]


@pytest.mark.parametrize("word", ORDINARY)
def test_pages_for_contributors_are_ranked_below_the_others(search, word):
    found = search(word)
    assert len(found) > 10
    assert [page for page in found[:10] if page.startswith(INSIDE)] == []


def test_each_word_leads_to_one_page_that_exists():
    assert [page for page in WORDS if not (ROOT / f"docs/{page}.md").exists()] == []
    words = [word.lower() for page in WORDS for word in WORDS[page]]
    assert sorted({*words}) == sorted(words)


def test_the_first_page_names_words_that_the_search_knows():
    text = (ROOT / "docs/index.md").read_text("utf-8").partition("of the trade: try ")[2].partition(".\n")[0]
    named = [word.strip("*\n ") for word in text.split(",")]
    assert len(named) >= 5 and {*named} <= {word for page in WORDS for word in WORDS[page]}
