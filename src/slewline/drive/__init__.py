"""Real motors: a board that makes the steps of a model, from the bytes on its wire to the axis that it drives."""
