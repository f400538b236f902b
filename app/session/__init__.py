"""One visitor: the run on screen, the controls, the messages to and from the browser."""
