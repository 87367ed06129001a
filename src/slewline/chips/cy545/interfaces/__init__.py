"""The ways in and out: parallel and serial side, local bus, display, user bits."""
