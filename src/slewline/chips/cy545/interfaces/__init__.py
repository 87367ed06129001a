"""The interfaces: parallel and serial sides, local bus, display and user bits."""
