"""Lines between hosts and the modules: characters, pace, transcript, framing, stores."""
