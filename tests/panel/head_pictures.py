"""Pictures of screens on the pages: `python -m tests.panel.head_pictures` draws them anew.  Look at them.

The panel shows the welding machine in the middle of its work, the debugger its program at an instruction; both stand at
an instant, so that the pictures stay as they are.  The notebook has the code of its page in its cells.
"""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from html import escape
from pathlib import Path

from slewline.cli.live.debug import server_process
from tests.browsers import chromium, opened, own_folder

from .conftest import PanelProcess
from .terminal.walks import EXAMPLES, ROOT, walked, weld

IMAGES = ROOT / "docs/images"
PANEL, DEBUGGER, NOTEBOOK = (IMAGES / f"{name}.png" for name in ("panel", "debugger", "notebook"))
PAGE = ROOT / "docs/howto/notebooks.md"
CELLS = 3  # of the page, from the first one on
CELL = "background:#f5f7f8;border:1px solid #d9dfe4;padding:8px 12px;margin:18px 0 8px;font:13px/1.5 'DejaVu Sans Mono'"
MACHINE = ROOT / "src/slewline/cli/weld.toml"
INSTANT = "3.35 s"
WIDE, HIGH = 1440, 1640
COLOURS = 48


def made_small(path):
    """Keep the colours that there are, of which a screen has few: a picture is a third as large then."""
    from PIL import Image

    Image.open(path).convert("RGB").quantize(COLOURS).save(path, optimize=True)


def draw_panel(path, before=1.0):
    """Draw the page; after `before` (s) the run is not in real time, and the strips have a gap."""
    with server_process([str(MACHINE)]) as (address, token), opened() as browser:
        panel = PanelProcess(address, token=token)
        try:
            page = browser.new_page(viewport={"width": WIDE, "height": HIGH}, color_scheme="light")
            page.goto(panel.url)
            page.wait_for_selector(".chip-card .figure")
            page.wait_for_selector("canvas")
            page.wait_for_timeout(1000)  # the scope records from the first instant on
            page.get_by_role("button", name="Run the program", exact=True).click()
            page.wait_for_function(  # well before the instant, however slow the page is
                f"() => parseFloat(document.querySelector('.clock').innerText.replace(/\\s/g, '')) > {before}"
            )
            page.get_by_label("Target of the run").fill(INSTANT)
            page.get_by_label("Target of the run").press("Enter")
            page.wait_for_function("() => /3.350.000/.test(document.body.innerText)")
            page.wait_for_timeout(1500)  # shafts come to rest, the scope asks for its window
            page.screenshot(path=path)
            made_small(path)
        finally:
            panel.close()


def draw_debugger(path):
    """Draw the terminal, with a font of this machine: its picture would fetch one from elsewhere."""
    pictures = []

    async def way(walk):
        await weld(walk)
        pictures.append(walk.app.export_screenshot(title="slewline debug"))

    walked([str(EXAMPLES / "programs/weld.cy525")], (120, 34), way)
    svg = re.sub(r"@font-face \{.*?\}", "", pictures[0], flags=re.DOTALL)
    width, height = (round(float(size)) for size in re.findall(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', svg)[0])
    with own_folder() as environment:
        folder = environment["TMPDIR"]
        source = Path(folder) / "debugger.svg"
        source.write_text(svg, "utf-8")
        command = [chromium(), "--headless", "--no-sandbox", "--hide-scrollbars", "--disable-gpu"]
        size = f"--window-size={width},{height}"
        subprocess.run(
            [*command, size, f"--screenshot={path}", source.as_uri()], check=True, capture_output=True, env=environment
        )
    made_small(path)


def draw_notebook(path):
    """Draw the first cells of the page as a notebook: each with what its last line shows."""
    names, shown = {}, []
    for code in re.findall(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)[:CELLS]:
        *statements, last = ast.parse(code).body
        exec(compile(ast.Module(statements, []), PAGE.name, "exec"), names)
        value = eval(compile(ast.Expression(last.value), PAGE.name, "eval"), names)
        shown.append(f'<pre style="{CELL}">{escape(code.strip())}</pre>{value._repr_html_()}')
    with opened() as browser:
        page = browser.new_page(viewport={"width": 980, "height": 600}, reduced_motion="reduce")
        page.set_content(f"<body style='margin:4px 24px 16px'>{''.join(shown)}")
        page.screenshot(path=path, full_page=True)
        made_small(path)


if __name__ == "__main__":
    if chromium() is None:
        sys.exit("no Chromium is installed")
    draw_panel(PANEL, 3.1)
    draw_debugger(DEBUGGER)
    draw_notebook(NOTEBOOK)
