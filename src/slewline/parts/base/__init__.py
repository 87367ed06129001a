"""What parts are made of: pins, queues of work, and promises that follow from those of their inputs."""
