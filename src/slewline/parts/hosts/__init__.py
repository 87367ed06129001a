"""Host computers, one for each way to reach a chip."""
