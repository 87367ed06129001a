"""A dialogue against the model: exchanges, a replay in virtual time, and what differs; or played to a module now."""
