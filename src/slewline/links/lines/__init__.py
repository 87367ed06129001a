"""Lines between the outside and the modules: characters, pace, transcript, framing, stores."""
