"""What a notebook shows of chips, steps and shafts: HTML and SVG in which nothing runs, in the colours of the page."""
