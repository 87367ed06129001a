"""Lines between hosts and modules: characters, pace, transcript, framing, stores."""
