"""Commands that go on until they are ended: serve, panel, debug; and the processes that they start."""
