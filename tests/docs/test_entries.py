"""The entries of the API as they are built: anchors, signatures, and links that lead to them."""

from __future__ import annotations

import re

from . import entries


def page(built, name):
    return (built / "reference" / f"{name}.html").read_text("utf-8")


def test_every_entry_has_an_anchor_and_a_signature_that_can_be_read(built):
    pages = {path.stem: page(built, f"api/{path.stem}") for path in entries.PAGES}
    anchors = {anchor for text in pages.values() for anchor in re.findall(r'<dt class="[^"]*" id="([\w.]+)"', text)}
    assert [entry for entry in entries.ENTRIES if ".".join(entry) not in anchors] == []
    unreadable = re.compile(r" object at 0x|~slewline|TypeAliasForwardRef|&lt;factory&gt;| -- ")
    assert [name for name, text in pages.items() if unreadable.search(text)] == []


def test_names_in_docstrings_and_on_pages_lead_to_their_entry(built):
    bench = page(built, "api/bench")
    assert 'href="host.html#slewline.parts.hosts.host.Host"' in bench  # what Bench.host returns
    assert 'href="errors.html#slewline.errors.UnknownName"' in bench
    assert 'href="#slewline.Bench.figure"' in bench
    assert 'href="../reference/api/bench.html#slewline.Bench.record"' in page(built, "../howto/waveforms")


def test_a_fact_has_an_anchor_and_its_test_a_link(built):
    facts = page(built, "conformance_cy512")
    assert '<a id="CY512-SET-1" href="#CY512-SET-1">CY512-SET-1</a>' in facts
    assert re.search(r'<a class="[^"]*" [^>]*href="[^"]*/test_cy512_\w+\.py"', facts)
