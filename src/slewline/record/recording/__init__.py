"""The recorded history of nets, reduced for pictures and written as columns."""
