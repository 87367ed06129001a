"""A picture on a page that its block does not draw is found."""

from __future__ import annotations

import pytest
from sybil.example import SybilFailure

from .blocks import run_page
from .refresh import refresh

LINE = '<svg xmlns="http://www.w3.org/2000/svg"><path id="{id}" d="M {x} 2.5 L 3 4"/><text x="1">{text}</text></svg>'
DRAWS = "```python\nfrom pathlib import Path\n\nPath('line.svg').write_text({svg!r})\n```\n\n{image}\n"
SHOWN = "![A line](images/line.svg)"


def line(x="1.25", text="t = 12.34 µs", id="m0123456789"):
    return LINE.format(x=x, text=text, id=id)


@pytest.fixture
def page(tmp_path, monkeypatch):
    """Write a page whose block draws a line, beside the picture that is kept."""
    (tmp_path / "images").mkdir()
    (tmp_path / "run").mkdir()
    monkeypatch.chdir(tmp_path / "run")

    def page(kept, image=SHOWN, svg=None):
        if kept is not None:
            (tmp_path / "images/line.svg").write_text(kept, "utf-8")
        path = tmp_path / "page.md"
        path.write_text(DRAWS.format(svg=svg or line(), image=image), "utf-8")
        return path

    return page


@pytest.mark.parametrize("kept", [line(), line(x="1.250001", id="mabcdef0123"), line(x="1.29")])
def test_the_same_picture_may_differ_invisibly(page, kept):
    assert run_page(page(kept)) == 1


@pytest.mark.parametrize(
    ("kept", "image", "says"),
    [
        (None, SHOWN, "not there yet"),
        (line(x="1.5"), SHOWN, "another picture is drawn"),
        (line(text="t = 12.35 µs"), SHOWN, "another picture is drawn"),
        (line().replace("L 3 4", "L 3 4 L 5 6"), SHOWN, "another picture is drawn"),
        (line().replace("<text", '<path d="M 0 0"/><text'), SHOWN, "another picture is drawn"),
        ("\x89PNG", SHOWN, "another picture is drawn"),
        (line(), "![ ](images/line.svg)", "say in the brackets"),
        (line(), "![A line](images/curve.svg)", "no block before the picture writes curve.svg"),
    ],
)
def test_mistakes_in_a_picture_are_reported(page, kept, image, says):
    with pytest.raises(SybilFailure, match=says):
        run_page(page(kept, image))


def test_a_picture_in_front_of_its_block_is_wrong(page):
    path = page(line())
    path.write_text(f"{SHOWN}\n\n{path.read_text('utf-8')}", "utf-8")
    with pytest.raises(SybilFailure, match="no block before"):
        run_page(path)


def test_refresh_draws_what_has_changed_and_leaves_the_rest(page, tmp_path):
    kept = tmp_path / "images/line.svg"
    for old, new in ((line(x="7"), line()), (None, line()), (line(x="1.26"), line(x="1.26"))):
        path = page(old)
        refresh(path, ("python",))
        assert kept.read_text("utf-8") == new
        assert run_page(path) == 1


def test_on_other_pages_text_is_output_only_after_a_block_that_prints(tmp_path):
    page, art, prints = tmp_path / "page.md", "```text\n--->\n```\n", "```python\nprint(1)\n```\n"
    for text, fails in ((art, False), (prints + "```text\n1\n```\n" + art, False), (prints + art, True)):
        page.write_text(text, "utf-8")
        if fails:
            with pytest.raises(SybilFailure, match="but this was printed"):
                run_page(page, ("python",))
        else:
            assert run_page(page, ("python",)) == (prints in text)
