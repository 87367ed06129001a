"""The debugger in the terminal: chips, their programs and the conversation on one screen."""
